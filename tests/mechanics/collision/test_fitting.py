from __future__ import annotations

import coal
import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

import surefoot as sf
from surefoot.mechanics.collision import Box, Capsule, robot_geometry
from surefoot.mechanics.collision.fitting import fit_points, fitted


def test_a_boxs_corners_make_that_box():
    box, turn = Box((0.5, 0.3, 0.1)), Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix()
    place = np.array([0.1, -0.2, 0.3])
    shape, rotation, position = fit_points(box.knots() @ turn.T + place)
    assert sorted(shape.size) == pytest.approx(sorted(box.size), abs=1e-12)
    np.testing.assert_allclose(position, place, atol=1e-12)
    corners = shape.knots() @ rotation.T + position
    apart = np.linalg.norm(corners[:, None] - (box.knots() @ turn.T + place)[None], axis=2)
    assert apart.min(axis=1).max() < 1e-12
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_points_on_a_capsule_make_that_capsule():
    rng = np.random.default_rng(0)
    way = rng.normal(size=(4000, 3))
    way = np.vstack([way, -way]) / np.linalg.norm(way, axis=1).max()
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way = np.vstack([way, np.diag([1.0, 1.0, 1.0]), -np.eye(3)])
    points = 0.05 * way + np.where(way[:, 2:] > 0, 1.0, -1.0) * np.array([0.0, 0.0, 0.15])
    shape, rotation, position = fit_points(points)
    assert isinstance(shape, Capsule)
    assert (shape.radius, shape.length) == pytest.approx((0.05, 0.3), rel=2e-2)
    assert abs(rotation[2, 2]) > 0.999
    np.testing.assert_allclose(position, 0.0, atol=1e-3)


def test_cylinders_give_way_to_what_fits_them():
    long, turn, _ = fitted(coal.Cylinder(0.05, 0.4))
    assert (long.radius, long.length) == pytest.approx((0.05, 0.3))
    flat, _, _ = fitted(coal.Cylinder(0.05, 0.04))
    assert np.prod(flat.size) == pytest.approx(np.pi * 0.05**2 * 0.04)
    np.testing.assert_array_equal(turn, np.eye(3))
    assert fitted(coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)) is None


@pytest.mark.parametrize("name", ["go2", "a1", "anymal_c", "g1", "solo12"])
def test_a_robot_at_rest_touches_nothing_of_itself(name):
    """In the nominal pose all pairs are apart, and nothing but feet is on z = 0."""
    robot = sf.load_robot(name)
    geometry = robot_geometry(robot)
    data = robot.model.createData()
    pinocchio.forwardKinematics(robot.model, data, robot.nominal)
    poses = [data.oMi[s.joint] * pinocchio.SE3(s.rotation, s.position) for s in geometry.solids]
    placed = [coal.Transform3s(p.rotation, p.translation) for p in poses]
    assert len(geometry.pairs()) > 20
    for a, b in geometry.pairs():
        one, two = geometry.solids[a], geometry.solids[b]
        assert one.joint != two.joint
        apart = coal.distance(
            one.shape.solid(),
            placed[a],
            two.shape.solid(),
            placed[b],
            coal.DistanceRequest(),
            coal.DistanceResult(),
        )
        assert apart > 9e-4, (one.name, two.name)
    for solid, pose in zip(geometry.solids, poses, strict=True):
        if solid.on_ground:
            knots = solid.shape.knots() @ pose.rotation.T + pose.translation
            assert knots[:, 2].min() - solid.shape.radius > 1e-3, solid.name


def test_go2s_shapes_are_within_centimetres_of_its_meshes():
    robot = sf.load_robot("go2")
    way = np.random.default_rng(1).normal(size=(500, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    errors = []
    for item in robot.collision.geometryObjects:
        mesh = item.geometry
        points = np.array([mesh.vertex(k) for k in range(mesh.num_vertices)])
        shape, rotation, position = fitted(mesh)
        reach = np.abs(way @ rotation) @ shape.core + shape.radius + way @ position
        errors.append(reach - (points @ way.T).max(axis=0))
    assert np.abs(errors).max() < 0.045
    assert np.sqrt(np.mean(np.square(errors))) < 0.015
