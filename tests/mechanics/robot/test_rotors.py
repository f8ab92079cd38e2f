"""Rotors in a robot's joints, and what its file says about them."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot.dynamics import mass_matrix
from surefoot.mechanics.robot.rotors import joint_figures, with_rotors


def test_rotors_stand_on_the_diagonal_of_the_joints() -> None:
    robot = sf.load_robot("go2")
    armature = np.linspace(0.01, 0.05, 12)
    carried = with_rotors(robot, armature)
    extra = mass_matrix(carried, robot.nominal) - mass_matrix(robot, robot.nominal)
    np.testing.assert_allclose(extra, np.diag([*np.zeros(6), *armature]), atol=1e-15)
    assert carried.mass == robot.mass
    assert carried.foot_names == robot.foot_names


def test_figures_of_a_file() -> None:
    told = joint_figures(sf.load_robot("go1"))  # <dynamics damping="0.01" friction="0.2"/>
    np.testing.assert_array_equal(told.damping, np.full(12, 0.01))
    np.testing.assert_array_equal(told.friction, np.full(12, 0.2))
    np.testing.assert_array_equal(told.armature, np.zeros(12))


@pytest.mark.parametrize("armature", [np.zeros(11), np.full(12, -0.1), np.full(12, np.nan)])
def test_impossible_rotors_are_refused(armature: np.ndarray) -> None:
    with pytest.raises(ProblemError, match="armature must be"):
        with_rotors(sf.load_robot("go2"), armature)
