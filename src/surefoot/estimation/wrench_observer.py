"""What pushes a walking robot from outside: a payload that it was not told, and the wrench that is left.

The six rows of the floating base in M a + h = Sᵀ τ + Σ Jᵀ f + w say what the ground's forces leave over of
the motion; the forces are those that the legs' own rows ask for, from commanded torques. Accelerations are
changes of the velocity from step to step: averaged over a block of steps they are the change of momentum over
it, as in a momentum observer [1]_, and their noise does not add up. A Kalman filter splits a block's mean:

    w = weight of a mass m at r on the base  +  rest

linear in m and m r, which hardly change (the payload), with a rest that fades within a fraction of a second
(pushes, wind, friction in the legs). The weight alone is looked for: a load's inertia becomes part of the
model once the load is known, and held against measured accelerations their noise would pass for one. So how
high it lies shows only while the base leans.

References
----------
.. [1] A. De Luca, R. Mattone, "Sensorless robot collision detection and hybrid force/motion control",
   ICRA 2005.
.. [2] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.estimation import wrench_kernels as kernels
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY


@dataclass(frozen=True)
class ObserverSettings:
    """How a wrench is split; masses are shares of the robot's m, forces of m g, places of its height h.

    Attributes
    ----------
    block
        Time over which the wrench is averaged [s].
    mass, place
        Standard deviation of the payload's mass, and of its first moment over m h.
    memory
        Time in which a payload may become another [s]; its height, which a level robot cannot tell, is
        forgotten within it.
    force, moment
        Standard deviation of the rest, and of its moment over m g h.
    fading
        Time in which the rest fades [s].
    noise_force, noise_moment
        Standard deviation of a block's mean at least; more where it changes more from block to block.
    watch
        Time over which those changes are watched [s].
    least, most
        Bounds on the payload's mass; negative where the robot is lighter than its model.
    furthest
        Bound on how far a payload lies from the base's origin along each axis.
    largest
        Bound on the rest, along each axis.
    """

    block: float = 0.01
    mass: float = 0.4
    place: float = 0.1
    memory: float = 200.0
    force: float = 0.1
    moment: float = 0.05
    fading: float = 0.3
    noise_force: float = 0.1
    noise_moment: float = 0.05
    watch: float = 0.5
    least: float = -0.3
    most: float = 1.5
    furthest: float = 0.6
    largest: float = 0.3

    def __post_init__(self) -> None:
        for name in ("block", "memory", "fading", "noise_force", "noise_moment", "watch"):
            real_number(name, getattr(self, name), low=1e-6)
        for name in ("mass", "place", "force", "moment", "most", "furthest", "largest"):
            real_number(name, getattr(self, name), low=0.0)
        real_number("least", self.least, low=-0.9, high=0.0)


VIOLENT = 2.0
"""A block's mean is taken for no more than this, forces in m g and moments in m g h."""
LIGHT = 0.05
"""Share of the robot's mass below which a payload's place is told nearer than it is: it cannot be known."""


class Load(NamedTuple):
    """What the base carries beyond its model; negative where the robot is lighter than it.

    Attributes
    ----------
    mass
        [kg].
    moment
        (3,) first moment, the mass times its place in base axes [kg m].
    place
        (3,) base axes [m]; nearer for masses below `LIGHT`.
    """

    mass: float
    moment: FloatArray
    place: FloatArray


class Instant(NamedTuple):
    """What a robot's model says at a state, as the equations of motion of the next step need it.

    Attributes
    ----------
    M, bias
        (nv, nv), (nv,) mass matrix and bias forces [kg, N, N m].
    v
        (nv,) velocity [m/s, rad/s].
    twists
        (6, nv) Pinocchio's data.J.
    points
        (n, 3) where the feet touch, world axes [m].
    pose
        (3, 4) rotation and place of the base.
    """

    M: FloatArray
    bias: FloatArray
    v: FloatArray
    twists: FloatArray
    points: FloatArray
    pose: FloatArray


