"""`surefoot walk`: a simulated robot walks, and every contact force is accounted for."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import typer

from surefoot.cli import command_options as wires
from surefoot.cli import knowledge, live, options, physics
from surefoot.cli.console import plain_console, say
from surefoot.cli.output import new_run_folder
from surefoot.cli.policy import Learned
from surefoot.cli.robots import load
from surefoot.cli.scenario_file import WALK_KEYS, ScenarioFile
from surefoot.errors import ProblemError, check_name
from surefoot.simulation.worlds import WORLDS

SHORTEST = 0.5
"""Length of a walk that says something [s]: about a cycle of a trot."""


def walk(
    *,
    robot: options.RobotName = None,
    feet: options.FootFrames = None,
    gait: Annotated[
        str | None,
        typer.Option(
            help="stand, trot, walk, pace, bound, flying_trot (on two feet stand, walk), auto (by speed), "
            "None for trot, on two feet walk."
        ),
    ] = None,
    planner: Annotated[
        str, typer.Option(help="convex, which follows the gait, or contact-implicit, which takes none.")
    ] = "convex",
    velocity: Annotated[
        str, typer.Option(help="VX,VY,WZ: forward, left [m/s], yaw rate [rad/s].")
    ] = "0.5,0,0",
    on: options.Ground,
    terrain_knowledge: knowledge.TerrainKnowledge = "exact",
    mu: options.Friction = 0.6,
    push: options.Pushes = None,
    payload: options.Payload = "0",
    dropout: Annotated[
        list[str] | None, typer.Option(help="T:DURATION without a fresh state [s]; repeatable.")
    ] = None,
    commands: Annotated[
        str, typer.Option(help="torques, or targets: joint angles, speeds, gains and torques for the drives.")
    ] = "torques",
    obeyed: options.Physics,
    learned: Learned,
    duration: options.Duration = 10.0,
    seed: options.Seed = None,
    scenario: options.ScenarioPath = None,
    view: options.View = False,
    leaving: options.Leaving,
) -> int:
    """Let a robot walk in simulation and account for every contact force.

    Exit code 0 if it walked to the end and no law or limit was broken, 1 if not, 2 for wrong input.
    """
    from surefoot.cli import parsing
    from surefoot.cli.simulated_run import SimulatedRun
    from surefoot.simulation.faults import Faults
    from surefoot.simulation.mujoco_substeps import substeps_of

    console = plain_console(quiet=leaving.as_json)
    robot = learned.robot(robot)
    if view:
        live.check(planner)
    options.check_numbers(mu, duration, SHORTEST, seed)
    carried, dropouts = parsing.payload(payload), [parsing.dropout(text) for text in dropout or ()]
    said = ScenarioFile.read(scenario, WALK_KEYS)
    belief = knowledge.Beliefs.read(said.believed_mu, mu, terrain_knowledge, planner)
    file = robot if physics.is_world(robot, obeyed.world) else None
    settings = physics.world_settings(obeyed, said, mu, file)
    ground = on.read()
    if obeyed.world == "mujoco" and file is None:
        settings.setdefault("substeps", substeps_of(ground, terrain_knowledge))
    command = _command(velocity, said)
    wired = wires.wiring(commands, dropouts, said)
    parsing.within_run("--dropout", dropout or (), (start for start, _ in dropouts), duration)
    level = (
        said.noise or 0.0 if said.estimator == "truth" else 0.0
    )  # of the true state; sensors have their own
    faults = Faults(level, said.delay, said.weak_joint, said.torque_loss, dropouts=wired.dropouts)
    happens = options.scenario_of(duration, mu, push, seed, said, faults=faults, **belief.senses(said))
    options.require(robot, WORLDS[obeyed.world][1], leaving)
    model = load(robot, feet, feet_needed=True)
    motors = obeyed.actuators if file is None else _file_motors(model)
    task = _WalkTask(model, belief.ground(ground), gait, said, command, belief, motors, wired)
    controller = _controller(planner, task) if learned.policy is None else _learned(planner, learned, task)
    q = _start(model, ground, mu, getattr(controller, "posture", None))
    world = physics.build_world(obeyed.world, model, file, ground, mu, carried, settings)
    say(console, *controller.facts.get("notes", ()))
    folder = new_run_folder(leaving.out, f"walk-{model.name}")
    run = SimulatedRun(model, ground, folder, leaving, console)
    watching = live.watching(model, ground, controller) if view else []
    return run.carry_out(world, controller, replace(happens, start=q), _account(), watching)


class _WalkTask(NamedTuple):
    """What a controller is made for; `gait` is a name, None where nothing is said."""

    robot: Any
    ground: Any
    gait: str | None
    said: ScenarioFile
    command: Any
    belief: knowledge.Beliefs
    actuators: Any
    wired: wires.Wiring


def _controller(planner: str, task: _WalkTask) -> Any:
    """Return the controller of a planner's name."""
    planners = {"convex": _convex, "contact-implicit": _contact_implicit}
    check_name("--planner", planner, planners)
    return planners[planner](task)


