"""`surefoot walk`: a simulated robot walks, and every contact force is accounted for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from surefoot.arrays import real_number
from surefoot.cli import command_options as wires
from surefoot.cli import estimators, knowledge, live
from surefoot.cli import mjcf_options as files
from surefoot.cli import run_options as options
from surefoot.cli import shared_options as shared
from surefoot.cli import world_options as worlds
from surefoot.cli.console import plain_console, say
from surefoot.cli.output import new_run_folder
from surefoot.errors import ProblemError, unknown_name
from surefoot.simulation.worlds import WORLDS

SHORTEST = 0.5
"""Length of a walk that says something [s]: about a cycle of a trot."""


def walk(
    *,
    robot: shared.RobotName = None,
    urdf: shared.Urdf = None,
    mjcf: files.Mjcf = None,
    feet: shared.FootFrames = None,
    gait: Annotated[
        str | None,
        typer.Option(
            help="stand, trot, walk, pace, bound, flying_trot (on two feet stand, walk), auto (by speed), "
            "or one in --gait-file; None for trot, on two feet walk."
        ),
    ] = None,
    gait_file: Annotated[Path | None, typer.Option(help="Gaits in OCS2's format.")] = None,
    period: Annotated[float | None, typer.Option(help="Length of a cycle of the gait [s].")] = None,
    planner: Annotated[
        str, typer.Option(help="convex, which follows the gait, or contact-implicit, which takes none.")
    ] = "convex",
    velocity: Annotated[
        str, typer.Option(help="VX,VY,WZ: forward, left [m/s], yaw rate [rad/s].")
    ] = "0.5,0,0",
    velocity_file: Annotated[
        Path | None, typer.Option(help="Lines of 'time vx vy yaw_rate' instead of --velocity.")
    ] = None,
    terrain: Annotated[
        str,
        typer.Option(
            help="flat, slope:DEG, stairs:HEIGHT,DEPTH, rough:SEED,HEIGHT or pit:START,LENGTH,DEPTH [m]."
        ),
    ] = "flat",
    mu: options.Friction = 0.6,
    believed_mu: knowledge.BelievedMu = None,
    terrain_knowledge: knowledge.TerrainKnowledge = "exact",
    push: options.Pushes = None,
    ice: options.IcePatches = None,
    payload: options.Payload = "0",
    estimator: estimators.EstimatorName = "inekf",
    noise: estimators.Noise = None,
    delay: Annotated[float, typer.Option(help="Delay of the commands [s].")] = 0.0,
    latency: wires.Latency = "auto",
    commands: wires.Commands = "torques",
    control_rate: wires.ControlRate = 1000.0,
    dropout: wires.Dropouts = None,
    duration: options.Duration = 10.0,
    seed: options.Seed = None,
    physics: worlds.Physics,
    substeps: worlds.Substeps = None,
    view: live.View = False,
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
    if view:
        live.check(planner)
    options.check_numbers(mu, duration, SHORTEST, seed)
    carried = parsing.payload(payload)
    belief = knowledge.Beliefs.read(believed_mu, mu, terrain_knowledge, planner)
    sensors, level = estimators.sensors_of(estimator, noise)
    real_number("--delay", delay, low=0.0, high=1.0)
    told = physics.settings(mu, substeps)
    files.check(mjcf, physics.world, told)
    ground = parsing.terrain(terrain)
    if physics.world == "mujoco" and mjcf is None:
        told.setdefault("substeps", substeps_of(ground, terrain_knowledge))
    command = _command(velocity, velocity_file)
    wired = wires.wiring(commands, control_rate, latency, dropout)
    parsing.within_run("--dropout", dropout, [start for start, _ in wired.dropouts], duration)
    faults = Faults(noise=level, delay=delay, dropouts=wired.dropouts)
    scenario = options.scenario_of(duration, mu, push, ice, seed, faults=faults, **belief.senses(sensors))
    options.require(robot, urdf, WORLDS[physics.world][1], leaving)
    model, motors = files.robot_and_motors(mjcf, robot, urdf, feet, physics.actuators)
    given = gait, gait_file, period
    asked = _Asked(model, belief.ground(ground), given, command, belief, motors, wired)
    controller = _planner(planner)(asked)
    q = _start(model, ground, mu)
    world = (
        worlds.build_world(physics.world, model, ground, mu, carried, told, console)
        if mjcf is None
        else files.file_world(mjcf, model, ground, mu, carried, told)
    )
    say(console, *controller.facts.get("notes", ()))
    folder = new_run_folder(leaving.out, f"walk-{model.name}")
    run = SimulatedRun(model, ground, folder, leaving, console)
    watching = live.watching(model, ground, controller) if view else []
    return run.carry_out(world, controller, replace(scenario, start=q), _account(), watching)


def _planner(name: str) -> Callable[[_Asked], Any]:
    """Return who makes the controller of a planner's name."""
    planners = {"convex": _convex, "contact-implicit": _contact_implicit}
    if name not in planners:
        raise ProblemError(unknown_name("--planner", name, planners))
    return planners[name]


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


class _Asked(NamedTuple):
    """What a controller is made for; `gait` is a name, a file and a period, None where nothing is said."""

    robot: Any
    ground: Any
    gait: tuple[str | None, Path | None, float | None]
    command: Any
    belief: knowledge.Beliefs
    actuators: Any
    wired: wires.Wiring


def _convex(asked: _Asked) -> Any:
    """Return the controller that follows a gait."""
    from surefoot.control.actuators import actuators_of
    from surefoot.control.walkers import default_gait, walking_controller

    robot, belief, (name, file, period) = asked.robot, asked.belief, asked.gait
    schedule = _schedule(robot, default_gait(robot) if name is None else name, file, period)
    _check_steps(robot, schedule, asked.command)
    controller = walking_controller(
        robot, asked.command, schedule, asked.ground, belief.mu, actuators_of(robot, asked.actuators),
        asked.wired.dt, watch_friction=belief.watch,
    )  # fmt: skip
    return asked.wired.around(controller, robot)


def _contact_implicit(asked: _Asked) -> Any:
    """Return the controller that takes no gait."""
    from surefoot.planning.mpc.controller import ContactImplicitMpc, MpcSettings
    from surefoot.simulation.actuated import equipped

    if asked.gait not in ((None, None, None), ("trot", None, None)):
        raise ProblemError("--planner contact-implicit takes no --gait, --gait-file or --period")
    if not asked.wired.plain:
        told = "--commands, --control-rate, --latency or --dropout"
        raise ProblemError(f"--planner contact-implicit takes no {told}")
    robot, settings = equipped(asked.robot, asked.actuators)[0], MpcSettings(mu=asked.belief.mu)
    return ContactImplicitMpc(robot, asked.command, asked.ground, settings)


def _start(robot: Any, ground: Any, mu: float) -> Any:
    """Return the configuration to start from."""
    from surefoot.simulation.walk_terrain import check_ground, start_pose

    q = start_pose(robot, ground)
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
