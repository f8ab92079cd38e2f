"""Pieces of whole-body control: views of Pinocchio's data, what is computable, torques beyond limits."""

from __future__ import annotations

import copy

import numpy as np
import pinocchio
import pytest

from surefoot.motion.control.damping import LARGEST, computable
from surefoot.motion.control.model_views import ModelViews
from tests.robots import robot_of


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_views_follow_the_data(name: str) -> None:
    robot, rng = robot_of(name), np.random.default_rng(1)
    views = ModelViews(robot.model, robot.model.createData())
    for _ in range(2):
        q = pinocchio.integrate(robot.model, robot.nominal, 0.3 * rng.normal(size=robot.model.nv))
        v, data = rng.normal(size=robot.model.nv), views.data
        pinocchio.computeAllTerms(robot.model, data, q, v)
        pinocchio.computeJointJacobiansTimeVariation(robot.model, data, q, v)
        pinocchio.crba(robot.model, data, q)
        pinocchio.updateFramePlacements(robot.model, data)
        assert np.array_equal(views.mass_matrix, np.array(data.M))
        assert np.array_equal(views.mass_matrix, views.mass_matrix.T)
        assert np.array_equal(views.bias, np.array(data.nle))
        assert np.array_equal(views.twists, np.array(data.J))
        assert np.array_equal(views.twist_rates, np.array(data.dJ))
        for k, pose in enumerate(data.oMf):
            assert np.array_equal(views.frame_rotations[k], pose.rotation)
            assert np.array_equal(views.frame_places[k], pose.translation)
        assert np.array_equal(views.rotation, data.oMi[1].rotation)
        assert np.array_equal(views.place, data.oMi[1].translation)
    own = copy.deepcopy(views)
    before = views.bias.copy()
    pinocchio.nonLinearEffects(robot.model, own.data, robot.nominal, np.zeros(robot.model.nv))
    assert np.array_equal(own.bias, np.array(own.data.nle))
    assert np.array_equal(views.bias, before)


def test_only_states_of_finite_size_are_computable() -> None:
    for bad in (np.nan, np.inf, -np.inf, 1.1 * LARGEST, -1.1 * LARGEST):
        x = np.array([1.0, bad, 0.0])
        assert computable(np.ones(3), x) == computable(x, np.ones(3)) == bool(np.abs(x).max() <= LARGEST)
    assert computable(np.full(3, LARGEST), np.zeros(0))
