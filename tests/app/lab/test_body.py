"""Robots as shapes: meshes where Pinocchio puts them, coarsened within their cell, bones without them."""

from __future__ import annotations

from copy import copy

import numpy as np
import pinocchio
from scipy.spatial import cKDTree

import surefoot as sf
from surefoot.app.lab.body import CELL, RobotBody, links_of
from surefoot.app.lab.drawing import Ball, Lines, Mesh
from surefoot.app.viz.meshes import triangles
from surefoot.base.spatial import rotation_from_quaternion


def test_links_stand_where_the_geometry_model_puts_them(robot: sf.Robot) -> None:
    random = np.random.default_rng(2)
    q = pinocchio.integrate(robot.model, robot.nominal, 0.3 * random.normal(size=robot.model.nv))
    data, visual = robot.model.createData(), robot.visual
    placed = visual.createData()
    pinocchio.updateGeometryPlacements(robot.model, data, visual, placed, q)
    drawn = []
    for shape in RobotBody(robot).shapes(q).values():
        assert isinstance(shape, Mesh)
        w, x, y, z = shape.wxyz
        R = rotation_from_quaternion(np.array([x, y, z, w]))
        drawn.append(shape.vertices @ R.T + shape.position)
    cloud = cKDTree(np.vstack(drawn))
    for item, pose in zip(visual.geometryObjects, placed.oMg, strict=True):
        vertices = triangles(item)[0] @ pose.rotation.T + pose.translation
        assert cloud.query(vertices)[0].max() < np.sqrt(3.0) * CELL


def test_two_bodies_share_their_links_and_nothing_else(robot: sf.Robot) -> None:
    one, two = RobotBody(robot), RobotBody(robot)
    assert one.links is two.links is links_of(robot)
    assert one._data is not two._data


def test_a_robot_without_meshes_is_drawn_as_bones(robot: sf.Robot) -> None:
    bare = copy(robot)
    bare._load_visual = pinocchio.GeometryModel
    bare.__dict__.pop("visual", None)  # a cached one
    shapes = RobotBody(bare).shapes(robot.nominal)
    (bones,) = shapes.values()
    assert isinstance(bones, Lines)
    feet = robot.foot_positions(robot.nominal)
    ends = bones.points[:, 1]
    assert all(np.linalg.norm(ends - foot, axis=1).min() < 1e-9 for foot in feet)


def test_a_ball_on_slides_is_drawn_as_a_ball() -> None:
    plan = sf.plan(None, "ball")
    assert plan.robot is not None
    shapes = RobotBody(plan.robot).shapes(np.asarray(plan["q"][0]))
    (ball,) = shapes.values()
    assert isinstance(ball, Ball)
    assert ball.radius == 0.1
    np.testing.assert_allclose(ball.position, [0.0, 0.0, 1.1], atol=1e-9)
