"""Velocities of points and cross products against NumPy."""

import numpy as np

from surefoot.base.kernels import kernel
from surefoot.base.numerics import points, vectors


@kernel
def run_velocity(twists, j, place):
    return points.point_velocity(twists, j, place[0], place[1], place[2])


def velocity_twin(twists, place):
    """(3, m) velocities of the bodies' points at a place, by the definition."""
    return twists[:3] + np.cross(twists[3:].T, place).T


def test_velocities_and_their_jacobians():
    rng = np.random.default_rng(0)
    twists, places, body = rng.normal(size=(6, 9)), rng.normal(size=(4, 3)), np.array([1, 0, 1, 2])
    support = rng.random((3, 9)) < 0.6
    frames = np.linalg.qr(rng.normal(size=(4, 3, 3)))[0]
    J, row = np.full((12, 9), np.nan), np.full((3, 9), np.nan)
    points.contact_jacobian(twists, support, body, places, frames, J)
    for k in range(4):
        expected = velocity_twin(twists, places[k])
        np.testing.assert_allclose(run_velocity(twists, 5, places[k]), expected[:, 5], rtol=1e-13)
        expected = expected * support[body[k]]
        points.point_jacobian(twists, support[body[k]], places[k], row)
        np.testing.assert_allclose(row, expected, atol=1e-14)
        np.testing.assert_allclose(J[3 * k : 3 * k + 3], frames[k].T @ expected, atol=1e-13)


def test_jacobian_of_one_body_against_another():
    rng = np.random.default_rng(2)
    twists, places = rng.normal(size=(6, 9)), rng.normal(size=(4, 3))
    support = rng.random((3, 9)) < 0.6
    first, second, on = np.array([0, 1, 0, 2]), np.array([1, 2, 2, 1]), np.array([True, True, False, True])
    frames = np.linalg.qr(rng.normal(size=(4, 3, 3)))[0]
    J = np.full((12, 9), np.nan)
    points.relative_jacobian(twists, support, first, second, places, frames, on, J)
    for k in range(4):
        velocity = velocity_twin(twists, places[k])
        expected = frames[k].T @ (velocity * support[second[k]] - velocity * support[first[k]])
        np.testing.assert_allclose(J[3 * k : 3 * k + 3], expected * on[k], atol=1e-13)


def test_vectors():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 3))
    np.testing.assert_allclose(vectors.cross(tuple(a), tuple(b)), np.cross(a, b), rtol=1e-13)
    x, d = rng.normal(size=(2, 11))
    assert abs(vectors.dot(x, d) - x @ d) < 1e-13
    expected = x + 0.3 * d
    vectors.advance(x, 0.3, d)
    np.testing.assert_allclose(x, expected, rtol=1e-14)
