"""The nearest point of a cone of rays against a search of all its faces."""

from itertools import combinations

import numpy as np
import pytest

from surefoot.contact.cones.nearest import nearest_in_cone, nearest_points


def nearest_twin(rays, x):
    """The nearest of the admissible least-squares points on the spans of all subsets of the rays."""
    best = np.zeros_like(x)
    for size in range(1, x.size + 1):
        for chosen in combinations(rays, size):
            weights = np.linalg.lstsq(np.array(chosen).T, x, rcond=None)[0]
            point = weights @ chosen
            if (weights >= -1e-12).all() and np.sum((x - point) ** 2) < np.sum((x - best) ** 2):
                best = point
    return best


@pytest.mark.parametrize(("count", "dim"), [(3, 2), (4, 3), (7, 3), (8, 4)])
def test_nearest_points(count, dim):
    rng = np.random.default_rng(count)
    rays = rng.normal(size=(count, dim))
    rays[:, 0] = np.abs(rays[:, 0]) + 0.3
    rays[-1] = rays[0] + rays[1]  # one that depends on the others
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    points, out = np.vstack([3.0 * rng.normal(size=(20, dim)), rays[:2], np.zeros(dim)]), np.empty((23, dim))
    assert nearest_points(rays, points, out)
    expected = [nearest_twin(rays, x) for x in points]
    np.testing.assert_allclose(out, expected, atol=1e-10)
    np.testing.assert_allclose(nearest_in_cone(7.0 * rays, points), expected, atol=1e-10)
