"""What a policy is given of the state: directions in body axes, clocks, and the ground around it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from surefoot.mechanics.terrain import SlopeTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.policy.observation_terms import ALIASES, CLOCK, GRID, KINDS, Senses


def senses(turn: tuple[float, float, float] = (0.0, 0.0, 0.0), time: float = 0.0) -> Senses:
    """Return what is sensed 0.4 m above the origin, turned by a rotation vector [rad]."""
    q = np.r_[0.3, -0.2, 0.4, pinocchio.Quaternion(pinocchio.exp3(np.array(turn))).coeffs(), np.zeros(2)]
    state = RobotState(q, np.arange(8.0), time)
    return Senses(state, np.array([0.1, 0.2]), np.array([6.0, 7.0]), np.array([0.5, 0.1, -0.3]), np.ones(2),
                  SlopeTerrain(10.0))  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_gravity_points_down_in_body_axes(seed: int) -> None:
    turn = np.random.default_rng(seed).normal(size=3)
    down = pinocchio.exp3(turn).T @ [0.0, 0.0, -1.0]
    np.testing.assert_allclose(KINDS["gravity"].sensed(senses(tuple(turn)), {}), down, atol=1e-12)


def test_parts_of_state_and_command_are_theirs() -> None:
    wanted = {
        "linear_velocity": [0, 1, 2], "angular_velocity": [3, 4, 5], "command": [0.5, 0.1, -0.3],
        "command_linear": [0.5, 0.1], "command_angular": [-0.3], "joint_positions": [0.1, 0.2],
        "joint_velocities": [6, 7], "last_action": [1, 1],
    }  # fmt: skip
    for name, numbers in wanted.items():
        np.testing.assert_array_equal(KINDS[name].sensed(senses(), {}), numbers)
    assert set(ALIASES.values()) <= KINDS.keys()


def test_a_clock_runs_round_once_a_period_and_rests_without_a_command() -> None:
    clock = {**CLOCK, "period": 0.5, "offsets": (0.0, 0.25), "still": 0.5}

    def at(time: float) -> np.ndarray:
        return KINDS["phase"].sensed(senses(time=time), clock)

    np.testing.assert_allclose(at(0.0), [0.0, 1.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(at(0.125), [1.0, 0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(at(0.6), at(0.1), atol=1e-12)
    still = replace(senses(time=0.1), command=np.array([0.0, 0.009, 0.0]))
    np.testing.assert_allclose(KINDS["phase"].sensed(still, clock), [0.0, 0.0, -1.0, -1.0], atol=1e-12)
    slow = replace(senses(time=0.1), command=np.array([0.0, 0.011, 0.0]))
    np.testing.assert_allclose(KINDS["phase"].sensed(slow, clock), at(0.1))


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_a_scan_turns_with_the_robot(yaw: float) -> None:
    """On a slope of 10 degrees along x, ground dx ahead is tan(10°) dx higher."""
    xs, ys = (-0.2, 0.0, 0.5), (0.1, -0.3)
    for fastest in ("y", "x"):
        grid = {**GRID, "x": xs, "y": ys, "offset": 0.1, "fastest": fastest}
        order = [(x, y) for x in xs for y in ys] if fastest == "y" else [(x, y) for y in ys for x in xs]
        places = [0.3 + math.cos(yaw) * x - math.sin(yaw) * y for x, y in order]
        wanted = 0.4 - 0.1 - math.tan(math.radians(10.0)) * np.array(places)
        found = KINDS["height_scan"].sensed(senses((0.0, 0.0, yaw)), grid)
        np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_feet_that_tell_nothing_stand() -> None:
    here = senses()
    np.testing.assert_array_equal(KINDS["foot_contact"].sensed(here, {"feet": 4}), np.ones(4))
    felt = replace(here, state=here.state._replace(contact=np.array([True, False])))
    np.testing.assert_array_equal(KINDS["foot_contact"].sensed(felt, {"feet": 4}), [1.0, 0.0])
