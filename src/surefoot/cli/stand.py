"""`surefoot stand`: a simulated robot stands on its contact forces."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from surefoot.arrays import real_number
from surefoot.cli.console import plain_console
from surefoot.cli.output import new_run_folder, to_json
from surefoot.cli.robots import load
from surefoot.errors import ProblemError, unknown_name
from surefoot.simulation.worlds import WORLDS

SHORTEST = 0.1
"""Length of a stand that says something [s]: a limp robot has dropped five centimetres by then."""


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
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw plots and a report.")] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print summary.json and nothing else.")] = False,
) -> int:
    """Let a robot stand in simulation and account for every contact force.

    Exit code 0 if it stood and no law was broken, 1 if not, 2 for wrong input.
    """
    from surefoot.cli import parsing
    from surefoot.cli.simulated_run import SimulatedRun
    from surefoot.simulation.standing import run_standing

    console = plain_console(quiet=as_json)
    _check(mu, world, duration, payload, seed)
    scenario, lifts = _scenario(duration, mu, push, ice, lift, seed)
    sides = parsing.facets(facets)
    _require(robot if urdf is None else str(urdf.absolute()), world, video, report)
    setup = _set_up(robot, urdf, feet, slope, lifts)
    allocation = _allocation(setup, mu, sides, fit, solver)
    with plain_console(stderr=True, quiet=as_json).status(
        "asking whether it can stand (a first run compiles)"
    ):
        statics = _statics(setup, mu, payload)
    for phase in statics:
        console.print(phase["text"], soft_wrap=True, highlight=False)
    if not all(phase["possible"] for phase in statics) and not anyway:
        if as_json:
            print(to_json(_impossible(setup, statics)))
        return 1
    controller = setup.controller(mu, allocation)
    physics = setup.world(world, mu, payload)
    folder = new_run_folder(out, f"stand-{setup.robot.name}")
    run = SimulatedRun(setup.robot, setup.terrain, duration, folder, video, report, as_json, console)
    return run.carry_out(
        lambda tell, parts: run_standing(physics, controller, setup.q, scenario, tell, parts),
        _account(statics),
    )


def _check(mu: float, world: str, duration: float, payload: float, seed: int | None) -> None:
    from surefoot.cli import parsing

    parsing.friction("--mu", mu)
    if world not in WORLDS:
        raise ProblemError(unknown_name("world", world, tuple(WORLDS)))
    parsing.duration(duration, SHORTEST)
    real_number("--payload", payload, low=0.0, high=1e4)
    parsing.seed(seed)


def _scenario(
    duration: float,
    mu: float,
    push: list[str] | None,
    ice: list[str] | None,
    lift: list[str] | None,
    seed: int | None,
) -> tuple[Any, list[Any]]:
    """Return what happens to the robot, and the feet that it lifts, or raise for what lies past the end."""
    from surefoot.cli import parsing
    from surefoot.simulation.run import Scenario

    scenario = Scenario(duration, mu, parsing.each(parsing.push, push), parsing.each(parsing.ice, ice), seed)
    lifts = parsing.each(parsing.lift, lift)
    for option, texts, events in (
        ("--push", push, scenario.pushes), ("--ice", ice, scenario.ice), ("--lift", lift, lifts),
    ):  # fmt: skip
        parsing.within_run(option, texts, [event.start for event in events], duration)
    return scenario, lifts


def _require(robot: str | None, world: str, video: bool, report: bool) -> None:
    """Raise for all optional packages at once if one that a stand cannot do without is missing."""
    from surefoot.cli import extras

    needed = (*extras.robot_packages(robot), *WORLDS[world][1])
    extras.require(needed, (*(extras.FILM if video else ()), *(["matplotlib"] if report else [])))


class _Setup:
    """A robot on its terrain with a plan."""

    def __init__(self, robot: Any, terrain: Any, q: Any, plan: Any) -> None:
        self.robot, self.terrain, self.q, self.plan = robot, terrain, q, plan

    def controller(self, mu: float, allocation: Any) -> Any:
        from surefoot.control.standing import StandingController

        return StandingController(self.robot, self.plan, self.terrain, self.q, mu, allocation=allocation)

    def world(self, name: str, mu: float, payload: float) -> Any:
        from surefoot.simulation.worlds import make_world

        return make_world(name, self.robot, self.terrain, mu, payload=payload)


def _set_up(name: str | None, urdf: Path | None, feet: str | None, slope: float, lifts: list[Any]) -> _Setup:
    """Return the robot in its stance, or raise for what cannot be."""
    from surefoot.control.standing_plan import StandingPlan
    from surefoot.robot import place
    from surefoot.terrain import FlatTerrain, SlopeTerrain

    robot = load(name, urdf, feet, feet_needed=True)
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


def _impossible(setup: _Setup, statics: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the summary of a stand that statics rules out."""
    return {
        "robot": setup.robot.name,
        "mass": setup.robot.mass,
        "stood": False,
        "outcome": "impossible",
        "statics": statics,
    }


def _account(statics: list[dict[str, Any]]) -> Any:
    """Return how a stand is summed up."""
    from surefoot.cli import stand_output
    from surefoot.cli.simulated_run import Account
    from surefoot.simulation.summary import summarise

    said = [phase["text"] for phase in statics]
    return Account(
        "standing",
        "stood",
        lambda log: {**summarise(log), "statics": statics},
        stand_output.print_summary,
        stand_output.headline,
        lambda summary: stand_output.report_sections(summary, said),
    )
