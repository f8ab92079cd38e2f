"""`surefoot stand`: a simulated robot stands on its contact forces."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli.output import new_run_folder, to_json
from surefoot.cli.progress import progress_bar
from surefoot.cli.signals import ends_softly
from surefoot.errors import ProblemError, unknown_name

WORLDS = ("mujoco", "rigid")


def stand(
    robot: Annotated[
        str | None, typer.Argument(help="A known robot (default go2); see --urdf for others.")
    ] = None,
    urdf: Annotated[Path | None, typer.Option(help="A URDF file instead of a known robot.")] = None,
    feet: Annotated[str | None, typer.Option(help="Foot frames, comma-separated.")] = None,
    mu: Annotated[float, typer.Option(help="Friction of the ground.")] = 0.6,
    slope: Annotated[float, typer.Option(help="Slope that rises along +x [deg].")] = 0.0,
    facets: Annotated[str, typer.Option(help="Sides of friction pyramids, or 'exact'.")] = "exact",
    fit: Annotated[str, typer.Option(help="Pyramids inside or around the cones: inner or outer.")] = "inner",
    solver: Annotated[str, typer.Option(help="Solver that shares the wrench among the feet.")] = "auto",
    duration: Annotated[float, typer.Option(help="Simulated time [s].")] = 5.0,
    payload: Annotated[
        float, typer.Option(help="Mass on the base that the controller does not know [kg].")
    ] = 0.0,
    push: Annotated[list[str] | None, typer.Option(help="T:FX,FY,FZ:DURATION [s, N, s]; repeatable.")] = None,
    ice: Annotated[list[str] | None, typer.Option(help="T:MU, friction from time T on; repeatable.")] = None,
    lift: Annotated[list[str] | None, typer.Option(help="FOOT:T0:T1, foot in the air; repeatable.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed of a small random velocity at the start.")] = None,
    world: Annotated[str, typer.Option(help=f"Physics: {' or '.join(WORLDS)}.")] = "mujoco",
    anyway: Annotated[bool, typer.Option("--anyway", help="Run even if the stance is impossible.")] = False,
    out: Annotated[Path, typer.Option(help="Parent of the run's new folder.")] = Path("runs"),
    video: Annotated[bool, typer.Option("--video/--no-video", help="Film the run.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False,
) -> int:
    """Let a robot stand in simulation and account for every contact force.

    Exit code 0 if it stood and no law was broken, 1 if not, 2 for wrong input.
    """
    from rich.console import Console

    from surefoot.cli import parsing
    from surefoot.cli.run_files import PARTS
    from surefoot.simulation.run import Scenario
    from surefoot.simulation.standing import run_standing

    console = Console(quiet=as_json)
    real_number("--mu", mu, low=0.0, high=1e3)
    if world not in WORLDS:
        raise ProblemError(unknown_name("world", world, WORLDS))
    if not 0.0 < duration <= 3600.0:
        raise ProblemError(f"--duration must be between 0 and 3600 s, got {duration:g}")
    real_number("--payload", payload, low=0.0, high=1e4)
    if seed is not None:
        real_number("--seed", seed, low=0)
    scenario = Scenario(duration, mu, parsing.each(parsing.push, push), parsing.each(parsing.ice, ice), seed)
    setup = _set_up(robot, urdf, parsing.names(feet), slope, parsing.each(parsing.lift, lift))
    allocation = _allocation(setup, mu, parsing.facets(facets), fit, solver)
    with Console(stderr=True, quiet=as_json).status("asking whether it can stand (a first run compiles)"):
        statics = _statics(setup, mu, payload)
    for phase in statics:
        console.print(phase["text"], soft_wrap=True, highlight=False)
    if not all(phase["possible"] for phase in statics) and not anyway:
        if as_json:
            facts = {
                "robot": setup.robot.name,
                "mass": setup.robot.mass,
                "stood": False,
                "outcome": "impossible",
            }
            print(to_json({**facts, "statics": statics}))
        return 1
    controller = setup.controller(mu, allocation)
    physics = setup.world(world, mu, payload)
    folder = new_run_folder(out, f"stand-{setup.robot.name}")
    with ends_softly() as stop:
        with progress_bar(console.is_terminal and not as_json, "standing", duration) as tell:
            log = run_standing(physics, controller, setup.q, scenario, tell, folder / PARTS)
        summary = _write(setup, log, statics, folder, video, console)
        if as_json:
            print(to_json(summary))
    if summary["outcome"] == "interrupted":
        return stop.code
    return 0 if summary["stood"] and not summary["laws_broken"] and not summary["unwritten"] else 1


class _Setup:
    """A robot on its terrain with a plan."""

    def __init__(self, robot: Any, terrain: Any, q: Any, plan: Any) -> None:
        self.robot, self.terrain, self.q, self.plan = robot, terrain, q, plan

    def controller(self, mu: float, allocation: Any) -> Any:
        from surefoot.control.standing import StandingController

        return StandingController(self.robot, self.plan, self.terrain, self.q, mu, allocation=allocation)

    def world(self, name: str, mu: float, payload: float) -> Any:
        if name == "rigid":
            from surefoot.simulation.rigid import RigidWorld

            return RigidWorld(self.robot, self.terrain, mu, payload=payload)
        from surefoot.simulation.mujoco import MujocoWorld

        return MujocoWorld(self.robot, self.terrain, mu, payload=payload)


def _set_up(
    name: str | None, urdf: Path | None, feet: list[str] | None, slope: float, lifts: list[Any]
) -> _Setup:
    """Return the robot in its stance, or raise for what cannot be."""
    from surefoot.control.standing_plan import StandingPlan
    from surefoot.robot import load_robot, place
    from surefoot.stance import FlatTerrain, SlopeTerrain

    if urdf is not None and name is not None:
        raise ProblemError(f"give either a robot or --urdf, got both {name!r} and {urdf}")
    if urdf is not None and not feet:
        raise ProblemError("--urdf needs --feet, the frames that touch the ground, e.g. --feet FL,FR,RL,RR")
    robot = load_robot(Path(urdf).absolute() if urdf is not None else name or "go2", feet)
    if robot.feet and sum(len(foot.centres) for foot in robot.feet) < 3:
        count = len(robot.feet)
        raise ProblemError(f"{robot.name} cannot stand still: {count} point feet span no area to stand on")
    real_number("--slope", slope, low=-80.0, high=80.0)
    terrain = SlopeTerrain(slope) if slope else FlatTerrain()
    q = place(robot, terrain)
    return _Setup(robot, terrain, q, StandingPlan(robot, terrain, q, lifts))


def _allocation(setup: _Setup, mu: float, facets: int | None, fit: str, solver: str) -> Any:
    """Return how forces are shared; None for the default, exact cones."""
    if fit not in ("inner", "outer"):
        raise ProblemError(unknown_name("fit", fit, ["inner", "outer"]))
    if facets is None and solver in ("auto", "distribution"):
        return None
    import numpy as np

    from surefoot.control.allocation import SolverAllocation
    from surefoot.control.standing import FORCE_WEIGHT, wrench_weights

    points = sum(len(foot.centres) for foot in setup.robot.feet)
    weights = wrench_weights(setup.robot, setup.q)
    return SolverAllocation(np.full(points, mu), weights, FORCE_WEIGHT, solver, facets, fit)  # type: ignore[arg-type]


def _statics(setup: _Setup, mu: float, payload: float) -> list[dict[str, Any]]:
    """Ask whether the stance is statically possible, on all feet and during every lift."""
    from surefoot.cli.stand_output import statics_line
    from surefoot.equilibrium import can_stand, friction_needed

    robot, plan = setup.robot, setup.plan
    stance = robot.stance(setup.q, mu=mu, terrain=setup.terrain)
    cases = [("stance", stance, robot.com(setup.q))]
    for k, lift in enumerate(plan.lifts):
        name = robot.foot(lift.foot).name
        cases.append((f"with {name} lifted", stance.without(name), plan.com(k)))
    out = []
    for phase, contacts, com in cases:
        verdict = can_stand(contacts, com, robot.mass + payload)
        needed = friction_needed(contacts, com, robot.mass + payload)
        text = statics_line(phase, verdict.feasible, verdict.margin, needed, mu)
        out.append(
            {
                "phase": phase,
                "possible": bool(verdict.feasible),
                "margin": float(verdict.margin),
                "friction_needed": needed,
                "text": text,
            }
        )
    return out


def _write(
    setup: _Setup, log: Any, statics: list[dict[str, Any]], folder: Path, video: bool, console: Any
) -> dict[str, Any]:
    """Write everything that the run leaves, print the table, and return the summary."""
    from surefoot.cli import run_files, stand_output
    from surefoot.simulation.summary import summarise
    from surefoot.viz.report import write_report

    written, report = run_files.Written(), folder / "report.html"
    written.attempt(folder / "log.npz", lambda: log.save(folder / "log.npz"))
    summary = summarise(log)
    summary["statics"], summary["unwritten"] = statics, written.notes
    written.attempt(folder / "summary.json", lambda: run_files.write_summary(summary, folder))
    plots, note = run_files.write_plots(log, folder)
    film = None
    if video and summary["outcome"] != "interrupted":
        with progress_bar(console.is_terminal and not console.quiet, "filming", 1.0) as tell:
            film, film_note = run_files.write_film(log, setup.robot, setup.terrain, folder, tell)
        note = "; ".join(text for text in (note, film_note) if text)
    stand_output.print_summary(console, summary)
    headline = stand_output.headline(summary)
    good = summary["stood"] and not summary["laws_broken"]
    sections = stand_output.report_sections(summary, [phase["text"] for phase in statics])
    title, command = f"{setup.robot.name} standing", shlex.join(["surefoot", *sys.argv[1:]])
    sections += run_files.picture_sections(plots, film)
    written.attempt(report, lambda: write_report(report, title, (headline, good), sections, command))
    for text in filter(None, [note, *written.notes]):
        console.print(text, soft_wrap=True, highlight=False)
    console.print(headline, style="bold green" if good else "bold red", soft_wrap=True, highlight=False)
    console.print(f"report: {report if report.exists() else folder}", soft_wrap=True, highlight=False)
    return summary
