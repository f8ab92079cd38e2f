"""The MuJoCo world with exact contacts under a name of its own, for `--world` and studies."""

from __future__ import annotations

from typing import Any

from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld


class MujocoExactWorld(MujocoWorld):
    """``MujocoWorld(robot, terrain, mu, exact=True, **options)``."""

    def __init__(self, robot: Robot, terrain: Terrain | None = None, mu: float = 0.6, **options: Any) -> None:
        super().__init__(robot, terrain, mu, exact=True, **options)
