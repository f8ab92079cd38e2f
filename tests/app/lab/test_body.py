"""Robots as shapes: meshes where Pinocchio puts them, coarsened within a cell, bones without them."""

from __future__ import annotations

from copy import copy

import numpy as np
import pinocchio
import pytest
from scipy.spatial import cKDTree

import surefoot as sf
from surefoot.app.lab import body
from surefoot.app.lab.body import MOST_TRIANGLES, RobotBody, coarse, links_of
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
        assert cloud.query(vertices)[0].max() < 1e-6  # Go2's are few enough to be drawn as they are


def test_meshes_that_are_too_many_are_coarsened(monkeypatch: pytest.MonkeyPatch, robot: sf.Robot) -> None:
    whole = sum(len(link.faces) for link in links_of(robot))
    assert whole <= MOST_TRIANGLES
    monkeypatch.setattr(body, "MOST_TRIANGLES", whole // 2)
    links = links_of.__wrapped__(robot)
    assert sum(len(link.faces) for link in links) <= whole // 2
    assert len(links) == len(links_of(robot))


def test_both_sides_of_a_thin_wall_stay() -> None:
    """A plate of a millimetre between two sheets of four triangles each."""
    corners = np.array([[x, y, 0.0] for x in (0.0, 0.1, 0.2) for y in (0.0, 0.1)])
    top = np.array([[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]])
    vertices = np.vstack([corners + np.array([0.0, 0.0, 0.001]), corners])
    faces = np.vstack([top, top[:, ::-1] + len(corners)])
    fewer, kept = coarse(vertices, faces, 0.01)
    assert len(kept) == len(faces)
    assert sorted(set(fewer[:, 2])) == [0.0, 0.001]
    assert len(coarse(vertices, top, 0.15)[1]) < len(top)


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
