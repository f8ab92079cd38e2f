"""`surefoot walk`: a simulated robot walks, and every contact force is accounted for."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli.console import plain_console
from surefoot.cli.engine_warnings import engine_warnings
from surefoot.cli.output import new_run_folder, to_json
from surefoot.cli.progress import progress_bar
from surefoot.cli.robots import load
from surefoot.cli.signals import ends_softly
from surefoot.errors import ProblemError, unknown_name

SHORTEST = 0.5
"""Length of a walk that says something [s]: about a cycle of a trot."""


def walk(
    robot: Annotated[
        str | None, typer.Argument(help="A known robot (default go2); see --urdf for others.")
    ] = None,
    urdf: Annotated[Path | None, typer.Option(help="A URDF file instead of a known robot.")] = None,
    feet: Annotated[str | None, typer.Option(help="Foot frames, comma-separated.")] = None,
    gait: Annotated[
        str, typer.Option(help="stand, trot, walk, pace, bound, flying_trot, or a name in --gait-file.")
    ] = "trot",
    gait_file: Annotated[Path | None, typer.Option(help="Gaits in OCS2's format.")] = None,
    period: Annotated[float | None, typer.Option(help="Length of a cycle of the gait [s].")] = None,
    velocity: Annotated[
        str, typer.Option(help="VX,VY,WZ: forward, left [m/s], yaw rate [rad/s].")
    ] = "0.5,0,0",
    velocity_file: Annotated[
        Path | None, typer.Option(help="Lines of 'time vx vy yaw_rate' instead of --velocity.")
    ] = None,
    terrain: Annotated[
        str, typer.Option(help="flat, slope:DEG, stairs:HEIGHT,DEPTH or rough:SEED,HEIGHT [m].")
    ] = "flat",
    mu: Annotated[float, typer.Option(help="Friction of the ground.")] = 0.6,
    believed_mu: Annotated[
        float | None, typer.Option(help="Friction that the controller believes in; None for --mu.")
    ] = None,
    push: Annotated[list[str] | None, typer.Option(help="T:FX,FY,FZ:DURATION [s, N, s]; repeatable.")] = None,
    ice: Annotated[list[str] | None, typer.Option(help="T:MU, friction from time T on; repeatable.")] = None,
    payload: Annotated[
        float, typer.Option(help="Mass on the base that the controller does not know [kg].")
    ] = 0.0,
    noise: Annotated[float, typer.Option(help="Sensor noise, 1 for that of ordinary sensors.")] = 0.0,
    delay: Annotated[float, typer.Option(help="Delay of the torques [s].")] = 0.0,
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 10.0,
    seed: Annotated[int | None, typer.Option(help="Seed of the start and of all noise.")] = None,
    out: Annotated[Path, typer.Option(help="Parent of the run's new folder.")] = Path("runs"),
    video: Annotated[bool, typer.Option("--video/--no-video", help="Film the run.")] = True,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw plots and a report.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False,
) -> int:
    """Let a robot walk in simulation and account for every contact force.

    Exit code 0 if it walked to the end and no law was broken, 1 if not, 2 for wrong input.
    """
    from surefoot.cli import parsing
    from surefoot.cli.run_files import PARTS
    from surefoot.simulation.faults import Faults
    from surefoot.simulation.walking import WalkScenario, run_walking

    console = plain_console(quiet=as_json)
    _check_numbers(mu, believed_mu, duration, payload, noise, delay, seed)
    ground = parsing.terrain(terrain)
    command = _command(velocity, velocity_file)
    scenario = WalkScenario(
        duration, mu, parsing.each(parsing.push, push), parsing.each(parsing.ice, ice),
        seed, Faults(noise=noise, delay=delay),
    )  # fmt: skip
    for option, texts, events in (("--push", push, scenario.pushes), ("--ice", ice, scenario.ice)):
        parsing.within_run(option, texts, [event.start for event in events], duration)
    _require(robot if urdf is None else str(urdf.absolute()), video, report)
    model = load(robot, urdf, feet, feet_needed=True)
    schedule = _schedule(model, gait, gait_file, period)
    _check_steps(model, schedule, command)
    controller, world, q = _set_up(model, ground, schedule, command, mu, believed_mu, payload)
    for note in controller.notes:
        console.print(note, soft_wrap=True, highlight=False)
    folder = new_run_folder(out, f"walk-{model.name}")
    with ends_softly() as stop:
        with progress_bar(not as_json, "walking", duration) as tell, engine_warnings() as warned:
            log = run_walking(world, controller, q, scenario, tell, folder / PARTS)
        for line in warned:
            console.print(line, soft_wrap=True, highlight=False)
        summary = _write(model, ground, log, folder, video, report, console)
        if as_json:
            print(to_json(summary))
    if summary["outcome"] == "interrupted":
        return stop.code
    return 0 if summary["walked"] and not summary["laws_broken"] and not summary["unwritten"] else 1


def _check_numbers(
    mu: float,
    believed: float | None,
    duration: float,
    payload: float,
    noise: float,
    delay: float,
    seed: int | None,
) -> None:
    from surefoot.cli import parsing

    parsing.friction("--mu", mu)
    if believed is not None:
        parsing.friction("--believed-mu", believed)
    parsing.duration(duration, SHORTEST)
    real_number("--payload", payload, low=0.0, high=1e4)
    real_number("--noise", noise, low=0.0, high=100.0)
    real_number("--delay", delay, low=0.0, high=1.0)
    parsing.seed(seed)


def _require(robot: str | None, video: bool, report: bool) -> None:
    """Raise for all optional packages at once if one that a walk cannot do without is missing."""
    from surefoot.cli import extras

    wanted = (*(extras.FILM if video else ()), *(["matplotlib"] if report else []))
    extras.require((*extras.robot_packages(robot), "mujoco"), wanted)


def _schedule(robot: Any, gait: str, file: Path | None, period: float | None) -> Any:
    """Return a gait's name, or the schedule of a file."""
    from surefoot.control.gait import Gait
    from surefoot.control.gait_files import read_gaits
    from surefoot.control.gait_library import named_gait

    if file is None:
        return gait if period is None else named_gait(gait, len(robot.feet), period=period)
    gaits = read_gaits(file, len(robot.feet))
    if gait not in gaits:
        raise ProblemError(unknown_name(f"gait in {file}", gait, gaits))
    schedule = gaits[gait]
    return schedule.scaled(period) if period is not None and isinstance(schedule, Gait) else schedule


