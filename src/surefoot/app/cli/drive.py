"""`surefoot drive`: stand a robot up and walk it over the wire."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import extras, options, parsing
from surefoot.app.cli.console import plain_console, say, show
from surefoot.app.cli.output import check_out
from surefoot.app.cli.robots import load
from surefoot.app.cli.signals import ends_softly
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name, writing

if TYPE_CHECKING:
    from surefoot.motion import Dialect, WireEnd
    from surefoot.records import Log

LOOPBACK = "lo"
"""The interface that leads to no robot."""
Interface = Annotated[str, typer.Option(help="Network interface; lo reaches this machine alone.")]
DomainId = Annotated[int, typer.Option(help="DDS domain: 1 as Unitree's simulator, 0 as its robots.")]
SlowMotion = Annotated[
    bool,
    typer.Option(
        "--slow-motion", help="Each side waits for the other: for machines that are busy; on both sides."
    ),
]


@contextmanager
def wire_end(model: Any, robot_side: bool, interface: str, domain: int) -> Iterator[tuple[WireEnd, Dialect]]:
    """Open an end of the wire for a robot."""
    extras.require(["cyclonedds"])
    from surefoot.motion import WireEnd
    from surefoot.motion.drive.wire.dialect import dialect_of

    dialect = dialect_of(model)
    with closing(WireEnd(dialect, robot_side, interface, domain)) as end:
        yield end, dialect


def drive(
    *,
    robot: options.RobotName = None,
    interface: Interface = LOOPBACK,
    domain: DomainId = 1,
    velocity: Annotated[
        str, typer.Option(help="VX,VY,WZ: forward, left [m/s], yaw rate [rad/s].")
    ] = "0.5,0,0",
    duration: Annotated[float, typer.Option(help="How long to walk [s].")] = 10.0,
    end: Annotated[str, typer.Option(help="sit or lie: how it ends.")] = "sit",
    mu: options.Friction = 0.6,
    terrain_knowledge: Annotated[
        str, typer.Option(help="exact: the ground is flat; blind: the plane that the feet find.")
    ] = "exact",
    slow_motion: SlowMotion = False,
    yes_real_robot: Annotated[
        bool, typer.Option("--yes-real-robot", help="The robot hangs on a frame, and nobody is in its reach.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="Log of the balanced part: a new .npz or .mcap.")] = None,
    as_json: options.AsJson = False,
) -> int:
    """Stand a robot up over DDS, walk it, stop it and sit it down; Ctrl-C damps it.

    Speaks Unitree's rt/lowstate and rt/lowcmd. Exit code 0 if all went well, 1 after a fault, 2 for wrong
    input.
    """
    from surefoot.motion.drive.loop_log import LoopLog
    from surefoot.motion.drive.robot_loop import RobotLoop
    from surefoot.motion.drive.wire.wired_loop import WiredLoop
    from surefoot.records.log.formats import new_file

    if interface != LOOPBACK and not yes_real_robot:
        raise ProblemError(
            f"--interface {interface} may lead to a real robot: hang it up, see docs/wire.md, then add "
            "--yes-real-robot"
        )
    if out is not None:
        new_file(out)
        check_out(out.parent)
    check_name("--end", end, ("sit", "lie"))
    check_name("--terrain-knowledge", terrain_knowledge, ("exact", "blind"))
    real_number("--duration", duration, low=0.0, high=parsing.FOREVER)
    parsing.friction("--mu", mu)
    wanted = parsing.velocity(velocity)
    model = load(robot, None, feet_needed=True)
    with wire_end(model, False, interface, domain) as (wire, dialect), ends_softly():
        loop = RobotLoop(model, motors=dialect.motors, mu=mu, terrain=terrain_knowledge)
        log = LoopLog(loop)
        wired = WiredLoop(loop, wire, dialect, slow_motion, log.note)
        gc.freeze()
        gc.disable()  # the loop collects between its steps
        wired.wait(30.0)
        say(plain_console(quiet=as_json), f"{model.name} speaks on {interface}: standing up")
        try:
            fault = wired.outing(wanted, duration, end)
        except KeyboardInterrupt:
            fault = "interrupted"
            wired.go("damp", 0.5)
        finally:
            if out is not None and log.rows:
                _save(log.log(), out)
    outcome = f"ended by a fault: {fault}" if fault else f"stood, walked {duration:g} s, and went to {end}"
    facts = {"fault": fault, "balanced": len(log.rows) * loop.dt}
    show(facts, as_json, lambda console, _: say(console, outcome))
    return 1 if fault else 0


def _save(log: Log, out: Path) -> None:
    """Write a log to a new file, in a new folder if need be."""
    with writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
        log.save(out)
