"""`surefoot drive`: stand a robot up and walk it over the wire."""

from __future__ import annotations

import gc
import os
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
    from surefoot.mechanics import Robot
    from surefoot.motion import Dialect, WireEnd
    from surefoot.motion.drive.loop_log import LoopLog
    from surefoot.motion.drive.robot_loop import RobotLoop
    from surefoot.motion.drive.wire.survey import Survey
    from surefoot.motion.drive.wire.wired_loop import WiredLoop
    from surefoot.records import Log

LOOPBACK = "lo"
"""The interface that leads to no robot."""
PATIENCE = 30.0
"""How long a robot's first word is waited for [s]."""
USUAL = 500.0
"""Rate of a robot's readings [Hz]."""
Interface = Annotated[str, typer.Option(help="Network interface; lo reaches this machine alone.")]
DomainId = Annotated[
    int, typer.Option(help="DDS domain: 1 is Unitree's simulators' own, 0 its robots'; see --simulator.")
]
DdsConfig = Annotated[
    Path | None,
    typer.Option(help="Cyclone DDS's configuration, an XML file; else the one that CYCLONEDDS_URI names."),
]
SlowMotion = Annotated[
    bool,
    typer.Option(
        "--slow-motion", help="Each side waits for the other: for machines that are busy; on both sides."
    ),
]

Rate = Annotated[
    float | None,
    typer.Option(help="Readings and commands a second [Hz]; left out: 500, or a simulator's own rate."),
]
Simulator = Annotated[
    bool,
    typer.Option(
        "--simulator",
        help="A simulator speaks: checksum 0 and motors of mode 0 pass, and no clock is strict. Found by "
        "itself where checksum, tick and modes are all 0, on lo.",
    ),
]


def own_config(file: Path | None) -> str:
    """Return the user's own configuration of DDS: a file, or what the environment says; empty for none."""
    from surefoot.motion.drive.wire.dds_config import VARIABLE

    return os.environ.get(VARIABLE, "") if file is None else file.resolve().as_uri()


@contextmanager
def wire_end(
    model: Any, robot_side: bool, interface: str, domain: int, config: str = "", simulator: bool = False
) -> Iterator[tuple[WireEnd, Dialect]]:
    """Open an end of the wire for a robot."""
    extras.require(["cyclonedds"])
    from surefoot.motion import WireEnd
    from surefoot.motion.drive.wire.dialect import dialect_of

    dialect = dialect_of(model, simulator)
    with closing(WireEnd(dialect, robot_side, interface, domain, config=config)) as end:
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
    rate: Rate = None,
    simulator: Simulator = False,
    slow_motion: SlowMotion = False,
    dds_config: DdsConfig = None,
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
    from surefoot.motion.drive.wire.survey import listen

    config = own_config(dds_config)
    outside = _check_wire(interface, config, yes_real_robot)
    _check_options(out, end, terrain_knowledge, duration, rate)
    parsing.friction("--mu", mu)
    wanted = parsing.velocity(velocity)
    model = load(robot, None, feet_needed=True)
    console = plain_console(quiet=as_json)
    with (
        wire_end(model, False, interface, domain, config, simulator) as (wire, dialect),
        ends_softly(emergency=True),
    ):
        survey = listen(wire, dialect, PATIENCE, slow=slow_motion, hint=_hint)
        maker = _LoopMaker(model, dialect, survey, simulator, rate, slow_motion)
        maker.check(outside)
        loop = maker.loop(mu, terrain_knowledge)
        log = LoopLog(loop)
        wired = maker.connect(loop, wire, log)
        with _no_garbage():
            wired.wait(PATIENCE)
            what = "a simulator" if maker.simulator else model.name
            say(console, f"{what} speaks on {interface}, {1.0 / loop.dt:g} Hz: {model.name} stands up")
            fault = _go_out(wired, (wanted, duration, end), out, log)
    outcome = f"ended by a fault: {fault}" if fault else f"stood, walked {duration:g} s, and went to {end}"
    facts = {"fault": fault, "balanced": len(log.rows) * loop.dt}
    show(facts, as_json, lambda console, _: say(console, outcome))
    return 1 if fault else 0


