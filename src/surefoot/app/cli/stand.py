"""`surefoot stand`: a simulated robot stands on its contact forces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import typer

from surefoot.app.cli import live, options, parsing, physics
from surefoot.app.cli.console import plain_console, say
from surefoot.app.cli.output import new_run_folder, to_json
from surefoot.app.cli.robots import load
from surefoot.app.cli.scenario_file import FAULTS, STAND_KEYS, ScenarioFile
from surefoot.base.errors import ProblemError
from surefoot.worlds.interface.world_names import packages_of

SHORTEST = 0.1
"""Length of a stand that says something [s]: a limp robot has dropped five centimetres by then."""
SHOWN_PUSH = (0.8, 0.2, 0.3, 0.1)
"""Push to the left of a stand of which nothing is asked: start, duration [s], shares of m g on 4 feet, 2."""
SHOWN_LIFT = (2.2, 4.0)
"""One of four feet is in the air from and until [s]."""
SHOWN_LEAST = (5.0, 0.5)
"""Duration [s] and friction that both take."""


@dataclass(frozen=True, kw_only=True)
class StandOptions(options.RunOptions):
    """What a stand is asked for."""

    lift: Annotated[list[str] | None, typer.Option(help="FOOT:T0:T1, foot in the air; repeatable.")] = None
    duration: options.Duration = 5.0
    anyway: Annotated[bool, typer.Option("--anyway", help="Run even if the stance is impossible.")] = False

    @property
    def shown(self) -> bool:
        """Whether nothing is asked, and there is room to show something."""
        said = (self.push, self.lift, self.scenario, self.payload_mass[0])
        least = self.duration >= SHOWN_LEAST[0] and self.mu >= SHOWN_LEAST[1]
        return self.is_default and said == (None, None, None, 0.0) and least


def stand(*, asked: StandOptions) -> int:
    """Let a robot stand in simulation and account for every contact force.

    Exit code 0 if it stood and no law or limit was broken, 1 if not, 2 for wrong input.
    """
    from surefoot.app.cli.simulated_run import SimulatedRun
    from surefoot.motion.standing.standing_controller import StandingController
    from surefoot.worlds.running.faults import Faults
    from surefoot.worlds.running.scenario import STANDING_FALL, START_DEPTH

    console = plain_console(quiet=asked.as_json)
    asked.check(SHORTEST)
    said = ScenarioFile.read(asked.scenario, STAND_KEYS)
    settings = physics.world_settings(asked, said)
    faults = Faults(0.0, said.delay, said.weak_joint, said.torque_loss) if FAULTS & {*said.given} else None
    happens = asked.happening(said, depth=START_DEPTH, fall=STANDING_FALL, faults=faults)
    lifts = [parsing.lift(text) for text in asked.lift or ()]
    parsing.within_run("--lift", asked.lift or (), (one.start for one in lifts), asked.duration)
    options.require(asked.robot, packages_of(asked.world), asked)
    plan, q = _set_up(asked, lifts)
    shows: Sequence[str] = ()
    with plain_console(stderr=True, quiet=asked.as_json).status(
        "asking whether it can stand (a first run compiles)"
    ):
        if asked.shown:
            plan, happens, shows = _with_events(plan, q, happens)
        statics = _statics(plan, q, asked.mu, *asked.payload_mass)
    model, terrain = plan.robot, plan.terrain
    say(console, *model.notes, *shows, *(phase["text"] for phase in statics))
    if not all(phase["possible"] for phase in statics) and not asked.anyway:
        if asked.as_json:
            named = {"robot": model.name, "mass": model.mass}
            print(to_json({**named, "stood": False, "outcome": "impossible", "statics": statics}))
        return 1
    controller = StandingController(model, plan, terrain, q, asked.mu)
    world = physics.build_world(asked, model, terrain, settings)
    run = SimulatedRun(model, terrain, new_run_folder(asked.out, f"stand-{model.name}"), asked, console)
    watching = live.watching(model, terrain) if asked.view else []
    return run.carry_out(world, controller, replace(happens, start=q), _account(statics), watching)


def _set_up(asked: StandOptions, lifts: list[Any]) -> tuple[Any, Any]:
    """Return the plan of a robot on its terrain, and its stance; or raise for what cannot be."""
    from surefoot.mechanics import place
    from surefoot.motion.standing.standing_plan import StandingPlan
    from surefoot.motion.walking.walkable import check_upright

    terrain = asked.read()
    robot = load(asked.robot, asked.feet, feet_needed=True)
    if robot.feet and sum(len(foot.centres) for foot in robot.feet) < 3:
        count = len(robot.feet)
        raise ProblemError(f"{robot.name} cannot stand still: {count} point feet span no area to stand on")
    check_upright(robot)
    q = place(robot, terrain)
    return StandingPlan(robot, terrain, q, lifts), q


def _with_events(plan: Any, q: Any, happens: Any) -> tuple[Any, Any, list[str]]:
    """Return what a stand shows of which nothing is asked, also in words: a push, and a foot lifted."""
    from surefoot.base.spatial import GRAVITY
    from surefoot.motion.standing.standing_plan import Lift, StandingPlan
    from surefoot.worlds.running.scenario import Push

    robot = plan.robot
    start, seconds, *shares = SHOWN_PUSH
    many = len(robot.feet) > 3
    force = float(round(shares[0 if many else 1] * robot.mass * GRAVITY))
    text = f"a push of {force:g} N to the left at {start:g} s"
    if many:
        lift = Lift(robot.feet[0].name, *SHOWN_LIFT)
        lifted = StandingPlan(robot, plan.terrain, q, [lift])
        if all(phase["possible"] for phase in _statics(lifted, q, happens.mu, 0.0, (0.0, 0.0, 0.0))):
            plan = lifted
            text += f", {lift.foot} in the air from {lift.start:g} to {lift.end:g} s"
    text += " (--push, --lift, --payload, --terrain or --scenario say what happens instead)"
    return plan, replace(happens, pushes=[Push(start, (0.0, force, 0.0), seconds)]), [text]


def _statics(plan: Any, q: Any, mu: float, payload: float, place: Sequence[float]) -> list[dict[str, Any]]:
    """Ask whether the stance is statically possible with a payload [kg] at (3,) base axes [m].

    On all feet and during every lift, in which the body leans as it would without the payload.
    """
    from surefoot.app.cli.run_output import statics_line
    from surefoot.base.spatial import rotation_from_quaternion
    from surefoot.mechanics import can_stand, friction_needed

    robot = plan.robot
    stance = robot.stance(q, mu=mu, terrain=plan.terrain)
    cases = [("stance", stance, robot.com(q))]
    for k, lift in enumerate(plan.lifts):
        name = robot.foot(lift.foot).name
        cases.append((f"with {name} lifted", stance.without(name), plan.com(k)))
    total, begin = robot.mass + payload, robot.com(q)
    load = q[:3] + rotation_from_quaternion(q[3:7]) @ np.array(place)
    out = []
    for phase, contacts, own in cases:
        com = (robot.mass * own + payload * (load + own - begin)) / total
        verdict = can_stand(contacts, com, total)
        needed = friction_needed(contacts, com, total)
        said = {"phase": phase, "possible": verdict.feasible, "margin": float(verdict.margin)}
        text = statics_line(phase, verdict.feasible, verdict.margin, needed, mu)
        out.append({**said, "friction_needed": needed, "text": text})
    return out


def _account(statics: list[dict[str, Any]]) -> Any:
    """Return how a stand is summed up."""
    from surefoot.app.cli.run_output import stand_headline, stand_lines, stand_tables
    from surefoot.app.cli.simulated_run import Account
    from surefoot.app.viz.plots import draw_run
    from surefoot.app.viz.report import paragraph
    from surefoot.records.audit import summarise_stand

    said = "".join(paragraph(phase["text"]) for phase in statics)
    return Account(
        "standing", summarise_stand, stand_headline, stand_tables, stand_lines,
        draw_run, [("Is the stance possible?", said)], {"statics": statics},
    )  # fmt: skip
