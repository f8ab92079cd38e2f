"""What the direct method is asked: a robot, where it starts and is to end, what costs, what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_array, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.mechanics import FlatTerrain, Robot, Terrain, velocity_of_way
from surefoot.motion.planning.transcription.contact_pairs import PlanarContactPair
from surefoot.motion.planning.transcription.planar import is_planar, passive_joints
from surefoot.motion.planning.transcription.state_window import StateWindow, limit_joints


@dataclass(frozen=True)
class Weights:
    """The cost of a knot, times dt, and of the end.

    Attributes
    ----------
    torque
        Of ||torques||² [1 / (N m)²]; those of joints without motor are zero anyway.
    velocity
        Of ||v - v_reference||².
    posture
        Of ||q - q_reference||².
    change
        Of ||v⁺ - v||² / dt: what makes motions quiet, touchdowns soft.
    end
        Of the end's distance from the reference, q and v, once.
    """

    torque: float = 1e-3
    velocity: float = 1e-2
    posture: float = 1e-1
    change: float = 1e-3
    end: float = 0.0

    def __post_init__(self) -> None:
        for name in ("torque", "velocity", "posture", "change", "end"):
            real_number(name, getattr(self, name), low=0.0)


@dataclass(frozen=True, eq=False)
class DirectProblem:
    """A motion of a robot in the plane to be found; no contact is given.

    Attributes
    ----------
    robot
        One of `transcription.planar`, whose feet may touch the ground.
    q, v
        (nq,), (nv,) the start.
    knots, dt
        Number of knots, and their length [s].
    reference
        (nq,) the posture that costs nothing; (knots + 1, nq) for one of each knot. None for q.
    end
        Bounds on the last state.
    windows
        Bounds on the states of some knots, by their number.
    weights
        See `Weights`.
    mu, terrain
        The ground: friction, and a plane (None for level).
    torque_limits
        (joints,) [N m]; None for the robot's own, zero where a joint has no motor.
    joint_limits
        Whether the model's limits on joint positions and speeds hold.
    touches
        Contacts between bodies of the robot, beside those of its feet with the ground.

    Raises
    ------
    ProblemError
        For arrays that do not fit, numbers out of range, ground that is no plane, a robot that is not planar.
    """

    robot: Robot
    q: FloatArray
    v: FloatArray
    knots: int
    dt: float
    reference: FloatArray | None = None
    end: StateWindow = field(default_factory=StateWindow)
    windows: Mapping[int, StateWindow] = field(default_factory=dict)
    weights: Weights = field(default_factory=Weights)
    mu: float = 0.6
    terrain: Terrain = field(default_factory=FlatTerrain)
    torque_limits: FloatArray | None = None
    joint_limits: bool = True
    touches: tuple[PlanarContactPair, ...] = ()

    def __post_init__(self) -> None:
        robot, model = self.robot, self.robot.model
        whole_number("knots", self.knots, low=1)
        real_number("dt", self.dt, low=1e-6)
        real_number("mu", self.mu, low=0.0, high=1e6)
        if not self.terrain.planar:
            raise ProblemError(f"the direct method takes a plane for ground, got {self.terrain!r}")
        if not is_planar(robot):
            raise ProblemError(f"the direct method is for robots in a plane, {robot.name} is none")
        given = {"q": robot.configuration(self.q), "v": finite_array("v", self.v, (model.nv,))}
        reference = given["q"] if self.reference is None else real_array("reference", self.reference)
        if reference.shape not in ((model.nq,), (self.knots + 1, model.nq)):
            raise ProblemError(f"reference must have shape ({model.nq},) or ({self.knots + 1}, {model.nq})")
        given["reference"] = np.array(np.broadcast_to(reference, (self.knots + 1, model.nq)))
        limits = robot.effort_limits if self.torque_limits is None else self.torque_limits
        limits = real_array("torque_limits", limits, (robot.joints,))
        given["torque_limits"] = np.where(passive_joints(robot), 0.0, limits)
        for name, value in given.items():
            object.__setattr__(self, name, value)
        for k in self.windows:
            if not 0 < k <= self.knots:
                raise ProblemError(f"windows are of knots 1 to {self.knots}, got {k}")

    @property
    def references(self) -> FloatArray:
        """(knots + 1, nq) the posture that costs nothing."""
        assert self.reference is not None
        return self.reference

    @property
    def frictions(self) -> FloatArray:
        """(p,) of all contacts: the feet's points, then the touches."""
        feet = np.full(len(self.robot.contact_points), self.mu)
        return np.concatenate([feet, [touch.mu for touch in self.touches]])

    def state_bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the bounds (knots + 1, nq + nv) of all states; the start is fixed."""
        model = self.robot.model
        nq, nv = int(model.nq), int(model.nv)
        low = np.full((self.knots + 1, nq + nv), -np.inf)
        high = -low
        if self.joint_limits:
            limit_joints(self.robot, low, high)
        for k, window in [*self.windows.items(), (self.knots, self.end)]:
            window.narrow(low[k], high[k], nq, k)
        low[0] = high[0] = np.concatenate([self.q, velocity_of_way(model, self.q, self.v, self.dt)])
        return low, high
