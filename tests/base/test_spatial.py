"""Rotations and quaternion orders."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from surefoot.base import spatial
from surefoot.base.errors import ProblemError

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


@given(seed=seeds, angle=st.floats(-7.0, 7.0))
def test_quaternion_about_is_the_half_angle_s(seed, angle):
    axis = np.random.default_rng(seed).normal(size=3)
    axis /= np.linalg.norm(axis)
    q = spatial.quaternion_about(axis, angle)
    np.testing.assert_allclose(
        spatial.rotation_from_quaternion(q), spatial.rotation_about(axis, angle), atol=1e-14
    )
    several = spatial.quaternion_about(axis, np.array([[0.0, angle], [angle, angle + 2.0 * np.pi]]))
    assert several.shape == (2, 2, 4)
    np.testing.assert_array_equal(several[0], [[0.0, 0.0, 0.0, 1.0], q])
    # a turn further is the same rotation by the other quaternion
    np.testing.assert_allclose(several[1], [q, -q], atol=1e-14)


@given(seed=seeds, size=st.floats(0.1, 10.0))
def test_tilt_and_heading_are_those_of_the_rotated_axes(seed, size):
    rng = np.random.default_rng(seed)
    R = random_rotation(rng)
    q = spatial.quaternion_from_rotation(R)
    assert spatial.tilt_of(size * q) == pytest.approx(np.arccos(np.clip(R[2, 2], -1.0, 1.0)), abs=1e-7)
    ahead = R[:2, 0] / np.linalg.norm(R[:2, 0])
    np.testing.assert_allclose(spatial.heading_of(q), ahead, atol=1e-9 / np.linalg.norm(R[:2, 0]))


@pytest.mark.parametrize("angle", [1e-9, 0.3, np.pi - 1e-9])
def test_tilt_keeps_its_digits_at_both_ends(angle):
    q = spatial.quaternion_about([0.6, 0.8, 0.0], angle)
    assert spatial.tilt_of(q) == pytest.approx(angle, rel=1e-14)


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


@pytest.mark.parametrize("normal", [[0, 0, 0], [0, 0, 2.0], [0, 0, np.nan], [0, 0, np.inf], [0, 1]])
def test_normals_that_are_not_unit_are_refused(normal):
    with pytest.raises(ProblemError, match="normal"):
        spatial.rotation_from_normal(normal)
