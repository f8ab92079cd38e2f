"""`surefoot robot`: a robot on the wire, with MuJoCo behind it."""

from __future__ import annotations

import gc
from typing import Annotated

import typer

from surefoot.app.cli import extras, options, parsing
from surefoot.app.cli.console import plain_console, say, show
from surefoot.app.cli.drive import LOOPBACK, DdsConfig, DomainId, Interface, SlowMotion, own_config, wire_end
from surefoot.app.cli.robots import load
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError


def robot(
    *,
    robot: options.RobotName = None,
    interface: Interface = LOOPBACK,
    domain: DomainId = 1,
    seconds: Annotated[float | None, typer.Option(help="Run so long [s]; None for until Ctrl-C.")] = None,
    terrain: Annotated[str, typer.Option(help="flat or slope:DEG.")] = "flat",
    mu: options.Friction = 0.6,
    seed: options.Seed = None,
    slow_motion: SlowMotion = False,
    dds_config: DdsConfig = None,
    as_json: options.AsJson = False,
) -> int:
    """Be a robot on the wire: MuJoCo behind Unitree's topics, with noisy sensors, motors' limits, a delay.

    It lies on its belly, and damps its joints while no command comes. Exit code 0 unless the input is wrong.
    """
    from surefoot.app.cli.signals import ends_softly
    from surefoot.mechanics import read_terrain
    from surefoot.worlds.mujoco.engine_warnings import engine_warnings
    from surefoot.worlds.running.motor_robot import MotorRobot, WiredRobot

    extras.require(["mujoco", "cyclonedds"])
    from surefoot.motion.drive.wire.dialect import dialect_of

    model = load(robot, None, feet_needed=True)
    parsing.seed(seed)
    parsing.friction("--mu", mu)
    ground = read_terrain(terrain, "--terrain")
    if not ground.planar:
        raise ProblemError(f"--terrain must be flat or slope:DEG, got {terrain!r}")
    if seconds is not None:
        real_number("--seconds", seconds, low=0.0, high=parsing.FOREVER)
    dialect_of(model)  # a robot that does not speak is refused before it is built
    body = MotorRobot(model, terrain=ground, mu=mu, seed=seed or 0)
    body.lie_down()
    highest = largest = 0.0
    with (
        wire_end(model, True, interface, domain, own_config(dds_config)) as (wire, dialect),
        ends_softly(),
        engine_warnings(),
    ):
        wired = WiredRobot(body, wire, dialect, slow_motion)
        say(
            plain_console(quiet=as_json), f"{model.name} lies on {interface}, domain {domain}   (Ctrl-C ends)"
        )
        gc.freeze()
        try:
            while seconds is None or body.time < seconds:
                wired.step()
                highest = max(highest, float(body.world.q_v()[0][2]))
                largest = max(largest, float((abs(body.torques) / model.effort_limits).max()))
        except KeyboardInterrupt:
            pass
    said = {
        "time": body.time, "place": body.world.q_v()[0][:3].tolist(), "highest": highest,
        "torque_use": largest, "damped_steps": wired.damped,
    }  # fmt: skip
    show(said, as_json, lambda console, facts: say(console, *(f"{k}: {v}" for k, v in facts.items())))
    return 0
