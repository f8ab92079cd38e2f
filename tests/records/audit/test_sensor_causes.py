"""Causes that lie in what a controller believes: torques that nothing asks for, and what gravity asks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.records.audit.story.sensor_causes import _weight_on, bias, drift
from surefoot.records.audit.story.signals import Signals
from tests.records.audit.made_signals import made_signals

DT, LIMIT, COUNT = 0.002, 20.0, 600
ARM = {
    "model_parents": np.array([0, 0, 1, 2]),
    "model_masses": np.array([0.0, 3.0, 2.0, 1.0]),
    "model_positions": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [0.3, 0.0, 0.0], [0.0, 0.4, 0.0]]),
    "model_joint_bodies": np.array([1, 2, 3]),
    "model_joint_axes": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]]),
}
"""A turntable with two links in a row, each of them held by a hinge."""


def signals(torques: np.ndarray, **facts: Any) -> Signals:
    """Return the signals of joints that never move, which are asked for (T, joints) torques."""
    still = np.zeros(torques.shape)
    arrays = {
        "time": DT * np.arange(len(torques)), "torques": torques, "forces": np.zeros((len(torques), 1, 3)),
        "joint_positions": still, "joint_velocities": still,
    }  # fmt: skip
    known = {"effort_limits": np.full(torques.shape[1], LIMIT), "mass": 6.0}
    return made_signals(arrays, known | facts, ("foot",), 6.0 * 9.81, DT)


def slow(joints: int = 3) -> np.ndarray:
    """Return torques that change slowly, each in its own way."""
    time = DT * np.arange(COUNT)[:, None]
    return 0.1 * LIMIT * np.sin(time * (1.0 + np.arange(joints)))


def test_a_joint_carries_all_that_hangs_on_it_as_far_out_as_it_reaches() -> None:
    """About an upright axis of a bolted arm nothing hangs."""
    found = _weight_on(signals(slow(), **ARM))
    np.testing.assert_allclose(found, [0.0, 3.0 * 9.81 * 0.4, 1.0 * 9.81 * 0.4], rtol=1e-3)
    level = ARM | {"model_joint_axes": np.tile([0.0, 1.0, 0.0], (3, 1))}
    np.testing.assert_allclose(_weight_on(signals(slow(), **level))[0], 6.0 * 9.81 * 0.7, rtol=1e-3)


def test_a_slide_carries_all_of_the_weight_and_without_a_model_each_joint_does() -> None:
    kinds = ("hinge", "slide", "hinge")
    found = _weight_on(signals(slow(), **ARM, model_joint_kinds=kinds))
    np.testing.assert_allclose(found, [0.0, 6.0 * 9.81, 1.0 * 9.81 * 0.4], rtol=1e-3)
    assert (_weight_on(signals(slow())) == 0.0).all()  # nothing touches: no height is known


def test_one_joint_that_is_driven_from_the_first_row_is_named() -> None:
    torques = slow()
    torques[:, 1] += 0.8 * LIMIT
    (found,) = bias(signals(torques, **ARM))
    assert (found.where, found.time) == ("joint 1", 0.0)
    assert "+16 N m" in found.evidence
    assert not list(bias(signals(slow(), **ARM)))


def test_what_gravity_asks_of_a_joint_is_no_bias() -> None:
    torques = slow()
    torques[:, 1] += 1.1 * 3.0 * 9.81 * 0.4
    assert not list(bias(signals(torques, **ARM)))


@pytest.mark.parametrize("joint", [0, 2])
def test_a_torque_that_jumps_while_nothing_moves_is_of_its_joint(joint: int) -> None:
    torques = slow()
    torques[400:, joint] += 0.6 * LIMIT
    (found,) = bias(signals(torques, **ARM))
    assert (found.where, found.time) == (f"joint {joint}", pytest.approx(400 * DT))


def test_torques_that_jump_together_are_of_the_base_and_those_that_jump_on_of_none() -> None:
    torques = slow()
    torques[400:, :2] += 0.6 * LIMIT
    s = signals(torques, **ARM, model_bodies=("turntable", "upper", "lower"))
    assert not list(bias(s))
    (found,) = drift(s)
    assert (found.where, found.time) == ("turntable", pytest.approx(400 * DT))
    torques[440:, :2] -= 0.6 * LIMIT
    again = list(drift(signals(torques, **ARM)))
    assert not [sign for sign in again if "jumps" in sign.evidence]
