"""One trial: a stack, a task and a seed in the common world."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.stacks.judging import Trial
from benchmarks.stacks.measures import Measures, measured
from benchmarks.stacks.setting import HARD, Setting, true_robot
from benchmarks.stacks.stack import Job, Stack, TimedController, ramp_time, ramped
from benchmarks.stacks.tasks import PUSH_AT, PUSH_TIME, Task
from benchmarks.walks import known_robot
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import MissingExtra, SurefootError
from surefoot.base.spatial import (
    GRAVITY,
    quaternion_from_rotation,
    rotation_about,
    rotation_from_quaternion,
)
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.legs import Legs
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.records.log import Ending, Log
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.observers import Moment, Observer
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Push, Scenario
from surefoot.worlds.running.walk_terrain import start_pose

MASS_ERROR, FRICTION_ERROR = 0.05, 0.1
"""Largest errors of all links' mass and of the ground's friction, as shares."""
START_PLACE, START_TURN = 0.01, math.radians(1.5)
"""Largest offset of the base over its feet at the start along each level axis [m], and lean about each."""
PHASES = 4
"""Phases of the gait at which pushes come, seed after seed."""
SETTLED, RECOVERED = 1.0, 1.5
"""Time after the ramp, and after a push, from which the velocity counts [s]."""


@dataclass(frozen=True)
class Variation:
    """What a seed makes different from the documents.

    Attributes
    ----------
    mass, friction
        Factors of the links' masses and of the ground's friction.
    place, lean
        (2,) offset of the base [m], and its lean about x and y [rad], at the start.
    phase
        Of the gait, when a push comes [0, 1).
    joint
        Number in [0, 1): which joint is weak.
    """

    mass: float
    friction: float
    place: tuple[float, float]
    lean: tuple[float, float]
    phase: float
    joint: float

    @classmethod
    def drawn(cls, seed: int) -> Variation:
        """Return that of a seed; pushes go through the phases in turn, the rest is uniform."""
        r = np.random.default_rng([seed, 17])
        u = r.uniform(-1.0, 1.0, 6)
        return cls(
            1.0 + MASS_ERROR * float(u[0]), 1.0 + FRICTION_ERROR * float(u[1]),
            (START_PLACE * float(u[2]), START_PLACE * float(u[3])),
            (START_TURN * float(u[4]), START_TURN * float(u[5])),
            (seed % PHASES) / PHASES, float(r.random()),
        )  # fmt: skip


def hip_height(robot: Robot) -> float:
    """Return the mean height of the legs' first joints over the ground in the nominal pose [m]."""
    import pinocchio

    data, model = robot.model.createData(), robot.model
    pinocchio.forwardKinematics(model, data, robot.nominal)
    heights = []
    for foot in robot.feet:
        joint = int(model.frames[foot.frame].parentJoint)
        while int(model.parents[joint]) > 1:
            joint = int(model.parents[joint])
        heights.append(float(data.oMi[joint].translation[2]))
    return float(np.mean(heights))


def asked_velocity(task: Task) -> tuple[float, float, float]:
    """Return what a task asks for: (forward, left, yaw rate) [m/s, rad/s]."""
    if task.froude is None:
        return task.asked
    speed = task.froude * math.sqrt(GRAVITY * hip_height(known_robot(task.robot)))
    return (round(speed, 3), 0.0, 0.0)


class _Cpu(Observer):
    """CPU time of this process from the first step to the end."""

    def __init__(self) -> None:
        self.begin = self.spent = math.nan

    def step(self, moment: Moment) -> None:
        """Note the time of the first step."""
        if math.isnan(self.begin):
            self.begin = time.process_time()

    def end(self, log: Log) -> None:
        """Note the time of the end."""
        self.spent = time.process_time() - self.begin


def carry_out(stack: Stack, task: Task, seed: int, setting: Setting = HARD) -> Trial:
    """Run one trial and return what became of it.

    Raises
    ------
    KeyboardInterrupt
        If it was interrupted: an interrupted trial is none.
    MissingExtra
        For an optional package that is not installed.
    """
    robot, vary = known_robot(task.robot), Variation.drawn(seed)
    asked, ground = asked_velocity(task), read_terrain(task.terrain, "terrain")
    try:
        motors = setting.motors(robot)
        job = Job(robot, asked, ground, task.believed_mu, motors, task.knowledge)
        controller = stack.controller(job)
    except MissingExtra:
        raise
    except SurefootError as error:
        return Trial(stack.name, task.name, seed, "refused", _line(error))
    try:
        mu, true = task.mu * vary.friction, true_robot(robot, vary.mass, task.payload, task.payload_at)
        world = setting.world(true, ground, mu, 1e-3, motors)
        scenario = _scenario(task, vary, setting, controller, world.robot, seed)
        cpu = _Cpu()
        log = run(world, controller, scenario, [cpu])
    except MissingExtra:
        raise
    except SurefootError as error:
        return Trial(stack.name, task.name, seed, str(Ending.INVALID), _line(error))
    finally:
        controller.close()
    if log.fact("outcome") == Ending.INTERRUPTED:
        raise KeyboardInterrupt
    spent = cpu.spent + (sum(controller.cpu) if controller.apart else 0.0)
    return _trial(stack, task, seed, log, controller, spent, setting.collision != "feet")


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]


