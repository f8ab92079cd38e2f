"""A motion over a given mode schedule: who stands when, where it starts and ends, what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import FlatTerrain, MotorLimits, Robot, Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.planning.stepped_ground import PassedGround, find_passed_ground
from surefoot.motion.planning.transcription.contact_pairs import PlanarContactPair
from surefoot.motion.planning.transcription.state_window import StateWindow


@dataclass(frozen=True)
class ScheduleWeights:
    """The cost of a second of motion, each part in units of its own scale.

    Attributes
    ----------
    position, orientation
        Of the base's distance from its reference [1/m², 1 per quaternion entry squared].
    joints
        Of the joints' distance from their reference [1/rad²].
    velocity
        Of the base's velocity and of the joints', squared.
    torque
        Of torques as shares of their limits, squared.
    force
        Of forces as shares of m g, squared.
    change
        Of the change of velocity from knot to knot, squared, per knot: what makes motions smooth.
    symmetry
        Of what differs between left and right: the base's y, roll and yaw, joints and their mirror images.
    """

    position: float = 2.0
    orientation: float = 10.0
    joints: float = 1.0
    velocity: float = 0.01
    torque: float = 1.0
    force: float = 0.1
    change: float = 1e-3
    symmetry: float = 0.0

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            real_number(name, getattr(self, name), low=0.0)


@dataclass(frozen=True, eq=False)
class ScheduleProblem:
    """What is asked of the optimiser.

    Attributes
    ----------
    robot
        With a floating base and feet.
    schedule
        When each foot stands.
    dt, knots
        Length [s] and number of knots.
    q, v
        (nq,), (nv,) the start.
    reference
        (knots + 1, nq) the motion that costs nothing; of a full turn the quaternions go on and change sign.
    windows
        Bounds on the states of some knots, by their number.
    weights
        See `ScheduleWeights`.
    mu
        Friction that may be used.
    terrain
        A plane, or level ground in steps along x: feet stand where q and the end of the reference have them.
    torque_share, speed_share
        Of the robot's limits that may be used.
    motors, motor_share
        Motors whose falling torque-speed line the motion keeps below, and by which share of their no-load
        speed; None for torque and speed limits that know nothing of each other.
    touchdown_speed
        Largest speed of a foot along each contact axis when it lands [m/s]; infinite for any. Legs that give
        way before they land need not change their joints' speeds in an instant.
    stance_reach
        How far below the base, along its own z axis, feet stand at least [m]; 0 for any. A foot level with
        the axis about which its leg is abducted cannot be moved or held sideways.
    clearance
        How high feet swing in the middle of their flight [m].
    force_min
        Least normal force of a point that stands [N].
    leg_gap
        How far behind the front legs' knees and feet the rear ones' stay, along the base's x axis [m]; 0 for
        any.
    hip_gap
        How far rear hips stay behind front feet where only rear feet stand, on the same axis [m].
    leg_spread
        How far apart knees and feet of left and right legs stay, along the base's y axis [m]; 0 for any.
    body_clearance, knee_clearance
        Least heights of the trunk's lower and upper corners, and of the joints above the feet [m].

    Raises
    ------
    ProblemError
        For arrays that do not fit, numbers out of range, ground that is no plane, a robot without a base.
    """

    robot: Robot
    schedule: ContactSchedule
    dt: float
    knots: int
    q: FloatArray
    v: FloatArray
    reference: FloatArray
    windows: Mapping[int, StateWindow] = field(default_factory=dict)
    weights: ScheduleWeights = field(default_factory=ScheduleWeights)
    mu: float = 0.5
    terrain: Terrain = field(default_factory=FlatTerrain)
    torque_share: float = 0.9
    speed_share: float = 0.9
    motors: MotorLimits | None = None
    motor_share: float = 1.0
    touchdown_speed: float = np.inf
    stance_reach: float = 0.0
    clearance: float = 0.02
    force_min: float = 0.0
    leg_gap: float = 0.0
    hip_gap: float = 0.0
    leg_spread: float = 0.0
    body_clearance: float = 0.06
    knee_clearance: float = 0.05

    def __post_init__(self) -> None:
        robot, model = self.robot, self.robot.model
        if not (robot.floating and robot.feet):
            raise ProblemError(
                f"a scheduled motion needs a floating base and feet, {robot.name} has not both"
            )
        if self.schedule.feet != len(robot.feet):
            sizes = f"the schedule has {self.schedule.feet} feet, {robot.name} has {len(robot.feet)}"
            raise ProblemError(sizes)
        if not self.terrain.planar and self.terrain.levels() is None:
            raise ProblemError(f"a scheduled motion takes a plane or steps for ground, got {self.terrain!r}")
        real_number("dt", self.dt, low=1e-4, high=0.2)
        whole_number("knots", self.knots, low=2)
        real_number("mu", self.mu, low=0.0, high=1e6)
        for name in ("torque_share", "speed_share", "motor_share"):
            real_number(name, getattr(self, name), low=1e-3, high=1e3)
        real_number("touchdown_speed", self.touchdown_speed, low=0.0)
        real_number("force_min", self.force_min, low=0.0, high=0.9 * self.weight)
        for name in (
            "clearance", "leg_gap", "hip_gap", "leg_spread", "stance_reach", "body_clearance",
            "knee_clearance",
        ):  # fmt: skip
            real_number(name, getattr(self, name), low=0.0, high=10.0)
        given = {
            "q": robot.configuration(self.q),
            "v": finite_array("v", self.v, (model.nv,)),
            "reference": finite_array("reference", self.reference, (self.knots + 1, model.nq)),
        }
        for name, value in given.items():
            object.__setattr__(self, name, value)
        for k in self.windows:
            if not 0 < k <= self.knots:
                raise ProblemError(f"windows are of knots 1 to {self.knots}, got {k}")

    @property
    def weight(self) -> float:
        """M g [N]."""
        return float(self.robot.mass * GRAVITY)

    @property
    def touches(self) -> tuple[PlanarContactPair, ...]:
        """None: feet on the ground are all."""
        return ()

    @property
    def stance(self) -> BoolArray:
        """(knots, p) which contact points stand in each knot."""
        feet = self.schedule.horizon(0.0, self.dt, self.knots)
        return np.asarray(feet[:, self.robot.contact_points.foot])

    @property
    def passed(self) -> PassedGround | None:
        """Stepped ground between start and end, which feet and links pass over; None for a plane."""
        return find_passed_ground(self.terrain, self.robot, self.q, self.reference[-1])

    @property
    def heights(self) -> FloatArray:
        """(knots, p) of the ground where points stand, the lower one in flight [m]; on planes 0."""
        stance = self.stance
        if self.terrain.planar:
            return np.zeros(stance.shape)
        ends = [self.robot.foot_positions(q)[:, :2] for q in (self.q, self.reference[-1])]
        before, after = self.terrain.height(ends)[:, self.robot.contact_points.foot]
        stays = np.logical_and.accumulate(stance, axis=0)
        return np.asarray(np.where(stays, before, np.where(stance, after, np.minimum(before, after))))

    @property
    def torque_limits(self) -> FloatArray:
        """(joints,) that may be used [N m]."""
        return np.asarray(self.torque_share * self.robot.effort_limits)
