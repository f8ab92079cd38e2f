"""An MJCF file as robot and world: what `--mjcf` says."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from surefoot.cli.robots import load
from surefoot.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.control.actuators import Actuators
    from surefoot.robot import Robot
    from surefoot.simulation.world import World
    from surefoot.terrain import Terrain

Mjcf: TypeAlias = Annotated[
    Path | None,
    typer.Option(help="An MJCF file as robot and world: its joints, actuators, shapes and contacts."),
]


def robot_and_motors(
    mjcf: Path | None, name: str | None, urdf: Path | None, feet: str | None, actuators: str
) -> tuple[Robot, str | Actuators]:
    """Return the robot, and what its controller knows of its motors.

    Raises
    ------
    ProblemError
        For a robot besides the file, or a file without feet.
    """
    if mjcf is None:
        return load(name, urdf, feet, feet_needed=True), actuators
    from surefoot.control.actuators import told_actuators

    if name is not None or urdf is not None:
        raise ProblemError(f"--mjcf is robot and world: it goes without {name or urdf}")
    if feet is None:
        raise ProblemError("--mjcf needs --feet, its spheres that touch the ground, e.g. --feet FL,FR,RL,RR")
    robot = load(str(mjcf.absolute()), None, feet)
    return robot, told_actuators(robot)


def check(mjcf: Path | None, world: str, told: dict[str, Any]) -> None:
    """Refuse options of other worlds beside a file; `told` is of `Physics.settings`."""
    others = sorted(set(told) - {"solref", "solimp", "substeps"})
    if mjcf is not None and (world != "mujoco" or others):
        option = f"--{others[0]}" if others else f"--world {world}"
        raise ProblemError(f"--mjcf is a world of its own: it goes without {option}")


def file_world(
    mjcf: Path,
    robot: Robot,
    terrain: Terrain,
    mu: float,
    payload: tuple[float, tuple[float, float, float]],
    told: dict[str, Any],
) -> World:
    """Return the world of a file, `payload` being mass and place."""
    from surefoot.simulation.mjcf_world import MjcfWorld

    parts = told.pop("substeps", 1)
    world = MjcfWorld(robot, mjcf, terrain, mu, payload=payload[0], payload_position=payload[1], **told)
    world.divide(parts)
    return world
