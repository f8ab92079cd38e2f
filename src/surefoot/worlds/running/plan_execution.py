"""Execute a plan in a simulated world, behind motors, from a start and on a ground that it did not expect."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import (
    quaternion_from_rotation,
    rotation_about,
    rotation_exp,
    rotation_from_quaternion,
)
from surefoot.mechanics import Legs, MotorLimits, Robot, limited_robot, load_robot, loaded_robot, motor_limits
from surefoot.motion import Command, Controller, Reference, RobotState, Wrapper, controller_of, planned_ground
from surefoot.records import Ending, Log, audit_log
from surefoot.worlds.interface.world import World
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.faults import scaled_robot
from surefoot.worlds.running.observers import LinkContactObserver
from surefoot.worlds.running.run import Scenario, run
from surefoot.worlds.running.scenario import Fall

EXECUTING = ("mujoco", "mujoco-exact", "rigid")
"""Worlds that know a whole robot's links."""
START_PLACE, START_TURN = 0.02, math.radians(2.0)
"""Largest error of the body's place at the start along each axis [m], of its attitude about each [rad]."""
FRICTION_ERROR, MASS_ERROR = 0.2, 0.05
"""Largest errors of the friction and of every link's mass, as shares."""
STEP = 5e-4
"""Of the world [s]."""
STIFF = (4.0, 1.0)
"""Time constant of MuJoCo's contact over the step, and its damping ratio."""
SETTLE, AGAIN = 1.2, 4.0
"""Time after the end of the plan in which the robot must come to rest [s], also where it gets up at last."""
AT_REST, UPRIGHT, RISEN = 0.1, math.radians(15.0), 0.6
"""A robot has landed at the end if it is slower than this [m/s, rad/s], leans less than this against how the
plan ends [rad], its base is above this share of the plan's last height, and all feet are on the ground."""
LAID = 0.03
"""Height from which a robot that lies is let down [m]: no link is in the ground, however it is displaced."""
OFF, OFF_TURN = 0.15, math.radians(40.0)
"""Most that the feet's middle may be off the plan's last place [m], the whole turn off the plan's [rad]."""
NEVER = Fall(-math.inf, math.pi)
"""A robot that turns over, or lies, has not fallen for good."""


@dataclass(frozen=True)
class Surprise:
    """What a plan does not know of.

    Attributes
    ----------
    place, turn
        (3,) offset of the body over its feet at the start [m], and rotation vector of its attitude [rad].
    friction, mass
        Factors of the ground's friction and of the masses and inertias of all links.
    """

    place: FloatArray = field(default_factory=lambda: np.zeros(3))
    turn: FloatArray = field(default_factory=lambda: np.zeros(3))
    friction: float = 1.0
    mass: float = 1.0

    @classmethod
    def draw(cls, seed: int) -> Surprise:
        """Return the surprise of a seed: every number uniform within its largest error."""
        r = np.random.default_rng([whole_number("seed", seed), 16])
        place, turn = START_PLACE * r.uniform(-1.0, 1.0, 3), START_TURN * r.uniform(-1.0, 1.0, 3)
        friction = 1.0 + FRICTION_ERROR * float(r.uniform(-1.0, 1.0))
        return cls(place, turn, friction, 1.0 + MASS_ERROR * float(r.uniform(-1.0, 1.0)))


@dataclass(frozen=True)
class Execution:
    """What became of a plan in a world.

    Attributes
    ----------
    landed
        Whether the robot stands on all its feet at the end, at rest. Of motions that begin on the feet also
        whether that is where the plan ends, after the same turns, and no other link touched the ground or
        another link on the way.
    laws
        Names of the laws that the audit found broken.
    torque_use_max, speed_use_max
        Largest joint torque and joint speed over the robot's limits.
    log
        Of the run.
    verdict
        Of the audit.
    links
        What touched beside feet on the ground, by name.
    moved
        (3,) by how much the feet's middle went, in the heading of the start [m].
    turned
        Angle that the base turned by about its own lateral axis, all in all [rad].
    why
        Why it has not landed; empty where it has.
    surprise
        What the plan did not know of.
    """

    landed: bool
    laws: list[str]
    torque_use_max: float
    speed_use_max: float
    log: Log
    verdict: str
    links: tuple[tuple[str, str], ...]
    moved: FloatArray
    turned: float
    why: str
    surprise: Surprise