def _check_steps(robot: Any, schedule: Any, command: Any) -> None:
    """Refuse a velocity for a gait that takes no steps: it would pull a standing robot over."""
    everyone = (1 << len(robot.feet)) - 1
    still = schedule == "stand" if isinstance(schedule, str) else bool((schedule.modes == everyone).all())
    if still and command.values.any():
        name = schedule if isinstance(schedule, str) else getattr(schedule, "name", "of the file")
        raise ProblemError(f"gait {name!r} takes no steps: it goes with --velocity 0")


def _command(velocity: str, file: Path | None) -> Any:
    from surefoot.cli import parsing
    from surefoot.control.walking_body import VelocityCommand

    return (
        VelocityCommand.constant(*parsing.velocity(velocity)) if file is None else VelocityCommand.read(file)
    )


def _set_up(
    robot: Any, ground: Any, schedule: Any, command: Any, mu: float, believed: float | None, payload: float
) -> tuple[Any, Any, Any]:
    """Return controller, world and the configuration to start from."""
    from surefoot.control.walking import WalkingController, WalkSettings
    from surefoot.simulation.mujoco import MujocoWorld
    from surefoot.simulation.walk_terrain import check_ground, start_pose

    settings = WalkSettings(mu=mu if believed is None else believed)
    controller = WalkingController(robot, command, schedule, ground, settings)
    q = start_pose(robot, ground)
    check_ground(robot, ground, q, mu)
    return controller, MujocoWorld(robot, ground, mu, payload=payload), q


def _write(
    robot: Any, ground: Any, log: Any, folder: Path, video: bool, report: bool, console: Any
) -> dict[str, Any]:
    """Write everything that the run leaves, print the tables, and return the summary."""
    from surefoot.cli import run_files, walk_output
    from surefoot.simulation.walk_summary import summarise_walk
    from surefoot.viz.report import write_report
    from surefoot.viz.walk_plots import draw_walk

    written, page = run_files.Written(), folder / "report.html"
    written.attempt(folder / "log.npz", lambda: log.save(folder / "log.npz"))
    summary = summarise_walk(log)
    summary["unwritten"] = written.notes
    written.attempt(folder / "summary.json", lambda: run_files.write_summary(summary, folder))
    pictures = run_files.Pictures(log, folder)
    if video and summary["outcome"] != "interrupted":
        with progress_bar(not console.quiet, "filming", 1.0) as tell:
            pictures.film(robot, ground, tell)
    walk_output.print_summary(console, summary)
    line = walk_output.headline(summary)
    good = summary["walked"] and not summary["laws_broken"]
    if report:
        pictures.plot(draw_walk)
        sections = walk_output.report_sections(summary) + pictures.sections()
        title, command = f"{robot.name} walking", shlex.join(["surefoot", *sys.argv[1:]])
        written.attempt(page, lambda: write_report(page, title, (line, good), sections, command))
    for note in pictures.notes() + written.notes:
        console.print(note, soft_wrap=True, highlight=False)
    console.print(line, style="bold green" if good else "bold red", soft_wrap=True, highlight=False)
    where = page if page.exists() else folder
    console.print(f"report: {where}", soft_wrap=True, highlight=False)
    return summary
