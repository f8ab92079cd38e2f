"""Worlds by name, one line each: what `--world` chooses from."""

from __future__ import annotations

from collections.abc import Callable
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from surefoot.base.errors import check_name

if TYPE_CHECKING:  # the command line reads the names without loading a robot
    from surefoot.mechanics import Robot, Terrain
    from surefoot.worlds.interface.world import World

WORLDS: dict[str, tuple[str | Callable[..., World], tuple[str, ...]]] = {
    "mujoco": ("surefoot.worlds.mujoco.mujoco_world:MujocoWorld", ("mujoco",)),
    "rigid": ("surefoot.worlds.rigid.rigid_world:RigidWorld", ()),
    "drake": ("surefoot.worlds.drake.drake_world:DrakeWorld", ("drake",)),
    "bullet": ("surefoot.worlds.bullet.bullet_world:BulletWorld", ("pybullet",)),
}
"""Name to the class (or "module:class", imported when asked for), and the packages that it needs."""


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
    MissingExtra
        If the world's engine is not installed.
    """
    check_name("world", name, WORLDS)
    made = WORLDS[name][0]
    if isinstance(made, str):
        made = resolve_name(made)
    return made(robot, terrain, mu, **options)
