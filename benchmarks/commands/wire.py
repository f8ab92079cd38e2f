"""`surefoot bench wire`: from a reading on the wire to the command that answers it, beside an echo."""

from __future__ import annotations

import gc
import multiprocessing
import sys
import tempfile
import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli import extras
from surefoot.app.cli.console import plain_console, say, show
from surefoot.base.errors import SurefootError
from surefoot.records.log.reading import read_log

SHARES = (50.0, 99.0, 99.9, 100.0)
DOMAIN = 93


def wire(
    seconds: Annotated[float, typer.Option(min=1.0, help="Length of the walk that is measured [s].")] = 20.0,
    quick: Annotated[bool, typer.Option("--quick", help="Two seconds, or two faults.")] = False,
    faults: Annotated[int, typer.Option(min=0, help="Let so many things go wrong in place of it.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> int:
    """Time the answers of a controller that walks a Go2 over loopback, and of an echo in the same run."""
    extras.require(["cyclonedds", "mujoco", "pin", "example-robot-data"])
    sys.path.append(str(Path(__file__).parents[2]))  # where new processes find these modules
    if faults:
        return _suffer(min(faults, 2) if quick else faults, json)
    context = multiprocessing.get_context("spawn")
    servers = [context.Process(target=_serve, args=(kind,), daemon=True) for kind in ("loop", "echo")]
    for server in servers:
        server.start()
    times = _measure(2.0 if quick else seconds, servers)
    for server in servers:
        server.terminate()
    rows = {kind: [1e6 * float(np.percentile(t, s)) for s in SHARES] for kind, t in times.items()}

    def in_words(console: Console, _: object) -> None:
        header = ("answer by", "median [us]", "99 %", "99.9 %", "most", "answers")
        lines = [(k, *(f"{x:.0f}" for x in row), str(len(times[k]))) for k, row in rows.items()]
        console.print(table(header, lines, "From a reading to its command, 500 Hz"))

    show(rows, json, in_words)
    return 0


def _suffer(count: int, as_json: bool) -> int:
    """Let things go wrong on the wire, and return the exit code."""
    from benchmarks.wire_faults import suffer

    console = plain_console(quiet=as_json)
    with tempfile.TemporaryDirectory() as folder:
        done = suffer(count, Path(folder) / "walk.npz", lambda line: say(console, line))
        rows = len(read_log(done["log"]))
    last = (
        f"{done['right']} of {count} right; torque asked at most {done['torque_asked']:.3f} of its limit, "
        f"given {done['torque_given']:.3f}; exit codes {done['exit_codes']}; {rows} rows in the log"
    )
    show(done, as_json, lambda console, _: say(console, last))
    within = max(done["torque_asked"], done["torque_given"]) <= 1.0 + 1e-9
    return 0 if done["right"] == count and within and not any(done["exit_codes"]) else 1


def _end(kind: str, robot_side: bool) -> tuple[Any, Any, Any]:
    """Return robot, dialect and an end of a wire of that name."""
    import surefoot as sf
    from surefoot.motion.drive.wire.dialect import dialect_of
    from surefoot.motion.drive.wire.link import WireEnd

    robot = sf.load_robot("go2")
    dialect = dialect_of(robot)
    return robot, dialect, WireEnd(dialect, robot_side, "lo", DOMAIN, (f"{kind}/state", f"{kind}/command"))


def _serve(kind: str) -> None:
    """Answer states for good: by an echo of the tick, or by a loop that walks."""
    robot, dialect, end = _end(kind, False)
    from surefoot.motion.control.controller import JointTargets
    from surefoot.motion.drive.robot_loop import RobotLoop

    loop = RobotLoop(robot, motors=dialect.motors) if kind == "loop" else None
    still = JointTargets(*np.zeros((5, 12)))
    gc.freeze()
    gc.disable()  # as `surefoot drive`
    while True:
        message = end.receive(0.1)
        if message is None:
            continue
        targets = still
        if loop is not None:
            targets = loop.step(dialect.readings(message))
            goal = {250: "stand", 2200: "walk"}.get(round(loop.time / loop.dt))
            if goal is not None:
                loop.steer([0.5, 0.0, 0.0])
                loop.go(goal)
        command = dialect.command_message(targets)
        command["reserve"] = message["tick"]
        end.send(command.seal())
        if loop is not None:
            loop.plan_ahead()
        gc.collect(1)


def _measure(seconds: float, servers: list[Any]) -> dict[str, Any]:
    """Return the times between a state and its answer [s] while the loop walks a robot in MuJoCo."""
    from surefoot.motion.control.controller import JointTargets
    from surefoot.worlds.running.motor_robot import MotorRobot

    robot, dialect, loop = _end("loop", True)
    echo = _end("echo", True)[2]
    body = MotorRobot(robot)
    body.lie_down()
    order = np.array([robot.joint_names.index(name) for name in dialect.motors])
    times: dict[str, list[float]] = {"loop": [], "echo": []}
    begin, turn, ends = 0.0, time.perf_counter(), [("echo", echo), ("loop", loop)]
    gc.freeze()
    while begin == 0.0 or body.time - begin < 4.4 + seconds:
        if not all(server.is_alive() for server in servers):
            raise SurefootError("who should answer has ended: see above")
        time.sleep(max(turn - time.perf_counter(), 0.0))
        turn = max(turn + body.dt, time.perf_counter())
        state = dialect.state_message(body.read().ordered(order))
        ends.reverse()  # in turns: three processes on two cores are in nobody's way
        for kind, end in ends:
            due = time.perf_counter()
            end.send(state)
            command = end.receive(0.2)
            while command is not None and command["reserve"] != state["tick"]:
                command = end.receive(0.2)
            if command is None:
                continue
            if kind == "loop":
                begin = begin or body.time
                targets = dialect.targets(command)
                body.take(None if targets is None else JointTargets(*(v[np.argsort(order)] for v in targets)))
            if begin and body.time - begin > 4.4:
                times[kind].append(time.perf_counter() - due)
        body.step()
    return times
