"""Walks that tests of the worlds share."""

from __future__ import annotations

from typing import Any

from surefoot.app.cli.walk_options import Wiring
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.robot.actuators import real_actuators
from surefoot.mechanics.terrain import FlatTerrain, Terrain
from surefoot.motion.control.controller import Controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.records.audit import WalkSummary, summarise_walk
from surefoot.records.log import Log
from surefoot.worlds.interface.world_names import make_world
from surefoot.worlds.running.run import Scenario, run
from surefoot.worlds.running.walk_terrain import start_pose

GO2 = load_robot("go2")
REAL = real_actuators(GO2)
WHOLE = {"actuators": "real", "collision": "full"}
"""What a world is given for motors with limits and all links."""


def walk(
    velocity: float | tuple[float, float, float] = 0.5,
    duration: float = 3.0,
    robot: str = "go2",
    gait: str = "trot",
    *,
    terrain: Terrain | None = None,
    world: dict[str, Any] | None = None,
    settings: WalkSettings | None = None,
    wired: Wiring | None = None,
    mu: float = 0.6,
    **events: Any,
) -> tuple[Log, WalkSummary]:
    """Return log and summary; world has a name (or "mujoco") and options, events are of the scenario."""
    model, ground = GO2 if robot == "go2" else load_robot(robot), terrain or FlatTerrain()
    command = VelocityCommand.constant(*(velocity if isinstance(velocity, tuple) else (velocity, 0.0, 0.0)))
    dt, settings = 1e-3 if wired is None else wired.dt, settings or WalkSettings(mu=mu)
    walker: Controller = WalkingController(model, command, gait, ground, settings, dt)
    if wired is not None:
        walker = wired.around(walker, model)
    options = {"name": "mujoco", "robot": model, "terrain": ground, "mu": mu} | (world or {})
    scenario = Scenario(duration, mu, start=start_pose(model, ground), **({"seed": 0} | events))
    log = run(make_world(**options), walker, scenario)
    return log, summarise_walk(log)
