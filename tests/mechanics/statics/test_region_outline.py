"""The search for a region on programs whose regions are known: hulls of points, discs, half-planes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from surefoot.mechanics.statics.region_outline import OUT_OF_DIRECTIONS, TRACED, WITHOUT_BOUND, trace


class Outline:
    """What the search finds of {G x + offset : B x = b, x in the cone}."""

    def __init__(self, program: dict[str, Any], tol: float, most: int = 200) -> None:
        self.directions, self.heights = np.full((most, 2), np.nan), np.full(most, np.nan)
        self.points = np.full((most, 2), np.nan)
        self.outcome, count, self.gap = trace(
            program["B"], program["b"], program["lorentz"], program["start"], program["G"],
            program["offset"], tol, self.directions, self.heights, self.points,
        )  # fmt: skip
        self.count = count
        self.directions, self.heights = self.directions[:count], self.heights[:count]
        self.points = self.points[:count]


def hull_of(points: np.ndarray, offset: np.ndarray) -> dict[str, Any]:
    """Return the program of the hull of (n, 2) points: shares of one."""
    n = len(points)
    row = np.full((1, n), 1.0 / math.sqrt(n))
    return {
        "B": row, "b": np.array([1.0 / math.sqrt(n)]), "lorentz": 0, "start": np.full(n, 1.0 / n),
        "G": np.ascontiguousarray(points.T), "offset": offset,
    }  # fmt: skip


def disc(radius: float, offset: np.ndarray) -> dict[str, Any]:
    """Return the program of a disc: a cone cut at the height of its radius."""
    return {
        "B": np.array([[1.0, 0.0, 0.0]]), "b": np.array([radius]), "lorentz": 1,
        "start": np.array([radius, 0.0, 0.0]), "G": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        "offset": offset,
    }  # fmt: skip


def support(points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return how far points reach along directions."""
    return np.asarray((directions @ points.T).max(axis=1))


def turns(directions: np.ndarray) -> np.ndarray:
    """Return the angles from each direction to the next."""
    after = np.roll(directions, -1, axis=0)
    cross = directions[:, 0] * after[:, 1] - directions[:, 1] * after[:, 0]
    return np.asarray(np.arctan2(cross, (directions * after).sum(axis=1)))


@pytest.mark.parametrize("seed", range(3))
def test_the_hull_of_points_is_traced(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, offset = rng.normal(size=(6, 2)), rng.normal(size=2)
    found = Outline(hull_of(points, offset), 1e-3)
    moved = points + offset
    assert found.outcome == TRACED
    assert found.gap <= 1e-3
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=1), 1.0, atol=1e-12)
    assert turns(found.directions).min() > 0.0
    assert turns(found.directions).sum() == pytest.approx(2.0 * math.pi)
    exact = support(moved, found.directions)
    assert (found.heights >= exact - 1e-12).all()
    np.testing.assert_allclose(found.heights, exact, atol=1e-4)
    reached = (found.directions * found.points).sum(axis=1)
    np.testing.assert_allclose(reached, exact, atol=1e-4)
    corners = moved[ConvexHull(moved).vertices]
    apart = np.linalg.norm(corners[:, None] - found.points[None], axis=2)
    assert apart.min(axis=1).max() < 1e-3  # every corner is reached


def test_a_square_takes_its_edges_and_no_more() -> None:
    """Corners on the axes: the four first directions reach them, the four normals of the edges prove them."""
    corners = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    found = Outline(hull_of(corners, np.zeros(2)), 1e-3)
    assert found.outcome == TRACED
    assert found.count == 8
    angles = 0.25 * math.pi * np.arange(8)
    np.testing.assert_allclose(found.directions, np.column_stack([np.cos(angles), np.sin(angles)]), atol=1e-4)
    np.testing.assert_allclose(found.heights, np.where(np.arange(8) % 2 == 0, 1.0, math.sqrt(0.5)), atol=1e-4)


@pytest.mark.parametrize(("tol", "count"), [(0.1, 16), (0.01, 64), (1e-3, 128)])
def test_a_disc_takes_as_many_directions_as_its_gap_asks(tol: float, count: int) -> None:
    """Between n even directions corners stand out of the chords by r (1 / cos(π / n) - cos(π / n)).

    For a radius of 1.5 and n of 8, 16, 32, 64 and 128 that is 0.237, 0.058, 0.0145, 0.0036 and 0.0009.
    """
    radius, offset = 1.5, np.array([0.3, -0.2])
    found = Outline(disc(radius, offset), tol)
    assert found.outcome == TRACED
    assert found.gap <= tol
    assert found.count == count
    assert turns(found.directions).max() < 2.0 * math.pi / count + 1e-3
    middle = found.directions @ offset
    assert (found.heights >= middle + radius - 1e-12).all()
    np.testing.assert_allclose(found.heights, middle + radius, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(found.points - offset, axis=1), radius, atol=1e-3)
    half = 0.5 * turns(found.directions)
    standing_out = radius * (1.0 / np.cos(half) - np.cos(half))
    assert found.gap == pytest.approx(standing_out.max(), abs=1e-3)


def test_too_few_directions_are_told_with_the_gap_that_is_left() -> None:
    """A disc of one between eight directions, halved in turn: 1 / cos(π / 8) - cos(π / 8)."""
    found = Outline(disc(1.0, np.zeros(2)), 1e-6, most=8)
    assert found.outcome == OUT_OF_DIRECTIONS
    assert found.count == 8
    assert found.gap == pytest.approx(1.0 / math.cos(math.pi / 8.0) - math.cos(math.pi / 8.0), abs=1e-3)
    first = Outline(disc(1.0, np.zeros(2)), 1e-6, most=4)
    assert first.count == 4
    assert first.gap == pytest.approx(math.sqrt(0.5), abs=1e-3)


def test_a_single_point_needs_the_axes_alone() -> None:
    found = Outline(hull_of(np.tile([0.3, 0.2], (3, 1)), np.array([1.0, 2.0])), 1e-3)
    assert (found.outcome, found.count) == (TRACED, 4)
    np.testing.assert_allclose(found.points, np.tile([1.3, 2.2], (4, 1)), atol=1e-9)
    np.testing.assert_allclose(found.heights, [1.3, 2.2, -1.3, -2.2], atol=1e-4)


def test_a_region_along_a_half_line_has_no_bound() -> None:
    """x - y = 0 of two half-lines: any force with its opposite."""
    program = hull_of(np.array([[1.0, 0.0], [0.0, 1.0]]), np.zeros(2))
    program |= {"B": np.array([[1.0, -1.0]]) / math.sqrt(2.0), "b": np.zeros(1), "start": np.ones(2)}
    found = Outline(program, 1e-3)
    assert (found.outcome, found.count, found.gap) == (WITHOUT_BOUND, 0, math.inf)


def test_forces_of_more_than_a_million_loads_count_as_without_bound() -> None:
    for most, outcome in ((1e5, TRACED), (1e7, WITHOUT_BOUND)):
        program = hull_of(np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]]) / most, np.zeros(2))
        program |= {"b": program["b"] * most, "start": program["start"] * most}
        assert Outline(program, 1e-3).outcome == outcome