def _convex(task: _WalkTask) -> Any:
    """Return the controller that follows a gait."""
    from surefoot.control.walkers import default_gait, walking_controller
    from surefoot.robot.actuators import actuators_of

    robot, belief = task.robot, task.belief
    schedule = _schedule(robot, task.gait or default_gait(robot), task.said)
    _check_steps(robot, schedule, task.command)
    controller = walking_controller(
        robot, task.command, schedule, task.ground, belief.mu, actuators_of(robot, task.actuators),
        task.wired.dt, watch_friction=belief.watch,
    )  # fmt: skip
    return task.wired.around(controller, robot)


def _contact_implicit(task: _WalkTask) -> Any:
    """Return the controller that takes no gait."""
    from surefoot.planning.mpc.controller import ContactImplicitMpc, MpcSettings
    from surefoot.simulation.actuated import equipped

    if task.gait not in (None, "trot") or task.said.period is not None:
        raise ProblemError("--planner contact-implicit takes no --gait or period")
    if not task.wired.plain:
        raise ProblemError(
            "--planner contact-implicit takes no --commands, --dropout, control_rate or latency"
        )
    robot, settings = equipped(task.robot, task.actuators)[0], MpcSettings(mu=task.belief.mu)
    return ContactImplicitMpc(robot, task.command, task.ground, settings)


def _learned(planner: str, learned: Learned, task: _WalkTask) -> Any:
    """Return a policy; it has a gait of its own."""
    from surefoot.simulation.actuated import equipped

    if planner != "convex" or task.gait is not None or "period" in task.said.given:
        raise ProblemError("--policy takes no --planner, --gait or period: it has its own gait")
    robot = equipped(task.robot, task.actuators)[0]
    return learned.controller(robot, task.command, task.ground, task.wired)


def _file_motors(robot: Any) -> Any:
    """Return what an MJCF file says of its motors."""
    from surefoot.robot.actuators import told_actuators

    return told_actuators(robot)


def _schedule(robot: Any, gait: str, said: ScenarioFile) -> Any:
    """Return a gait's name, or the gait of that name with a period of its own."""
    from surefoot.stance.gait_library import named_gait

    return gait if said.period is None else named_gait(gait, len(robot.feet), period=said.period)


def _check_steps(robot: Any, schedule: Any, command: Any) -> None:
    """Refuse a velocity for a gait that takes no steps: it would pull a standing robot over."""
    everyone = (1 << len(robot.feet)) - 1
    still = schedule == "stand" if isinstance(schedule, str) else bool((schedule.modes == everyone).all())
    if still and command.values.any():
        name = schedule if isinstance(schedule, str) else getattr(schedule, "name", "of the file")
        raise ProblemError(f"gait {name!r} takes no steps: it goes with --velocity 0")


def _command(velocity: str, said: ScenarioFile) -> Any:
    """Return the commanded velocity over time."""
    from surefoot.cli import parsing
    from surefoot.control.walking_body import VelocityCommand

    if said.velocity_file is not None:
        return VelocityCommand.read(said.velocity_file)
    return VelocityCommand.constant(*parsing.velocity(velocity))


def _start(robot: Any, ground: Any, mu: float, posture: Any) -> Any:
    """Return the configuration to start from, in the nominal pose or a controller's own."""
    from surefoot.simulation.walk_terrain import check_ground, start_pose

    q = start_pose(robot, ground, posture)
    check_ground(robot, ground, q, mu)
    return q


def _account() -> Any:
    """Return how a walk is summed up."""
    from surefoot.audit import summarise_walk
    from surefoot.cli import walk_output
    from surefoot.cli.simulated_run import Account
    from surefoot.viz.walk_plots import draw_walk

    said = (walk_output.headline, walk_output.tables, walk_output.figure_lines)
    return Account("walking", summarise_walk, *said, draw_walk)