def _scenario(
    task: Task, vary: Variation, setting: Setting, controller: TimedController, robot: Robot, seed: int
) -> Scenario:
    """Return what happens: the disturbed start, the push in its phase, the faults of the seed."""
    q = start(known_robot(task.robot), read_terrain(task.terrain, "terrain"), controller.posture, vary)
    pushes: tuple[Push, ...] = ()
    if task.push is not None:
        pushes = (Push(push_time(controller, vary.phase), (*task.push, 0.0), PUSH_TIME),)
    weak = robot.joint_names[int(vary.joint * robot.joints)] if task.torque_loss > 0.0 else ""
    plain_noise = 0.0 if setting.estimator == "inekf" or task.noise == 1.0 else task.noise
    faults = Faults(plain_noise, task.delay, weak, task.torque_loss, dropouts=task.dropouts)
    sensors = setting.sensors(task.noise, task.knowledge == "exact")
    scanner = RangeSensor() if task.knowledge == "map" else None
    return Scenario(
        task.duration, task.mu * vary.friction, pushes, (), seed, faults, q, sensors=sensors,
        scanner=scanner,
    )  # fmt: skip


def start(robot: Robot, ground: Terrain, posture: FloatArray | None, vary: Variation) -> FloatArray:
    """Return where a trial starts: (nq,) a stance on the ground, the base moved and leaning over its feet.

    Parameters
    ----------
    robot, ground
        Who stands where.
    posture
        (nq,) whose joints it has before that; None for the nominal ones.
    vary
        The offsets.
    """
    q = np.array(start_pose(robot, ground, posture))
    if any(foot.flat for foot in robot.feet):
        return q  # a sole would tilt with its shank
    rotation = rotation_from_quaternion(q[3:7])
    feet = Legs(robot).feet(q[7:]) @ rotation.T + q[:3]
    q[:2] += vary.place
    for axis, angle in zip(np.eye(3)[:2], vary.lean, strict=True):
        rotation = rotation_about(axis, angle) @ rotation
    q[3:7] = quaternion_from_rotation(rotation)
    q[7:] = Legs(robot).reach((feet - q[:3]) @ rotation, q[7:])
    return q


def push_time(controller: TimedController, phase: float) -> float:
    """Return the first time from `PUSH_AT` on at which the gait is in a phase in [0, 1) [s]."""
    start, period = controller.gait_start, controller.gait_period
    cycles = math.ceil((PUSH_AT - start) / period - phase - 1e-9)
    return round(start + (cycles + phase) * period, 3)


def _trial(
    stack: Stack, task: Task, seed: int, log: Log, controller: TimedController, spent: float, links: bool
) -> Trial:
    """Return what a log and the clocks say."""
    robot, asked = known_robot(task.robot), asked_velocity(task)
    height = float(robot.nominal[2])
    wanted = np.array([ramped(asked, float(t), height, controller.starts) for t in log["time"]])
    settled = ramp_time(asked, height, controller.starts) + SETTLED
    pushed = np.flatnonzero(np.abs(log["push"]).max(axis=1) > 0.0)
    if len(pushed):
        settled = max(settled, float(log["time"][pushed[-1]]) + RECOVERED)
    ending, duration = str(log.fact("outcome")), len(log) * float(log.fact("dt"))
    why = str(log.facts.get("error", "")) or "; ".join(log.facts.get("notes") or ())
    measures = Measures() if ending == Ending.INVALID else measured(log, wanted, settled, links)
    times = 1e6 * np.array(controller.cpu)
    busy = times[times > 0.0]
    return Trial(
        stack.name, task.name, seed, ending, why, measures,
        float(times.mean()) if len(times) else math.nan,
        float(np.percentile(busy, 99)) if len(busy) else math.nan,
        duration / spent if spent > 0.0 else math.nan, duration,
    )  # fmt: skip
