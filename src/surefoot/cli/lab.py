"""`surefoot lab ...`: pages in a browser that follow the mouse."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli import extras
from surefoot.cli import run_options as options
from surefoot.cli import shared_options as shared
from surefoot.cli.console import plain_console, say
from surefoot.cli.literal_help import LiteralHelpCommand
from surefoot.cli.option_groups import ungrouped
from surefoot.cli.robots import load

if TYPE_CHECKING:
    from surefoot.lab.page import Page

LOCAL = "127.0.0.1"
"""Host of this machine alone."""

app = typer.Typer(help="Pages in a browser that follow the mouse.", no_args_is_help=True)


@dataclass(frozen=True)
class Served:
    """Where a page is served, and how long."""

    port: Annotated[int, typer.Option(help="Port of the page; 0 for any that is free.")] = 8080
    host: Annotated[str, typer.Option(help="Address to serve at; this machine alone unless given.")] = LOCAL
    seconds: Annotated[
        float | None, typer.Option("--seconds", help="Serve so long [s]; None for until Ctrl-C.")
    ] = None

    def check(self, *packages: str) -> None:
        """Refuse, before any work, what cannot be served."""
        from surefoot.lab.server import check_free

        extras.require(["viser", *packages])
        if self.seconds is not None:
            real_number("--seconds", self.seconds, low=0.0)
        check_free(self.host, self.port)

    def serve(self, make_page: Callable[[], Page]) -> int:
        """Serve a page until Ctrl-C, or so many seconds."""
        from surefoot.cli.signals import ends_softly
        from surefoot.lab.server import LabServer

        with ends_softly() as stop:
            try:
                with LabServer(make_page, self.host, self.port) as server:
                    console = plain_console()
                    say(console, f"the page: {server.url}   (Ctrl-C ends)")
                    if self.host != LOCAL:
                        say(console, "everyone who reaches this address can use the page")
                    sys.stdout.flush()
                    server.wait(self.seconds)
            except KeyboardInterrupt:
                return 0 if stop.number is None else stop.code
        return 0


@app.callback()
def lab() -> None:
    """Open a page in a browser: a stance, a cone, a robot to push, a plan, a log; Ctrl-C ends it."""


def stand(
    *,
    robot: shared.RobotName = None,
    urdf: shared.Urdf = None,
    feet: shared.FootFrames = None,
    mu: options.Friction = 0.6,
    slope: Annotated[float, typer.Option(help="Slope of the ground [deg].")] = 0.0,
    at: Served,
) -> int:
    """Drag the centre of mass and the feet, tilt the ground: cones, forces, region and verdict follow."""
    at.check("pin", *_robot_packages(robot, urdf))
    import numpy as np

    from surefoot.cli import parsing
    from surefoot.lab.stand import StandPage, start_state

    parsing.friction("--mu", mu)
    real_number("--mu", mu, high=1.5)
    real_number("--slope", slope, low=0.0, high=60.0)
    state = start_state(load(robot, urdf, feet, feet_needed=True))
    state = replace(state, mu=np.full(len(state.names), mu), slope=slope)
    return at.serve(lambda: StandPage(state))


def cone(
    *,
    mu: options.Friction = 0.6,
    facets: Annotated[int, typer.Option(help="Sides of the pyramids.")] = 4,
    at: Served,
) -> int:
    """See the round cone, the pyramids inside and around it, and a force in space and in section."""
    at.check()
    from surefoot.lab.cone import ConePage, ConeState

    real_number("--mu", mu, low=0.0, high=1.5)
    real_number("--facets", facets, low=3, high=24)
    return at.serve(lambda: ConePage(ConeState(mu, facets)))


def push(
    *,
    robot: shared.RobotName = None,
    urdf: shared.Urdf = None,
    feet: shared.FootFrames = None,
    gait: Annotated[str, typer.Option(help="stand, trot, walk, pace, bound or flying_trot.")] = "trot",
    mu: options.Friction = 0.6,
    payload: Annotated[float, typer.Option(help="Mass fixed to the base's origin at first [kg].")] = 0.0,
    at: Served,
) -> int:
    """Kick a walking robot with the mouse; change friction, payload, gait and speed while it walks."""
    at.check("pin", "mujoco", *_robot_packages(robot, urdf))
    from surefoot.lab.push import PushPage
    from surefoot.lab.push_run import Choices, SharedRun, WalkRun

    real_number("--mu", mu, low=0.0, high=1.2)
    real_number("--payload", payload, low=0.0, high=10.0)
    model = load(robot, urdf, feet, feet_needed=True)
    with plain_console(stderr=True).status("starting the robot (a first run compiles)"):
        run = WalkRun(model, Choices(mu=mu, payload=payload, gait=gait))
    everyone = SharedRun(run)
    try:
        return at.serve(lambda: PushPage(everyone, run.contact_names, run.names))
    finally:
        everyone.close()


def plan(
    *,
    source: Annotated[
        str, typer.Argument(help="A saved plan.npz, or a task of `surefoot plan` to plan first.")
    ],
    amount: Annotated[float | None, typer.Argument(help="The task's number.")] = None,
    robot: Annotated[
        str | None, typer.Option(help="A known robot, where it is not the one that the plan names.")
    ] = None,
    at: Served,
) -> int:
    """Scrub a plan: the robot, its forces and cones at every knot."""
    at.check("pin", *_robot_packages(robot, None))
    from surefoot.lab.recording import Recording, plan_page
    from surefoot.robot import load_robot

    whose = None if robot is None else load_robot(robot)
    made = _plan(source, amount, whose)
    recording = Recording(made, whose or made.robot, made.terrain)
    return at.serve(lambda: plan_page(recording, made))


def audit(
    *,
    log: Annotated[Path, typer.Argument(help="A log: .npz or any other format that sf.read_log reads.")],
    robot: shared.LogRobot = None,
    at: Served,
) -> int:
    """Scrub a log, and jump to the violations of the laws of contact."""
    at.check("pin", *_robot_packages(robot, None))
    from surefoot.audit import audit_log
    from surefoot.lab.recording import Recording, audit_page
    from surefoot.log import read_log
    from surefoot.robot import load_robot

    read, whose = read_log(log), None if robot is None else load_robot(robot)
    recording = Recording(read, whose)
    report = audit_log(read, whose)
    return at.serve(lambda: audit_page(recording, report))


for _command in (stand, cone, push, plan, audit):
    app.command(_command.__name__, cls=LiteralHelpCommand)(ungrouped(_command))


def _robot_packages(robot: str | None, urdf: Path | None) -> tuple[str, ...]:
    """Return what loading a robot needs."""
    return extras.robot_packages(robot or (None if urdf is None else str(urdf)))


def _plan(source: str, amount: float | None, robot: Any) -> Any:
    """Return a plan from a file, or from a search for a task's."""
    from surefoot.errors import ProblemError
    from surefoot.planning import Plan
    from surefoot.planning.planner import plan as search
    from surefoot.planning.tasks.table import find_task

    if source.endswith(".npz") or Path(source).exists():
        if amount is not None:
            raise ProblemError(f"a saved plan takes no number, got {amount:g}")
        return Plan.read(source)
    task = find_task(source)
    if robot is None and task.robots:
        robot = load(None, None, None)
    with plain_console(stderr=True).status(f"planning {source}"):
        return search(robot, source, amount)
