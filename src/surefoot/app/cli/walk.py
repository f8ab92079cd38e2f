"""`surefoot walk`: a simulated robot walks, and every contact force is accounted for."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import typer

from surefoot.app.cli import live, options, physics
from surefoot.app.cli.console import plain_console, say
from surefoot.app.cli.output import new_run_folder
from surefoot.app.cli.policy import PolicyOptions
from surefoot.app.cli.resuming import resume_walk, state_keeper
from surefoot.app.cli.robots import load
from surefoot.app.cli.scenario_file import WALK_KEYS, ScenarioFile
from surefoot.app.cli.walk_options import Beliefs, WalkOptions, Wiring
from surefoot.base.errors import ProblemError, check_name
from surefoot.worlds.interface.world_names import packages_of

SHORTEST = 0.5
"""Length of a walk that says something [s]: about a cycle of a trot."""


def walk(context: typer.Context, *, asked: WalkOptions, learned: PolicyOptions) -> int:
    """Let a robot walk in simulation and account for every contact force.

    Exit code 0 if it walked to the end and no law or limit was broken, 1 if not, 2 for wrong input.
    """
    from surefoot.app.cli.simulated_run import SimulatedRun
    from surefoot.mechanics import file_actuators
    from surefoot.worlds.mujoco.substeps import substeps_of
    from surefoot.worlds.running.faults import Faults
    from surefoot.worlds.running.run_state import check_resumable
    from surefoot.worlds.running.walk_terrain import check_ground, start_pose

    console = plain_console(quiet=asked.as_json)
    before = resume_walk(context, asked)
    asked = replace(asked, robot=learned.robot(asked.robot)) if before is None else before.asked
    asked.check(SHORTEST, asked.planner)
    said = ScenarioFile.read(asked.scenario, WALK_KEYS) if before is None else before.said
    keep = state_keeper(asked, said, learned)
    belief, command, wired = asked.beliefs(said), asked.command(said), asked.wiring(said)
    settings, ground = physics.world_settings(asked, said), asked.read()
    of_file = asked.world_file is not None
    if asked.world in ("mujoco", "mujoco-exact") and not of_file:
        settings.setdefault("substeps", substeps_of(ground, asked.terrain_knowledge))
    # of the true state; sensors have their own
    level = said.noise or 0.0 if said.estimator == "truth" else 0.0
    faults = Faults(level, said.delay, said.weak_joint, said.torque_loss, dropouts=wired.dropouts)
    happens = asked.happening(said, faults=faults, **belief.senses(said))
    options.require(asked.robot, packages_of(asked.world), asked)
    model = load(asked.robot, asked.feet, feet_needed=True)
    motors = file_actuators(model) if of_file else asked.actuators
    task = _WalkTask(model, belief.ground(ground), asked.gait, said, command, belief, motors, wired)
    made = _controller if learned.policy is None else partial(_learned_policy, learned)
    controller = made(asked.planner, task)
    q = start_pose(model, ground, getattr(controller, "posture", None))
    check_ground(model, ground, q, asked.mu)
    world = physics.build_world(asked, model, ground, settings)
    say(console, *model.notes, *controller.facts.get("notes", ()))
    start = None if before is None else before.start(controller)
    check_resumable(world, controller, keep is not None or start is not None)
    run = SimulatedRun(model, ground, new_run_folder(asked.out, f"walk-{model.name}"), asked, console)
    watching = live.watching(model, ground, controller) if asked.view else []
    return run.carry_out(world, controller, replace(happens, start=q), _account(), watching, keep, start)


class _WalkTask(NamedTuple):
    """What a controller is made for; `gait` is a name, None where nothing is said."""

    robot: Any
    ground: Any
    gait: str | None
    said: ScenarioFile
    command: Any
    belief: Beliefs
    actuators: Any
    wired: Wiring


def _controller(planner: str, task: _WalkTask) -> Any:
    """Return the controller of a planner's name."""
    planners = {"convex": _convex, "contact-implicit": _contact_implicit}
    check_name("--planner", planner, planners)
    return planners[planner](task)


def _convex(task: _WalkTask) -> Any:
    """Return the controller that follows a gait."""
    from surefoot.mechanics import actuators_of
    from surefoot.motion.gaits.library import named_gait
    from surefoot.motion.walking.walkers import default_gait, walking_controller

    robot, belief, period = task.robot, task.belief, task.said.period
    name = task.gait or default_gait(robot)
    schedule = name if period is None else named_gait(name, len(robot.feet), period=period)
    if name == "stand" and task.command.values.any():  # it would pull a standing robot over
        raise ProblemError(f"gait {name!r} takes no steps: it goes with --velocity 0")
    controller = walking_controller(
        robot, task.command, schedule, task.ground, belief.mu, actuators_of(robot, task.actuators),
        task.wired.dt, watch_friction=belief.watch,
    )  # fmt: skip
    return task.wired.around(controller, robot)


def _contact_implicit(task: _WalkTask) -> Any:
    """Return the controller that takes no gait."""
    from surefoot.motion.planning.mpc.contact_implicit_controller import ContactImplicitMpc, MpcSettings
    from surefoot.worlds.interface.actuated import equipped

    if task.gait not in (None, "trot") or task.said.period is not None:
        raise ProblemError("--planner contact-implicit takes no --gait or period")
    if not task.wired.plain:
        raise ProblemError(
            "--planner contact-implicit takes no --commands, --dropout, control_rate or latency"
        )
    robot, settings = equipped(task.robot, task.actuators)[0], MpcSettings(mu=task.belief.mu)
    return ContactImplicitMpc(robot, task.command, task.ground, settings)


def _learned_policy(learned: PolicyOptions, planner: str, task: _WalkTask) -> Any:
    """Return a policy; it has a gait of its own."""
    from surefoot.worlds.interface.actuated import equipped

    if planner != "convex" or task.gait is not None or "period" in task.said.given:
        raise ProblemError("--policy takes no --planner, --gait or period: it has its own gait")
    robot = equipped(task.robot, task.actuators)[0]
    return learned.controller(robot, task.command, task.ground, task.wired)


def _account() -> Any:
    """Return how a walk is summed up."""
    from surefoot.app.cli.run_output import walk_headline, walk_lines, walk_tables
    from surefoot.app.cli.simulated_run import Account
    from surefoot.app.viz.walk_plots import draw_walk
    from surefoot.records import summarise_walk

    return Account("walking", summarise_walk, walk_headline, walk_tables, walk_lines, draw_walk)
