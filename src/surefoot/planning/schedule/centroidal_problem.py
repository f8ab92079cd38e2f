"""A centroidal motion that is asked for: a body on feet, a schedule, where it starts, what it costs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, finite_array, real_number, whole_number
from surefoot.control.contact_schedule import ContactSchedule
from surefoot.errors import ProblemError
from surefoot.planning.direct.problem import Window
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain, Terrain


@dataclass(frozen=True)
class CentroidalWeights:
    """What a second of motion costs.

    Attributes
    ----------
    position, orientation
        Of the distance from the reference, squared [1/m², 1 per quaternion entry squared].
    velocity
        Of the centre's velocity, squared [s²/m²].
    momentum
        Of the angular momentum's distance from its reference per mass, squared [s²/m⁴].
    force
        Of forces as shares of m g, squared [-].
    foothold
        Of the distance of footholds that stand from their places below the hips, squared [1/m²].
    """

    position: float = 2.0
    orientation: float = 10.0
    velocity: float = 0.01
    momentum: float = 1.0
    force: float = 1.0
    foothold: float = 1.0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            real_number(name, getattr(self, name), low=0.0)


@dataclass(frozen=True, eq=False)
class CentroidalProblem:
    """A motion that is asked for; poses are centre of mass and quaternion (x, y, z, w), as in Pinocchio.

    Attributes
    ----------
    mass, inertia
        [kg], and (3, 3) about the centre of mass, body axes [kg m²].
    stand
        (n, 3) where the feet are below the hips, from the centre of mass, body axes [m].
    schedule
        When each foot stands.
    dt, knots
        Length of a knot [s], and number of knots.
    pose, velocity
        (7,) at the start [m, -], (6,) velocity and angular momentum there [m/s, N m s].
    feet
        (n, 3) where the feet stand at the start [m]; those in the air do not matter.
    reference
        (knots + 1, 7) poses that cost nothing [m, -]; the quaternions of a full turn change their sign.
    momentum
        (3,) angular momentum that costs nothing, world axes [N m s].
    windows
        Bounds on poses (7,) and velocities with momenta (6,) of some knots, by their number.
    weights
        See `CentroidalWeights`.
    mu
        Friction that may be used [-].
    terrain
        A plane.
    reach
        (3,) half size of the box about `stand` in which a foot may stand, body axes [m].
    force_min, force_max
        Normal force of a foot that stands [N].
    momentum_bound
        (3,) largest size of the angular momentum at all knots but the first, world axes [N m s].

    Raises
    ------
    ProblemError
        For arrays that do not fit, numbers out of range, ground that is no plane, and a momentum bound that
        is not positive.
    """

    mass: float
    inertia: FloatArray
    stand: FloatArray
    schedule: ContactSchedule
    dt: float
    knots: int
    pose: FloatArray
    velocity: FloatArray
    feet: FloatArray
    reference: FloatArray
    momentum: FloatArray = field(default_factory=lambda: np.zeros(3))
    windows: Mapping[int, Window] = field(default_factory=dict)
    weights: CentroidalWeights = field(default_factory=CentroidalWeights)
    mu: float = 0.5
    terrain: Terrain = field(default_factory=FlatTerrain)
    reach: FloatArray = field(default_factory=lambda: np.array([0.15, 0.1, 0.12]))
    force_min: float = 0.0
    force_max: float = math.inf
    momentum_bound: FloatArray = field(default_factory=lambda: np.full(3, math.inf))

    def __post_init__(self) -> None:
        n = self.schedule.feet
        real_number("mass", self.mass, low=1e-6, high=1e9)
        real_number("dt", self.dt, low=1e-4, high=0.5)
        whole_number("knots", self.knots, low=2)
        real_number("mu", self.mu, low=1e-3, high=1e6)
        real_number("force_min", self.force_min, low=0.0, high=1e9)
        real_number("force_max", self.force_max, low=self.force_min)
        if not self.terrain.planar:
            raise ProblemError(f"a centroidal motion takes a plane for ground, got {self.terrain!r}")
        shapes = {
            "inertia": (3, 3), "stand": (n, 3), "pose": (7,), "velocity": (6,), "feet": (n, 3),
            "reference": (self.knots + 1, 7), "momentum": (3,), "reach": (3,),
        }  # fmt: skip
        for name, shape in shapes.items():
            object.__setattr__(self, name, finite_array(name, getattr(self, name), shape))
        even = np.allclose(self.inertia, self.inertia.T, rtol=1e-6)
        if not even or np.linalg.eigvalsh(self.inertia)[0] <= 0.0:
            raise ProblemError("inertia must be symmetric and positive definite")
        if (self.reach < 0.0).any():
            raise ProblemError(f"reach must be >= 0, got {self.reach}")
        bound = np.broadcast_to(np.asarray(self.momentum_bound, dtype=np.float64), (3,))
        if not (bound > 0.0).all():
            told = "a body that may have no angular momentum cannot turn"
            raise ProblemError(f"momentum_bound must be > 0 [N m s], got {bound}: {told}")
        object.__setattr__(self, "momentum_bound", bound)
        for k in self.windows:
            if not 0 < k <= self.knots:
                raise ProblemError(f"windows are of knots 1 to {self.knots}, got {k}")

    @property
    def weight(self) -> float:
        """M g [N]."""
        return self.mass * GRAVITY

    @property
    def stance(self) -> BoolArray:
        """(knots, n) which feet stand in each knot."""
        return self.schedule.horizon(0.0, self.dt, self.knots)

    @property
    def frame(self) -> FloatArray:
        """(3, 3) axes of the ground, the normal last."""
        return np.asarray(self.terrain.frame([0.0, 0.0]))

    @property
    def origin(self) -> FloatArray:
        """(3,) the point of the ground that footholds are measured from [m]."""
        return np.array([0.0, 0.0, float(self.terrain.height([0.0, 0.0]))])
