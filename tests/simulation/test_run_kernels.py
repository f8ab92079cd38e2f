"""Small kernels of a run's loop and of MuJoCo's joints, against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.robot.motor_limits import MotorLimits
from surefoot.simulation.mujoco_actuators import load_joints
from surefoot.simulation.run_kernels import any_reached, loaded_feet


def test_loaded_feet_and_torques_at_limits() -> None:
    random = np.random.default_rng(6)
    foot = np.array([0, 0, 2, 1, 2, 3])
    for _ in range(30):
        forces = random.normal(size=(6, 3)) * random.choice([0.0, 10.0], size=(6, 1))
        wanted = np.zeros(5, dtype=bool)
        wanted[foot[forces[:, 2] > 4.0]] = True
        np.testing.assert_array_equal(loaded_feet(foot, forces, 5, 4.0), wanted)
        torques, limits = random.normal(size=12), random.uniform(0.5, 4.0, 12)
        assert any_reached(torques, limits) == bool((np.abs(torques) >= limits).any())
    assert any_reached(np.array([0.0, -2.0]), np.array([1.0, 2.0]))
    assert not any_reached(np.array([np.nan, -1.9]), np.array([1.0, 2.0]))


@pytest.mark.parametrize("bad", [None, np.nan, -np.inf])
def test_joints_are_loaded_with_what_motors_give(bad: float | None) -> None:
    random = np.random.default_rng(8)
    limits = MotorLimits(random.uniform(5.0, 20.0, 12), random.uniform(5.0, 20.0, 12), 0.4, 0.9)
    asked, qpos, qvel = random.normal(scale=20.0, size=12), random.normal(size=19), random.normal(size=18)
    if bad is not None:
        asked[7] = bad
    qvel[6:] *= 10.0
    given, applied, q, v = np.zeros(12), np.zeros(12), np.zeros(19), np.zeros(18)
    done = load_joints(asked, limits.effort, limits.speed, 0.4, 0.9, given, applied, qpos, qvel, q, v)
    assert done == (bad is None)
    if done:
        low, high = limits.bounds(qvel[6:])
        np.testing.assert_array_equal(given, np.clip(asked, low, high))
        for filled, value in ((applied, given), (q, qpos), (v, qvel)):
            np.testing.assert_array_equal(filled, value)
    else:
        assert not any(np.concatenate([given, applied, q, v]))
