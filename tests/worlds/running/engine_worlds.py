"""What tests of the worlds of other engines share: a flight against Pinocchio, and what comes to rest."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.moving import advance, lifted


def flight_errors(world_of: Callable[..., Any], steps: Sequence[float], exact: float) -> list[float]:
    """Return how far velocities are off after 20 ms in the air, with motors and a push, at each step."""
    robot, rng = sf.load_robot("go2"), np.random.default_rng(3)
    q, v = lifted(robot.nominal, 2.0), rng.normal(size=18)
    q[3:7] = np.array([0.3, -0.2, 0.1, 0.9]) / np.linalg.norm([0.3, -0.2, 0.1, 0.9])
    torques, push = rng.normal(size=12), np.array([20.0, -30.0, 10.0])

    def flown(world: Any) -> np.ndarray:
        world.reset(q, v)
        assert np.allclose(world.q_v()[1], v, rtol=0.0, atol=1e-12)
        advance(world, round(0.02 / world.dt), torques, push)
        assert world.contacts().forces.max() == 0.0
        return world.q_v()[1]

    wanted, errors = flown(RigidWorld(robot, dt=exact)), []
    for dt in steps:
        world = world_of(robot, dt=dt)
        errors.append(float(np.abs(flown(world) - wanted).max()))
        world.close()
    return errors


def contacts_after(world: Any, steps: int) -> Any:
    """Return the contacts of a body without joints after so many steps."""
    advance(world, steps, np.zeros(0))
    return world.contacts()
