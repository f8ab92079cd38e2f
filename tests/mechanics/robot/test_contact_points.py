"""Contact points as one value: against Pinocchio's own kinematics and Jacobians."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio
import pytest

from surefoot.mechanics.robot import load_robot
from surefoot.worlds.rigid.bodies import box, falling_cat


@pytest.mark.parametrize("name", ["go2", "g1", "solo12", "talos"])
def test_points_are_where_the_feet_are_and_move_as_their_joints_say(name: str) -> None:
    robot, rng = load_robot(name), np.random.default_rng(0)
    model, points = robot.model, robot.contact_points
    data = model.createData()
    q = pinocchio.integrate(model, robot.nominal, 0.2 * rng.normal(size=model.nv))
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    assert len(points) == len(points.names) == sum(len(foot.centres) for foot in robot.feet)
    for p in range(len(points)):
        foot = robot.feet[points.foot[p]]
        in_foot = data.oMf[foot.frame].act(points.centres[p])
        assert data.oMi[int(points.joints[p])].act(points.places[p]) == pytest.approx(in_foot, abs=1e-12)
        assert points.radii[p] == foot.radius
        assert points.names[p].startswith(f"{foot.name}:")
        J = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.ReferenceFrame.WORLD)
        assert (points.support[p] == np.abs(J).any(axis=0)).all()
    assert points.frames == tuple(foot.frame for foot in robot.feet)
    assert points.middles == pytest.approx(np.array([foot.centre for foot in robot.feet]))
    assert points.flat.tolist() == [foot.flat for foot in robot.feet]


def test_the_value_is_frozen_and_made_once() -> None:
    robot = load_robot("go2")
    assert robot.contact_points is robot.contact_points
    with pytest.raises(dataclasses.FrozenInstanceError):
        robot.contact_points.radii = np.zeros(4)  # type: ignore[misc]


def test_bodies_with_corners_and_without_feet() -> None:
    assert len(box().contact_points) == 8
    cat = falling_cat().contact_points
    assert len(cat) == 0
    assert cat.centres.shape == cat.places.shape == (0, 3)
    assert cat.support.shape == (0, cat.foot_support.shape[1])


def test_a_fixed_base_moves_no_foot() -> None:
    robot = load_robot("go2", fixed_base=True)
    assert robot.contact_points.foot_support.sum(axis=1).tolist() == [3, 3, 3, 3]
