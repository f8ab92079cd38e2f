"""Faults of readings, put into a recorded stretch of a walk."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from surefoot.mechanics.robot import load_robot
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.robot_loop import RobotLoop
from surefoot.worlds.running.motor_robot import MotorRobot

GO2 = load_robot("go2")
DT = 0.002
OFF = 0.1
"""A joint whose angle is told wrong by this much cannot be controlled [rad]."""
Stretch = list[RobotReadings | None]
Fault = Callable[[Stretch, int, np.random.Generator], int | None]
"""Spoils a stretch from a place on; returns where control becomes impossible, None where it does not."""


def walking() -> tuple[RobotLoop, Stretch]:
    """Return a loop in the midst of a walk, and the readings that come next."""
    loop, robot = RobotLoop(GO2, DT), MotorRobot(GO2, DT)
    robot.reset(GO2.nominal)

    def step() -> RobotReadings:
        readings = robot.read()
        robot.take(loop.step(readings))
        robot.step()
        return readings

    for goal, steps in (("", 50), ("stand", 1700), ("walk", 600)):
        if goal:
            loop.go(goal)
        loop.steer([0.5, 0.0, 0.0])
        for _ in range(steps):
            step()
    return loop, _in_a_copy(lambda: [step() for _ in range(56)])


def _spoil(change: Callable[[RobotReadings, np.random.Generator], RobotReadings | None]) -> Fault:
    """Return a fault that makes each reading useless."""

    def fault(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
        seed = int(rng.integers(1 << 30))
        for k in range(at, len(stretch)):
            stretch[k] = change(stretch[k], np.random.default_rng(seed))  # type: ignore[arg-type]
        return at

    return fault


def _set(name: str, value: float) -> Fault:
    def change(r: RobotReadings, rng: np.random.Generator) -> RobotReadings:
        values = np.array(getattr(r, name))
        values[rng.integers(len(values))] = value
        return r._replace(**{name: values})

    return _spoil(change)


def _frozen(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
    """One encoder tells what it told last."""
    joint, held, wrong = int(rng.integers(12)), stretch[at], None
    for k in range(at, len(stretch)):
        r = stretch[k]
        if wrong is None and abs(r.positions[joint] - held.positions[joint]) > OFF:
            wrong = k
        rows = {name: np.array(getattr(r, name)) for name in ("positions", "speeds")}
        for name, values in rows.items():
            values[joint] = getattr(held, name)[joint]
        stretch[k] = r._replace(**rows)
    return wrong


def _swapped(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
    """Two joints tell each other's numbers; while they are alike nothing in the readings says so."""
    a, b = rng.choice(12, 2, replace=False)
    order = np.arange(12)
    order[[a, b]] = b, a
    alike = abs(stretch[at].positions[a] - stretch[at].positions[b]) < OFF
    for k in range(at, len(stretch)):
        stretch[k] = stretch[k].ordered(order)
    return None if alike else at


def _late(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
    """Everything comes 50 ms later, after a gap."""
    delayed = [*stretch[:at], *[None] * 25, *stretch[at : len(stretch) - 25]]
    stretch[:] = delayed
    return at


def _clock(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
    """The robot's clock jumps, which hinders nobody."""
    jump = float(rng.choice([-3600.0, -0.5, 0.5, 3600.0]))
    for k in range(at, len(stretch)):
        stretch[k] = stretch[k]._replace(time=stretch[k].time + jump)
    return None


def _third(stretch: Stretch, at: int, rng: np.random.Generator) -> int | None:
    """Three in ten readings do not come, never more than six in a row."""
    lost = 0
    for k in range(at, len(stretch)):
        lost = lost + 1 if rng.random() < 0.3 and lost < 6 else 0
        if lost:
            stretch[k] = None
    return None


FAULTS: dict[str, Fault] = {
    "lost": _spoil(lambda r, rng: None),
    "not a number": _set("positions", np.nan),
    "infinite": _set("gyro", np.inf),
    "torque not a number": _set("torques", np.nan),
    "angle out of range": _set("positions", 9.0),
    "speed out of range": _set("speeds", 90.0),
    "attitude": _set("quaternion", 3.0),
    "time not a number": _spoil(lambda r, rng: r._replace(time=float("nan"))),
    "all zero": _spoil(lambda r, rng: RobotReadings(r.time, *(0.0 * np.array(row) for row in r[1:7]))),
    "eleven joints": _spoil(lambda r, rng: r._replace(positions=r.positions[1:])),
    "mirrored": _spoil(lambda r, rng: r._replace(positions=-r.positions)),
    "turned over": _spoil(lambda r, rng: r._replace(quaternion=np.array([1.0, 0.0, 0.0, 0.0]))),
    "clock stands": _spoil(lambda r, rng: r._replace(time=1.0)),
    "frozen joint": _frozen,
    "swapped joints": _swapped,
    "late": _late,
    "clock jumps": _clock,
    "a third lost": _third,
}


class Answer(NamedTuple):
    """What a loop made of a stretch: when it first damped (None: never), its largest torque, why."""

    damped: int | None
    worst: float
    fault: str


def answer(loop: RobotLoop, stretch: Stretch) -> Answer:
    """Return what the loop makes of a stretch, in a copy of this process: the loop stays where it is."""
    return _in_a_copy(lambda: _steps(loop, stretch))


def _steps(loop: RobotLoop, stretch: Stretch) -> Answer:
    first, worst = None, 0.0
    for k, readings in enumerate(stretch):
        targets = loop.step(readings)
        last = loop.watch.last
        share = np.abs(targets.torques(last.positions, last.speeds)) / GO2.effort_limits
        worst = max(worst, float(share.max())) if np.isfinite(share).all() else np.inf
        if not targets.stiffness.any() and not targets.feedforward.any():
            first = k if first is None else first
            if k > first + 4:
                break
    return Answer(first, worst, loop.fault or loop.watch.reason)


def _in_a_copy(make: Callable[[], Any]) -> Any:
    """Return what a function returns in a copy of this process."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:  # pragma: no cover
        with os.fdopen(write, "wb") as pipe:
            pickle.dump(make(), pipe)
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as pipe:
        told = pickle.load(pipe)
    os.waitpid(child, 0)
    return told