def execute(
    plan: Log | Reference,
    world: str = "mujoco",
    limits: str | MotorLimits = "box",
    seed: int | None = None,
    *,
    surprise: Surprise | None = None,
    dt: float | None = None,
    settle: float | None = None,
) -> Execution:
    """Run a plan in a world and return what became of it.

    The plan is tracked by `TrackingController`, which knows the robot as it should be, and whose torques pass
    through motors. All of the robot's links can touch the ground and each other.

    Parameters
    ----------
    plan
        A plan, or a reference.
    world
        "mujoco", "mujoco-exact" or "rigid".
    limits
        Of the motors, or the name of their model, see `motor_limits`.
    seed
        Of what the plan does not know, see `Surprise.draw`; None for nothing.
    surprise
        In place of a seed.
    dt
        Length of a step [s]; None for `STEP`.
    settle
        Time after the end of the plan [s]; None for `SETTLE`, or `AGAIN` where it may try again.

    Raises
    ------
    ProblemError
        For what is no plan, or a world that does not know the robot's links.
    MissingExtra
        If the world's engine is not installed.
    """
    if world not in EXECUTING:
        raise ProblemError(f"plans are executed in the worlds {', '.join(EXECUTING)}, got {world!r}")
    if isinstance(plan, Reference):
        terrain, reference, robot = None, plan, plan.robot
    else:
        planned, payload = getattr(plan, "robot", None), float(plan.facts.get("payload", 0.0))
        robot = planned or limited_robot(loaded_robot(load_robot(str(plan.fact("robot"))), payload))
        terrain, reference = planned_ground(plan), Reference.of(plan, robot)
    mu = float(plan["mu"][0]) if isinstance(plan, Log) and "mu" in plan else 0.6
    surprise = surprise or (Surprise() if seed is None else Surprise.draw(seed))
    standing = reference.begins_standing
    dt = STEP if dt is None else dt
    settle = (SETTLE if standing else AGAIN) if settle is None else settle
    motors = motor_limits(robot, limits) if isinstance(limits, str) else limits
    own = {"solref": (STIFF[0] * dt, STIFF[1])} if world == "mujoco" else {}
    there = make_world(
        world,
        scaled_robot(robot, surprise.mass),
        terrain,
        mu * surprise.friction,
        dt=dt,
        collision="full",
        **own,
    )
    if world == "mujoco":  # fast joints lift and drag feet that do not count their speeds
        cast(MujocoWorld, there).count_centripetal()
    scenario = Scenario(
        reference.duration + settle, mu * surprise.friction, seed=seed, fall=NEVER,
        start=(
            displace(robot, reference.start, surprise)
            if standing
            else lying_configuration(reference.start, surprise)
        ),
    )  # fmt: skip
    return judge_run(
        there, MotorLimiter(controller_of(plan, robot, dt), motors), scenario, reference, surprise
    )


def displace(robot: Robot, q: FloatArray, surprise: Surprise) -> FloatArray:
    """Return a standing configuration (nq,) with the body displaced, and the feet where they were."""
    feet, out = robot.foot_positions(q), q.copy()
    out[:3] += surprise.place
    rotation = rotation_exp(surprise.turn) @ rotation_from_quaternion(q[3:7])
    out[3:7] = quaternion_from_rotation(rotation)
    out[7:] = Legs(robot).reach((feet - out[:3]) @ rotation, q[7:])
    points = robot.contact_points
    out[2] -= float((robot.foot_positions(out)[:, 2] - points.foot_radii).min())
    return out


def lying_configuration(q: FloatArray, surprise: Surprise) -> FloatArray:
    """Return a lying configuration (nq,) with the whole robot displaced, as high as its errors can need."""
    out = q.copy()
    out[:3] += surprise.place
    out[2] += LAID
    if surprise.turn.any():
        out[3:7] = quaternion_from_rotation(rotation_exp(surprise.turn) @ rotation_from_quaternion(q[3:7]))
    return out