def _go_out(wired: WiredLoop, outing: tuple[Any, float, str], out: Path | None, log: LoopLog) -> str:
    """Return the fault of an outing, empty for none; Ctrl-C damps the robot, and the log is kept."""
    try:
        return wired.outing(*outing)
    except KeyboardInterrupt:
        wired.go("damp", 0.5)
        return "interrupted"
    finally:
        if out is not None and log.rows:
            _save(log.log(), out)


def _hint(text: str) -> None:
    """Say what to look at, beside what is printed for programs."""
    say(plain_console(stderr=True), text)


@contextmanager
def _no_garbage() -> Iterator[None]:
    """Keep Python from collecting garbage by itself: the loop does between its steps."""
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
        gc.unfreeze()


def _check_options(out: Path | None, end: str, knowledge: str, duration: float, rate: float | None) -> None:
    """Refuse what `drive` cannot do or write."""
    from surefoot.records.log.formats import new_file

    if out is not None:
        new_file(out)
        check_out(out.parent)
    check_name("--end", end, ("sit", "lie"))
    check_name("--terrain-knowledge", knowledge, ("exact", "blind"))
    real_number("--duration", duration, low=0.0, high=parsing.FOREVER)
    if rate is not None:
        real_number("--rate", rate, low=50.0, high=1000.0)


def _check_wire(interface: str, config: str, yes_real_robot: bool) -> bool:
    """Return whether the wire leads to another machine; refuse that unless somebody said yes."""
    from surefoot.motion.drive.wire.dds_config import leads_outside

    outside = leads_outside(interface, config)
    if outside and not yes_real_robot:
        where = f"--interface {interface}" if interface != LOOPBACK else "the configuration of DDS"
        raise ProblemError(
            f"{where} may lead to a real robot: hang it up, see docs/wire.md, then add --yes-real-robot"
        )
    return outside


class _LoopMaker:
    """What the loop is made with, after what was heard on the wire."""

    def __init__(
        self, model: Robot, dialect: Dialect, survey: Survey, simulator: bool, rate: float | None, slow: bool
    ) -> None:  # fmt: skip
        self.model, self.survey, self.slow = model, survey, slow
        self.simulator = simulator or survey.simulated
        self.dialect = dialect.of_simulator() if self.simulator else dialect
        own = survey.rate if self.simulator and not slow else USUAL
        self.dt = 1.0 / (own if rate is None else rate)

    def check(self, outside: bool) -> None:
        """Refuse a robot that cannot be used, and a simulator beyond this machine that nobody announced."""
        from surefoot.motion.drive.wire.survey import refuse_void

        if outside or not self.simulator:
            refuse_void(self.survey)

    def loop(self, mu: float, terrain: str) -> RobotLoop:
        """Return the loop."""
        from surefoot.motion.drive.robot_loop import RobotLoop
        from surefoot.motion.drive.wire.simulator import simulator_limits

        limits = simulator_limits(self.dt) if self.simulator else None
        return RobotLoop(
            self.model, self.dt, motors=self.dialect.motors, mu=mu, terrain=terrain, limits=limits
        )

    def connect(self, loop: RobotLoop, end: WireEnd, log: LoopLog) -> WiredLoop:
        """Return the loop at the end of the wire."""
        from surefoot.motion.drive.wire.simulator import SimulatorClock
        from surefoot.motion.drive.wire.wired_loop import WiredLoop

        clock = SimulatorClock(self.dt, self.survey.ticking) if self.simulator else None
        return WiredLoop(loop, end, self.dialect, self.slow, log.note, clock)


def _save(log: Log, out: Path) -> None:
    """Write a log to a new file, in a new folder if need be."""
    with writing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
        log.save(out)
