"""Faults on the wire between two processes, a robot in MuJoCo and the loop that walks it.

Both run in real time by a clock that is slower than the machine's, so that a busy machine is late for nobody:
what is late, silent or stopped is so by that clock, in the code that a real robot would meet. Joints count as
damped when the robot has taken targets without stiffness and torque, asked for or of its own accord. While
nothing goes wrong both wait for each other, however busy the machine is: the clock stands meanwhile.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.loop_log import LoopLog
from surefoot.motion.drive.modes import LoopMode
from surefoot.motion.drive.wire import wired_loop
from surefoot.motion.drive.wire.dialect import dialect_of
from surefoot.motion.drive.wire.link import WireEnd
from surefoot.worlds.running import motor_robot
from surefoot.worlds.running.motor_robot import MotorRobot, WiredRobot

SLOWER, DOMAIN = 16.0, 94
"""Length of a second of both sides' clock [s], and DDS's domain."""
ALLOWED, LASTS, ON_THE_WAY = 0.02, 0.3, 0.2
"""Time until the joints are damped [s], length of a fault [s], and of the walk before it [m]."""
PATIENT = 2.0
"""How long a message is waited for that nobody holds back, by the machine's clock [s]."""
LONGEST = 12.0
"""Longest time until the robot walks again [s]."""
WRONG = 0.1
"""A joint whose angle is told wrong by this much cannot be controlled [rad]."""
Spoiler = Callable[[Any, np.random.Generator, dict[str, Any]], None]


class SlowClock:
    """A clock of two processes, slower than the machine's; it stands while the robot's is held up."""

    def __init__(self, lost: Any) -> None:
        self.lost = lost

    def perf_counter(self) -> float:
        """Return the time [s]."""
        return float(time.perf_counter() / SLOWER - self.lost.value)

    def sleep(self, seconds: float) -> None:
        """Wait so long [s]."""
        time.sleep(seconds * SLOWER)


class SlowRobot(WiredRobot):
    """A robot whose steps are never behind the clock, as hardware's are not."""

    def step(self) -> None:
        """See `WiredRobot`."""
        clock: Any = motor_robot.clock  # type: ignore[attr-defined]
        late = clock.perf_counter() - self._due
        clock.lost.value += max(late, 0.0)
        due = self._due + self.robot.dt
        super().step()
        clock.lost.value += self._due - due  # held up while it spoke
        self._due = due


def _set(name: str, value: float) -> Spoiler:
    """Return what sets a number of one motor."""

    def spoil(message: Any, rng: np.random.Generator, kept: dict[str, Any]) -> None:
        values = message[f"motor_state.{name}"]
        values[kept["joint"]] = value
        message[f"motor_state.{name}"] = values

    return spoil


def _freeze(message: Any, rng: np.random.Generator, kept: dict[str, Any]) -> None:
    """Let an encoder tell what it told first."""
    joint, names = kept["joint"], ("motor_state.q", "motor_state.dq")
    fields = [message[name] for name in names]
    first = kept.setdefault("first", [values[joint] for values in fields])
    kept["off"] = abs(float(fields[0][joint] - first[0]))
    for name, values, value in zip(names, fields, first, strict=True):
        values[joint] = value
        message[name] = values


