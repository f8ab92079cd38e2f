"""Worlds by name, one line each: what `--world` chooses from."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from surefoot.base.lazy_table import LazyTable

if TYPE_CHECKING:  # the command line reads the names without loading a robot
    from surefoot.mechanics import Robot, Terrain
    from surefoot.worlds.interface.world import World

WORLDS: LazyTable[Callable[..., World]] = LazyTable(
    "world",
    {
        "mujoco": "surefoot.worlds.mujoco.mujoco_world:MujocoWorld",
        "mujoco-exact": "surefoot.worlds.mujoco.exact_world:MujocoExactWorld",
        "rigid": "surefoot.worlds.rigid.rigid_world:RigidWorld",
        "drake": "surefoot.worlds.drake.drake_world:DrakeWorld",
        "bullet": "surefoot.worlds.bullet.bullet_world:BulletWorld",
    },
)
"""Name to class."""
PACKAGES = {"mujoco": ("mujoco",), "mujoco-exact": ("mujoco",), "drake": ("drake",), "bullet": ("pybullet",)}
"""Optional packages of the worlds that need any."""


def packages_of(name: str) -> tuple[str, ...]:
    """Return the optional packages that a world of `WORLDS` needs."""
    return PACKAGES.get(name, ())


def make_world(
    name: str, robot: Robot, terrain: Terrain | None = None, mu: float = 0.6, **options: Any
) -> World:
    """Return a world of `WORLDS` with a robot on a terrain.

    Parameters
    ----------
    name
        A name of `WORLDS`.
    robot, terrain, mu
        Who stands where (None: flat ground), and the friction of the ground.
    options
        Of the world itself: `dt` [s], `payload` [kg], `payload_position` (3,) [m] and its own.

    Raises
    ------
    ProblemError
        For an unknown name.
    ModelError
        If a joint moves next to nothing, which no step of any world can follow.
    MissingExtra
        If the world's engine is not installed.
    """
    from surefoot.worlds.interface.actuated import equipped

    world = WORLDS.load(name)
    equipped(robot, options.get("actuators", "ideal"))
    return world(robot, terrain, mu, **options)
