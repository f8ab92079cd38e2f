"""`surefoot lab PAGE`: pages in a browser that follow the mouse."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import Future, wait
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Annotated, Any

import typer

from surefoot.app.cli import extras, options, parsing
from surefoot.app.cli.console import plain_console, say, show
from surefoot.app.cli.robots import load
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.app.lab.page import Page

AT_ONCE = 1.0
"""How long a page may take to be ready before it is opened and says that it is not [s]."""
LOCAL = "127.0.0.1"
"""Host of this machine alone."""


def lab(
    page: Annotated[str, typer.Argument(help="stand, cone, push, plan or audit.")],
    subject: Annotated[
        str | None,
        typer.Argument(
            help="Of stand and push: ROBOT (default go2), a name or a file; of plan: a saved plan.npz or a "
            "task of `surefoot plan`; of audit: a log."
        ),
    ] = None,
    amount: Annotated[float | None, typer.Argument(help="The number of plan's task.")] = None,
    feet: options.FootFrames = None,
    robot: options.LogRobot = None,
    velocity: Annotated[
        str | None,
        typer.Option(
            help="Of push at first: forward, left [m/s], yaw rate [rad/s]; the rest may be left out."
        ),
    ] = None,
    port: Annotated[int, typer.Option(help="Port of the page; 0 for any that is free.")] = 8080,
    host: Annotated[str, typer.Option(help="Address to serve at; this machine alone unless given.")] = LOCAL,
    seconds: Annotated[
        float | None, typer.Option("--seconds", help="Serve so long [s]; None for until Ctrl-C.")
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Open a page in a browser: a stance, a cone, a robot to push, a plan, a log; Ctrl-C ends it."""
    from surefoot.app.lab.server import check_free

    check_name("page", page, PAGES)
    make, takes, packages = PAGES[page]
    given = {"subject": subject, "amount": amount, "feet": feet, "robot": robot, "velocity": velocity}
    for name, value in given.items():
        if value is not None and name not in takes:
            raise ProblemError(
                f"lab {page} takes no {name if name in ('subject', 'amount') else f'--{name}'}"
            )
    if page in ("plan", "audit") and subject is None:
        raise ProblemError(f"lab {page} needs {'a plan or a task' if page == 'plan' else 'a log'}")
    whose = subject if "feet" in takes else robot
    extras.require(["viser", *packages, *(extras.robot_packages(whose) if packages else ())])
    if seconds is not None:
        real_number("--seconds", seconds, low=0.0, high=parsing.FOREVER)
    check_free(host, port)
    starting: Future[Callable[[], Page]] = Future()

    def prepare() -> None:
        try:
            starting.set_result(make(**{name: given[name] for name in takes}))
        except BaseException as error:
            starting.set_exception(error)

    Thread(target=prepare, name="lab-start", daemon=True).start()
    wait([starting], AT_ONCE)
    return _serve(starting, host, port, seconds, as_json)


def _serve(
    starting: Future[Callable[[], Page]], host: str, port: int, seconds: float | None, as_json: bool
) -> int:
    """Serve a page until Ctrl-C, or so many seconds; one that is not ready says so in the browser."""
    from surefoot.app.cli.signals import ends_softly
    from surefoot.app.lab.server import LabServer

    with ends_softly() as stop:
        try:
            if starting.done():
                starting.result()
            with LabServer(lambda: starting.result()(), host, port) as server:
                where = f"the page: {server.url}   (Ctrl-C ends)"
                all_may = "" if host == LOCAL else "everyone who reaches this address can use the page"
                show({"url": server.url}, as_json, lambda console, _: say(console, where, all_may))
                sys.stdout.flush()
                while not starting.done():  # in short waits, which a signal can end
                    wait([starting], AT_ONCE)
                starting.result()
                server.wait(seconds)
        except KeyboardInterrupt:
            return 0 if stop.number is None else stop.code
    return 0


def _stand(subject: str | None, feet: str | None) -> Callable[[], Page]:
    """Drag the centre of mass and the feet, tilt the ground: cones, forces, region and verdict follow."""
    from surefoot.app.lab.stand import StandPage, start_state
    from surefoot.app.lab.standing_pose import StandingPose

    robot = load(subject, feet, feet_needed=True)
    state = start_state(robot)
    return lambda: StandPage(state, StandingPose(robot).shapes)


def _cone() -> Callable[[], Page]:
    """See the round cone, the pyramids inside and around it, and a force in space and in section."""
    from surefoot.app.lab.cone import ConePage, ConeState

    return lambda: ConePage(ConeState(0.6, 4))


def _push(subject: str | None, feet: str | None, velocity: str | None) -> Callable[[], Page]:
    """Kick a walking robot with the mouse; change friction, payload, gait and speed while it walks."""
    from surefoot.app.lab.push import PushPage
    from surefoot.app.lab.push_run import Choices, WalkRun

    model = load(subject, feet, feet_needed=True)
    chosen = Choices() if velocity is None else Choices(velocity=parsing.velocity(velocity))
    with plain_console(stderr=True).status("starting the robot (a first run compiles)"):
        WalkRun(model, chosen)
    return lambda: PushPage(WalkRun(model, chosen))


def _plan(subject: str, amount: float | None, robot: str | None) -> Callable[[], Page]:
    """Scrub a plan: the robot, its forces and cones at every knot."""
    from surefoot.app.lab.recording import RecordedMotion, plan_page

    whose = None if robot is None else load(robot)
    made = _plan_of(subject, amount, whose)
    recording = RecordedMotion(made, whose or made.robot, made.terrain)
    return lambda: plan_page(recording, made)


def _audit(subject: str, robot: str | None) -> Callable[[], Page]:
    """Scrub a log, and jump to the violations of the laws of contact."""
    from surefoot.app.lab.recording import RecordedMotion, audit_page
    from surefoot.records import audit_log, read_log

    log, whose = read_log(subject), None if robot is None else load(robot)
    recording = RecordedMotion(log, whose)
    report = audit_log(log, whose)
    return lambda: audit_page(recording, report)


PAGES: dict[str, tuple[Callable[..., Callable[[], Page]], tuple[str, ...], tuple[str, ...]]] = {
    "stand": (_stand, ("subject", "feet"), ("pin",)),
    "cone": (_cone, (), ()),
    "push": (_push, ("subject", "feet", "velocity"), ("pin", "mujoco")),
    "plan": (_plan, ("subject", "amount", "robot"), ("pin",)),
    "audit": (_audit, ("subject", "robot"), ("pin",)),
}
"""Page -> what makes it, what it takes, and the packages that it needs."""


def _plan_of(source: str, amount: float | None, robot: Any) -> Any:
    """Return a plan from a file, or from a search for a task's."""
    from surefoot.motion.planning import Plan
    from surefoot.motion.planning.planner import plan as search
    from surefoot.motion.planning.tasks.task_names import find_task

    if source.endswith(".npz") or Path(source).exists():
        if amount is not None:
            raise ProblemError(f"a saved plan takes no number, got {amount:g}")
        return Plan.read(source)
    task = find_task(source)
    if robot is None and task.robots:
        robot = load(None)
    with plain_console(stderr=True).status(f"planning {source}"):
        return search(robot, source, amount)
