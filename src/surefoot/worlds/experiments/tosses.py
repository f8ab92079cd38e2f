"""Rivals of our own thrown body: other simulators with their own words of contact to fit."""

from __future__ import annotations

from typing import Any

from surefoot.base.errors import check_name
from surefoot.records import TossModel
from surefoot.worlds.experiments.bullet_tosses import BulletBody
from surefoot.worlds.experiments.drake_tosses import DrakeBody
from surefoot.worlds.experiments.mujoco_tosses import MujocoBody

RIVALS: dict[str, Any] = {one.name: one for one in (MujocoBody, DrakeBody, BulletBody)}
"""Rivals by name: what `--rivals` chooses from."""


def rival(name: str, threads: int = 1) -> TossModel:
    """Return a rival; MuJoCo's shares tosses among threads, Drake's and Bullet's do one after the other."""
    check_name("rival", name, RIVALS)
    made: TossModel = MujocoBody(threads) if name == MujocoBody.name else RIVALS[name]()
    return made