class WrenchObserver:
    """Estimates payload and external wrench step by step: `observe` after every step that was taken.

    Parameters
    ----------
    robot
        With a floating base and feet; what it weighs beyond its model is the payload.
    dt
        Time between steps [s].
    settings
        See `ObserverSettings`.

    Attributes
    ----------
    state
        (10,) mass and first moment of the payload, force and moment of the rest, in the units of
        `ObserverSettings`.
    """

    def __init__(self, robot: Robot, dt: float, settings: ObserverSettings | None = None) -> None:
        self.robot, self.dt, self.settings = (
            robot,
            real_number("dt", dt, low=1e-6),
            settings or ObserverSettings(),
        )
        s, points = self.settings, robot.contact_points
        self._support, self._flat = points.foot_support, points.flat
        height = float(robot.com(robot.nominal)[2] - robot.foot_positions(robot.nominal)[:, 2].mean())
        self.height, self.weight = max(height, 0.05), robot.mass * GRAVITY
        force, moment = self.weight, self.weight * self.height
        load = [robot.mass] + [robot.mass * self.height] * 3
        self._unit = np.array(load + [force] * 3 + [moment] * 3)
        self._steps = max(1, round(s.block / self.dt))
        block = self._steps * self.dt
        deviation = np.array([s.mass] + [s.place] * 3 + [s.force] * 3 + [s.moment] * 3)
        times = np.array([math.inf] * 3 + [s.memory] + [s.fading] * 6)
        self._start = np.diag(deviation**2)
        self._keep = np.exp(-block / times)
        self._drive = deviation**2 * (1.0 - self._keep**2)
        self._drive[:3] = deviation[:3] ** 2 * 2.0 * block / s.memory
        self._noise = np.array([s.noise_force**2] * 3 + [s.noise_moment**2] * 3)
        self._watch = 1.0 - math.exp(-block / s.watch)
        self._bounds = np.array([VIOLENT, s.least, s.most, s.furthest, LIGHT, s.largest])
        self._none = np.zeros(4)
        self._warm_up()
        self.reset()

    def _warm_up(self) -> None:
        """Compile or load all that a step calls, so that no step of a run waits."""
        import pinocchio

        robot, n = self.robot, len(self.robot.feet)
        still, data = np.zeros(robot.model.nv), robot.model.createData()
        M = np.array(pinocchio.crba(robot.model, data, robot.nominal))
        bias = np.array(pinocchio.nonLinearEffects(robot.model, data, robot.nominal, still))
        twists = np.ascontiguousarray(pinocchio.computeJointJacobians(robot.model, data, robot.nominal))
        instant = Instant(M, bias, still, twists, np.zeros((n, 3)), np.zeros((3, 4)))
        self.reset()
        nothing = Load(0.0, np.zeros(3), np.zeros(3))
        for _ in range(self._steps):
            self.observe(instant, still, np.zeros(robot.joints), np.ones(n, dtype=bool), nothing)

    def reset(self) -> None:
        """Forget the past: no payload, no wrench."""
        self.state, self._covariance = np.zeros(10), self._start.copy()
        self._sum, self._count = np.zeros(6), 0
        self._spread, self._last = np.zeros(6), np.full(6, np.nan)

    def observe(
        self, before: Instant, after: FloatArray, torques: FloatArray, touching: BoolArray,
        carried: Load | None = None,
    ) -> bool:  # fmt: skip
        """Take in a step; return whether that has ended a block, and changed the estimate.

        Parameters
        ----------
        before
            The model at the start of the step.
        after
            (nv,) velocity at its end [m/s, rad/s].
        torques
            (joints,) during it [N m].
        touching
            (n,) which feet may have pushed.
        carried
            What the model of `before` carries already; the estimate is of all that the robot carries.
        """
        load = self._none if carried is None else np.array([carried.mass, *carried.moment])
        kernels.sum_wrench(
            before.M, before.bias, before.v, after, self.dt, torques, before.twists, self._support,
            before.points, self._flat, touching, before.pose, load, self._sum,
        )  # fmt: skip
        self._count += 1
        if self._count < self._steps:
            return False
        self._correct(before.pose)
        self._sum, self._count = np.zeros(6), 0
        return True

    def _correct(self, pose: FloatArray) -> None:
        """Filter a full block; one that is not finite is left out."""
        mean = self._sum / (self._count * self._unit[4:])
        if not np.isfinite(mean).all():
            return
        kernels.filter_block(
            self.state, self._covariance, mean, self._last, self._spread, pose, self._noise, self._keep,
            self._drive, self._watch, self._bounds,
        )  # fmt: skip

    @property
    def load(self) -> Load:
        """The payload."""
        mass = float(self.state[0]) * self.robot.mass
        moment = self.state[1:4] * self._unit[1:4]
        known = math.copysign(max(abs(mass), LIGHT * self.robot.mass), mass)
        return Load(mass, moment, moment / known)

    @property
    def wrench_unit(self) -> FloatArray:
        """What forces and moments are shares of (6,): m g and m g h [N, N m]."""
        return np.asarray(self._unit[4:])

    @property
    def wrench(self) -> FloatArray:
        """The rest (6,): force and moment about the base's origin, world axes [N, N m]."""
        return np.asarray(self.state[4:] * self._unit[4:])
