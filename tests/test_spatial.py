"""Rotations, wrench and twist transforms, quaternion orders."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from surefoot import spatial
from surefoot.errors import ProblemError

seeds = st.integers(0, 2**32 - 1)


def random_rotation(rng):
    return Rotation.random(random_state=rng.integers(2**31)).as_matrix()


@given(seed=seeds)
def test_skew_is_the_cross_product(seed):
    a, b = np.random.default_rng(seed).normal(size=(2, 5, 3))
    np.testing.assert_allclose((spatial.skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=1e-14)


@given(seed=seeds)
def test_contact_frames_are_rotations_with_z_along_the_normal(seed):
    rng = np.random.default_rng(seed)
    normal, heading = rng.normal(size=(2, 3))
    normal /= np.linalg.norm(normal)
    for forward in (heading, normal, -normal, [1.0, 0.0, 0.0]):
        R = spatial.rotation_from_normal(normal, forward)
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1.0)
        np.testing.assert_allclose(R[:, 2], normal, atol=1e-12)
    R = spatial.rotation_from_normal(normal, heading)
    along = heading - (heading @ normal) * normal
    assert R[:, 0] @ along == pytest.approx(np.linalg.norm(along))


@given(seed=seeds, angle=st.floats(-7.0, 7.0))
def test_rotation_about_an_axis(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    R = spatial.rotation_about(axis, angle)
    np.testing.assert_allclose(R, Rotation.from_rotvec(axis * angle).as_matrix(), atol=1e-12)


@given(
    seed=seeds, angle=st.one_of(st.floats(0.0, np.pi), st.floats(np.pi - 1e-7, np.pi), st.floats(0.0, 1e-7))
)
def test_rotation_log_inverts_rotation_about(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    R = spatial.rotation_about(axis, angle)
    log = spatial.rotation_log(R)
    np.testing.assert_allclose(Rotation.from_rotvec(log).as_matrix(), R, atol=1e-10)
    assert np.linalg.norm(log) <= np.pi + 1e-9
    assert np.linalg.norm(log) == pytest.approx(angle, abs=1e-7)


@given(seed=seeds)
def test_quaternions_round_trip_and_follow_scipys_order(seed):
    rng = np.random.default_rng(seed)
    R = random_rotation(rng)
    q = spatial.quaternion_from_rotation(R)
    assert q[3] >= 0.0
    assert np.linalg.norm(q) == pytest.approx(1.0)
    np.testing.assert_allclose(Rotation.from_quat(q).as_matrix(), R, atol=1e-12)  # SciPy: x, y, z, w
    np.testing.assert_allclose(spatial.rotation_from_quaternion(3.0 * q), R, atol=1e-12)
    np.testing.assert_allclose(spatial.rotation_from_quaternion(-q), R, atol=1e-12)


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), [[0.6, 0.0, 0.8]]]))
def test_quaternions_of_half_turns(axis):
    R = spatial.rotation_about(axis, np.pi)
    q = spatial.quaternion_from_rotation(R)
    np.testing.assert_allclose(spatial.rotation_from_quaternion(q), R, atol=1e-12)


def test_quaternion_orders():
    np.testing.assert_array_equal(spatial.quaternion_xyzw([[1, 2, 3, 4]]), [[2, 3, 4, 1]])
    np.testing.assert_array_equal(spatial.quaternion_wxyz([2, 3, 4, 1]), [1, 2, 3, 4])


@settings(max_examples=50)
@given(seed=seeds)
def test_power_does_not_depend_on_the_frame(seed):
    """Wrench and twist transforms are inverse transposes of each other."""
    rng = np.random.default_rng(seed)
    R, p = random_rotation(rng), rng.normal(size=3)
    X, T = spatial.wrench_transform(R, p), spatial.twist_transform(R, p)
    wrench, twist = rng.normal(size=(2, 6))
    assert (X @ wrench) @ (T @ twist) == pytest.approx(wrench @ twist, abs=1e-10)
    np.testing.assert_allclose(T, np.linalg.inv(X).T, atol=1e-10)


@settings(max_examples=50)
@given(seed=seeds)
def test_transforms_say_what_mechanics_says(seed):
    """A force at b makes the moment p x f about a; a body's point at b moves with v + w x p."""
    rng = np.random.default_rng(seed)
    R, p, force, moment = random_rotation(rng), *rng.normal(size=(3, 3))
    got = spatial.wrench_transform(R, p) @ np.concatenate([force, moment])
    np.testing.assert_allclose(got[:3], R @ force, atol=1e-12)
    np.testing.assert_allclose(got[3:], R @ moment + np.cross(p, R @ force), atol=1e-12)
    twist_a = spatial.twist_transform(R, p) @ np.concatenate([force, moment])
    linear, angular = twist_a[:3], twist_a[3:]
    np.testing.assert_allclose(linear + np.cross(angular, p), R @ force, atol=1e-12)  # velocity at b
    np.testing.assert_allclose(angular, R @ moment, atol=1e-12)


@settings(max_examples=30)
@given(seed=seeds)
def test_transforms_chain(seed):
    rng = np.random.default_rng(seed)
    R1, R2, p1, p2 = random_rotation(rng), random_rotation(rng), *rng.normal(size=(2, 3))
    for transform in (spatial.wrench_transform, spatial.twist_transform):
        whole = transform(R1 @ R2, p1 + R1 @ p2)
        np.testing.assert_allclose(whole, transform(R1, p1) @ transform(R2, p2), atol=1e-12)


def test_featherstones_order_is_moment_first():
    wrench = np.arange(6.0)
    np.testing.assert_array_equal(spatial.featherstone_from_wrench(wrench), [3, 4, 5, 0, 1, 2])
    np.testing.assert_array_equal(spatial.featherstone_from_twist(wrench), [3, 4, 5, 0, 1, 2])
    np.testing.assert_array_equal(
        spatial.wrench_from_featherstone(spatial.featherstone_from_wrench(wrench)), wrench
    )
    np.testing.assert_array_equal(
        spatial.twist_from_featherstone(spatial.featherstone_from_twist(wrench)), wrench
    )


@pytest.mark.parametrize("normal", [[0, 0, 0], [0, 0, 2.0], [0, 0, np.nan], [0, 0, np.inf], [0, 1]])
def test_normals_that_are_not_unit_are_refused(normal):
    with pytest.raises(ProblemError, match="normal"):
        spatial.rotation_from_normal(normal)