def _swap(message: Any, rng: np.random.Generator, kept: dict[str, Any]) -> None:
    """Let a thigh and the calf below it tell each other's numbers."""
    thigh = 3 * (kept["joint"] // 3) + 1
    for name in ("motor_state.q", "motor_state.dq"):
        values = message[name]
        values[[thigh, thigh + 1]] = values[[thigh + 1, thigh]]
        message[name] = values


def _jump(message: Any, rng: np.random.Generator, kept: dict[str, Any]) -> None:
    """Let the robot's clock jump."""
    jump = kept.setdefault("jump", int(rng.choice([-3600_000, -500, 500, 3600_000])))
    message["tick"] = (int(message["tick"]) + jump) % 2**32


SPOILED: dict[str, Spoiler] = {
    "an angle is not a number": _set("q", float("nan")), "a joint is frozen": _freeze,
    "two joints are swapped": _swap, "a motor's mode is 0": _set("mode", 0), "the clock jumps": _jump,
}  # fmt: skip
LOST = {"readings are lost": 1.0, "three in ten readings are lost": 0.3}
STOPPED = ("the controller is stopped", "the robot is stopped")
FAULTS = (
    *STOPPED, *LOST, "checksums of readings are wrong", *SPOILED,
    "commands are lost", "checksums of commands are wrong",
)  # fmt: skip
BEARABLE = ("three in ten readings are lost", "the clock jumps")
"""What is walked through."""


class FaultyEnd(WireEnd):
    """An end of the wire by the slow clock; at the robot's side things go wrong there."""

    fault = ""
    trouble: Any = None  # whether something goes wrong anywhere: a value of both processes

    def begin(self, fault: str, seed: int) -> None:
        """Let something go wrong from now on."""
        self.trouble.value = True
        self.fault, self._rng = fault, np.random.default_rng(seed)
        self.kept: dict[str, Any] = {"joint": int(self._rng.integers(12)), "off": WRONG}

    def send(self, message: Any) -> None:
        """See `WireEnd`."""
        if self._rng_says_lost():
            return
        if self.fault in SPOILED:
            SPOILED[self.fault](message, self._rng, self.kept)
            message.seal()
        message["crc"] ^= self.fault == "checksums of readings are wrong"
        super().send(message)

    def _rng_says_lost(self) -> bool:
        return self.fault in LOST and self._rng.random() < LOST[self.fault]

    def receive(self, timeout: float) -> Any | None:
        """See `WireEnd`."""
        message = super().receive(timeout * SLOWER)
        if message is None and not self.trouble.value:
            message = super().receive(PATIENT)
        if message is not None:
            message["crc"] ^= self.fault == "checksums of commands are wrong"
        return None if self.fault == "commands are lost" else message


class WatchedBody(MotorRobot):
    """A robot that notes whether it was given power."""

    powered, torque_use = False, 0.0

    def take(self, targets: JointTargets | None) -> None:
        """See `MotorRobot`."""
        super().take(targets)
        given = self._given
        self.powered = bool(given.stiffness.any() or given.feedforward.any())
        self.torque_use = max(self.torque_use, float((abs(self.torques) / self.robot.effort_limits).max()))


class WatchedLoop(sf.RobotLoop):
    """A loop that notes the largest torque that it asked for, over its limit."""

    torque_use = 0.0

    def step(self, readings: sf.RobotReadings | None, now: float | None = None) -> JointTargets:
        """See `surefoot.RobotLoop`."""
        targets, last = super().step(readings, now), self.watch.last
        if last is not None:
            asked = targets.torques(last.positions[self._back], last.speeds[self._back])
            share = np.abs(asked) / self.robot.effort_limits[self._back]
            self.torque_use = max(self.torque_use, float(np.where(np.isnan(share), np.inf, share).max()))
        return targets


def _walk(end: Any, pipe: Any, lost: Any, trouble: Any, out: Path) -> None:
    """Be the controller: stand up and walk whenever that is possible, until told to end."""
    wired_loop.clock = SlowClock(lost)  # type: ignore[attr-defined, assignment]
    robot = sf.load_robot("go2")
    dialect = dialect_of(robot)
    loop = WatchedLoop(robot, motors=dialect.motors)
    log = LoopLog(loop)
    loop.steer([0.5, 0.0, 0.0])
    with closing(FaultyEnd(dialect, False, "lo", DOMAIN)) as wire:
        wire.trouble = trouble
        wired = wired_loop.WiredLoop(loop, wire, dialect, watch=log.note)
        pipe.send(0.0)
        wired.wait(30.0)
        while not end.is_set():
            wired.step()
            try:
                if loop.mode is LoopMode.DAMP:
                    loop.go("stand")
                elif loop.mode is LoopMode.STAND and loop.settled:
                    loop.go("walk")
            except sf.ProblemError:
                continue  # not yet
    log.log().save(out)
    pipe.send(loop.torque_use)


def _go_wrong(wired: WiredRobot, fault: str, seed: int, other: int) -> tuple[float, bool]:
    """Let one fault happen; return how long the joints stayed powered [s], and whether that was right."""
    body, end = wired.robot, wired.end
    assert isinstance(body, WatchedBody)
    assert isinstance(end, FaultyEnd)
    end.begin(fault, seed)
    wrong = begin = body.time
    damped = None
    if fault == STOPPED[0]:
        os.kill(other, signal.SIGSTOP)
    elif fault == STOPPED[1]:
        subprocess.Popen(["sh", "-c", f"sleep {LASTS * SLOWER}; kill -CONT {os.getpid()}"])
        os.kill(os.getpid(), signal.SIGSTOP)
    while body.time < begin + LASTS:
        wired.step()
        if end.kept["off"] < WRONG:  # a joint that is frozen where it would be anyway
            wrong = body.time
        if not body.powered and damped is None:
            damped = body.time
    if fault == STOPPED[0]:
        os.kill(other, signal.SIGCONT)
    end.fault, end.trouble.value = "", False
    if fault in BEARABLE:
        return LASTS, damped is None and body.world.q_v()[0][2] > 0.25
    if end.kept["off"] < WRONG:
        return 0.0, True
    late = np.inf if damped is None else max(damped - wrong, 0.0)
    return late, late <= ALLOWED + 1e-9


def _suffer(count: int, other: int, pipe: Any, lost: Any, trouble: Any) -> None:
    """Be the robot: walk, let something go wrong, and begin anew."""
    motor_robot.clock = SlowClock(lost)  # type: ignore[attr-defined, assignment]
    robot = sf.load_robot("go2")
    dialect, body = dialect_of(robot), WatchedBody(robot)
    with closing(FaultyEnd(dialect, True, "lo", DOMAIN)) as wire:
        wire.trouble = trouble
        pipe.recv()
        wired = SlowRobot(body, wire, dialect)
        for k in range(count):
            if not body.powered or FAULTS[(k - 1) % len(FAULTS)] not in BEARABLE:
                body.reset(robot.nominal)
            begin, start = body.time, float(body.world.q_v()[0][0])
            while body.world.q_v()[0][0] < start + ON_THE_WAY and body.time < begin + LONGEST:
                wired.step()
            walks = body.time < begin + LONGEST
            pipe.send((FAULTS[k % len(FAULTS)], walks, *_go_wrong(wired, FAULTS[k % len(FAULTS)], k, other)))
    pipe.send(body.torque_use)


def suffer(count: int, out: Path, said: Callable[[str], None]) -> dict[str, Any]:
    """Return what came of so many faults; `said` is called with a line for each."""
    context = multiprocessing.get_context("spawn")
    end, lost, trouble = context.Event(), context.Value("d"), context.Value("b")
    (ours, theirs), (mine, his) = context.Pipe(), context.Pipe()
    controller = context.Process(target=_walk, args=(end, theirs, lost, trouble, out), daemon=True)
    controller.start()
    theirs.close()  # who dies ends the pipe
    robot = context.Process(target=_suffer, args=(count, controller.pid, his, lost, trouble), daemon=True)
    robot.start()
    his.close()
    mine.send(ours.recv())
    rows = []
    for k in range(count):
        fault, walks, late, right = mine.recv()
        rows.append({"fault": fault, "powered": late, "right": bool(right and walks)})
        said(
            f"{k + 1}: {fault}: powered for {1e3 * late:.0f} ms, {'right' if rows[-1]['right'] else 'WRONG'}"
        )
    given = mine.recv()
    end.set()
    asked = ours.recv()
    controller.join(30.0)
    robot.join(30.0)
    return {
        "faults": rows, "right": sum(row["right"] for row in rows), "torque_asked": asked,
        "torque_given": given, "exit_codes": [controller.exitcode, robot.exitcode], "log": str(out),
    }  # fmt: skip
