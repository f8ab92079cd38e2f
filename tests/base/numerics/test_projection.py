"""The nearest point of a truncated friction cone and its derivative, against twins that share no formula."""

import numpy as np
import pytest

from surefoot.base.numerics import projection


def project_twin(point, mu, low, high):
    """The nearest point by bisection on the height: the distance to a disc is convex in it."""
    t = np.hypot(point[0], point[1])

    def slope(z):
        return z - point[2] - mu * max(t - mu * z, 0.0)

    left, right = low, min(high, 1e3 + abs(point[2]) + mu * t)
    for _ in range(200):
        middle = 0.5 * (left + right)
        left, right = (middle, right) if slope(middle) < 0.0 else (left, middle)
    share = min(1.0, mu * left / t) if t > 0.0 else 1.0
    return np.array([share * point[0], share * point[1], left])


def jacobian_twin(point, cone, size=1e-6):
    """Central differences."""
    columns = [
        project_twin(point + size * e, *cone) - project_twin(point - size * e, *cone) for e in np.eye(3)
    ]
    return np.stack(columns, axis=1) / (2.0 * size)


def cases(count=400):
    rng = np.random.default_rng(0)
    for k in range(count):
        mu, low = rng.uniform(0.0, 2.0), rng.choice([0.0, rng.uniform(0.0, 2.0)])
        yield 5.0 * rng.normal(size=3), (0.0 if k % 40 == 0 else mu, low, rng.choice([low + 3.0, np.inf]))


def test_projection():
    for point, cone in cases():
        np.testing.assert_allclose(
            projection.project_truncated(*point, *cone), project_twin(point, *cone), atol=1e-9
        )
        if cone[1] == 0.0:
            expected = project_twin(point, cone[0], 0.0, np.inf)
            np.testing.assert_allclose(projection.project_cone(*point, cone[0]), expected, atol=1e-9)


def jacobian_of_face(sticks, free, p, q, across, along, mu):
    """Put the sum of v vᵀ together, as the docstring of `face` says it."""
    vectors = [[-across * q, across * p, 0.0], [along * mu * p, along * mu * q, along]]
    if sticks:
        vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, float(free)]]
    return np.transpose(vectors) @ vectors


def test_generalised_jacobian():
    """Where the projection is smooth it is its derivative; `differential` is that times a vector."""
    seen = set()
    for point, (mu, low, high) in cases():
        z = projection.project_truncated(*point, mu, low, high)[2]  # exactly at its bound, or not
        face = projection.face(point[0], point[1], z, mu, low, high)
        found = jacobian_of_face(*face, mu)
        expected = jacobian_twin(point, (mu, low, high))
        if np.abs(expected - jacobian_twin(point, (mu, low, high), 1e-4)).max() > 1e-3:
            continue  # near a kink
        np.testing.assert_allclose(found, expected, atol=2e-5)
        d = point[::-1].copy()
        moved = projection.differential(point[0], point[1], z, mu, low, high, *d)
        np.testing.assert_allclose(moved, expected @ d, atol=1e-3)
        seen.add((face[0], face[1], face[4] > 0.0, face[5] > 0.0))
    assert len(seen) >= 5


@pytest.mark.parametrize("point", [(0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 2.0)])
def test_no_face_at_the_apex_and_none_without_friction(point):
    assert jacobian_of_face(*projection.face(*point[:2], 0.0, 0.7, 0.0, np.inf), 0.7).any() == 0
    frictionless = jacobian_of_face(*projection.face(*point[:2], 1.0, 0.0, 0.0, np.inf), 0.0)
    np.testing.assert_array_equal(frictionless, np.diag([0.0, 0.0, 1.0]))