def judge_run(
    world: World, controller: Controller, scenario: Scenario, reference: Reference, surprise: Surprise
) -> Execution:
    """Run a scenario and return what became of the plan behind it."""
    robot = world.robot
    watch = LinkContactObserver(world)
    log = run(world, controller, scenario, [watch])
    links = tuple(sorted(watch.found))
    report = audit_log(log, robot)
    why = _shortfall(robot, log, reference, links)
    q, v = np.asarray(log["q"]), np.asarray(log["v"])
    fastest = float(np.abs(v[:, 6:] / robot.speed_limits).max())
    return Execution(
        not why, sorted({v.law for v in report.violations}),
        float(np.abs(np.asarray(log["torques"]) / robot.effort_limits).max()), fastest, log, report.verdict,
        links, _displacement(robot, q), _pitch_of_motion(np.asarray(log["time"]), v), why, surprise,
    )  # fmt: skip


def _miss_of_end(robot: Robot, log: Log, reference: Reference) -> str:
    """Return by how much a motion that begins on the feet has missed its end, or nothing."""
    moved, planned = _displacement(robot, np.asarray(log["q"])), _displacement(robot, reference.q)
    if float(np.linalg.norm(moved - planned)) > OFF:
        return f"its feet went {moved[0]:.2f} m ahead, the plan's {planned[0]:.2f} m"
    turned = _pitch_of_motion(np.asarray(log["time"]), np.asarray(log["v"]))
    wanted = _pitch_of_motion(reference.time, reference.v)
    if abs(turned - wanted) > OFF_TURN:
        return f"it turned by {math.degrees(turned):.0f} deg, the plan by {math.degrees(wanted):.0f} deg"
    return ""


def _displacement(robot: Robot, q: FloatArray) -> FloatArray:
    """Return by how much the feet's middle went (3,), in the heading of the start [m]."""
    rotation = rotation_from_quaternion(q[0, 3:7])
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    way = robot.foot_positions(q[-1]).mean(axis=0) - robot.foot_positions(q[0]).mean(axis=0)
    return np.asarray(rotation_about([0.0, 0.0, 1.0], -yaw) @ way)


def _pitch_of_motion(time: FloatArray, v: FloatArray) -> float:
    """Return the angle that the base turned by about its own lateral axis [rad]."""
    return float((0.5 * (v[1:, 4] + v[:-1, 4]) * np.diff(time)).sum())


def _shortfall(robot: Robot, log: Log, reference: Reference, links: tuple[tuple[str, str], ...]) -> str:
    """Return why a robot has not landed where the plan lands it, or nothing."""
    if log.facts["outcome"] != str(Ending.DONE):
        return f"the run ended with {log.facts['outcome']}"
    q, v = np.asarray(log["q"])[-1], np.asarray(log["v"])[-1]
    end = reference.q[-1]
    if q[2] < RISEN * end[2]:
        return f"its base is {q[2]:.2f} m high, the plan ends at {end[2]:.2f} m"
    up, wanted = rotation_from_quaternion(q[3:7])[2], rotation_from_quaternion(end[3:7])[2]
    lean = math.acos(min(max(float(up @ wanted), -1.0), 1.0))
    if lean > UPRIGHT:
        return f"it leans {math.degrees(lean):.0f} deg"
    if np.abs(v[:6]).max() > AT_REST:
        return f"it still moves with {np.abs(v[:6]).max():.2f} m/s"
    last = np.asarray(log["forces"])[-20:, :, 2].mean(axis=0)
    feet = np.array([last[robot.contact_points.foot == k].sum() for k in range(len(robot.feet))])
    if (feet <= 0.0).any():
        return f"{robot.feet[int(np.argmin(feet))].name} does not stand"
    if not reference.begins_standing:
        return ""
    touched = "touched: " + ", ".join(" on ".join(pair) for pair in links) if links else ""
    return _miss_of_end(robot, log, reference) or touched


class MotorLimiter(Wrapper):
    """A controller whose torques pass through motors: what they cannot give at a joint's speed is cut off.

    Parameters
    ----------
    controller
        Who commands.
    limits
        Of the motors.
    """

    def __init__(self, controller: Controller, limits: MotorLimits) -> None:
        super().__init__(controller)
        self.limits = limits

    def step(self, state: RobotState) -> Command:
        """Return the controller's command with the torques that the motors give."""
        command = self.controller.step(state)
        speed = state.v[-len(self.limits.speed) :]
        return replace(command, torques=self.limits.clip(command.torques, np.nan_to_num(speed)))
