"""Distances beyond hulls against SciPy's, and where hulls are none."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from surefoot.records.audit.story.hulls import outside_hulls


@pytest.mark.parametrize("size", [3, 4, 7, 16])
def test_distances_are_those_to_the_sides_of_the_hull(size: int) -> None:
    rng = np.random.default_rng(size)
    corners, points = rng.normal(size=(300, size, 2)), 2.0 * rng.normal(size=(300, 2))
    found = outside_hulls(corners, points)
    for at, point, distance in zip(corners, points, found, strict=True):
        planes = ConvexHull(at).equations
        assert distance == pytest.approx(max((planes[:, :2] @ point + planes[:, 2]).max(), 0.0), abs=1e-12)
    assert 20 < np.count_nonzero(found) < 300


def test_a_square_with_corners_named_twice_is_a_square() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [0.5, 0.0]])
    points = np.array([[0.5, 0.5], [2.0, 0.5], [0.5, -0.25], [1.0, 1.0]])
    np.testing.assert_allclose(
        outside_hulls(np.tile(square, (4, 1, 1)), points), [0.0, 1.0, 0.25, 0.0], atol=1e-15
    )


def test_what_has_no_sides_is_as_far_as_its_nearest_corner() -> None:
    line = np.array([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]])
    for corners in (line, line[:2], line[:1], np.zeros((4, 2))):
        assert outside_hulls(corners[None], np.array([[0.0, 2.0]])) == [2.0]
    assert np.isnan(outside_hulls(np.full((1, 4, 2), np.nan), np.zeros((1, 2)))).all()
    assert outside_hulls(np.zeros((0, 4, 2)), np.zeros((0, 2))).shape == (0,)
