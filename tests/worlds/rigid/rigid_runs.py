"""What tests of the rigid world share: a pose on a slope, and a run without torques."""

from __future__ import annotations

import math

import numpy as np

import surefoot as sf
from surefoot.base.spatial import quaternion_from_rotation, rotation_about
from surefoot.worlds.rigid.rigid_world import RigidWorld

NONE = np.zeros(0)


def on_slope(body: sf.Robot, degrees: float, lift: float = 0.0) -> np.ndarray:
    """The body's nominal pose laid onto a slope through the origin."""
    rotation = rotation_about([0, 1, 0], -math.radians(degrees))
    q = body.nominal.copy()
    q[:3] = rotation @ [0.0, 0.0, body.nominal[2] + lift]
    q[3:7] = quaternion_from_rotation(rotation)
    return q


def run(world: RigidWorld, seconds: float, push=None) -> list[tuple[np.ndarray, np.ndarray]]:
    states = []
    for _ in range(round(seconds / world.dt)):
        world.step(NONE, push)
        states.append(world.q_v())
    return states
