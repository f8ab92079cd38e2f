"""What a search for a region returns: hulls and discs, a region without bound, and none at all."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from surefoot.mechanics.statics.region import polygon_area
from surefoot.mechanics.statics.region_search import OutlineProgram, RegionOutline, search_certified

TRIANGLE = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])


def hull_of(points: np.ndarray) -> OutlineProgram:
    """Return the program of the hull of (n, 2) points about (2, 1): shares of one, told twice."""
    n = len(points)
    A = np.vstack([np.ones(n), 3.0 * np.ones(n)])
    start, offset = np.full(n, 1.0 / n), np.array([2.0, 1.0])
    return OutlineProgram(
        A, np.array([1.0, 3.0]), np.ones(n), 0, np.ascontiguousarray(points.T), offset, start
    )


def disc(radius: float) -> OutlineProgram:
    """Return the program of a disc: a cone cut at the height of its radius."""
    A, G = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    return OutlineProgram(
        A, np.array([radius]), np.array([1.0, 0.0, 0.0]), 1, G, np.zeros(2), np.array([radius, 0.0, 0.0])
    )


@pytest.mark.parametrize("tol", [0.1, 1e-2, 1e-3])
def test_a_hull_is_found_to_its_corners(tol: float) -> None:
    found = search_certified(hull_of(TRIANGLE), None, tol)
    assert 0.0 <= found.gap <= tol
    assert not found.unbounded
    expected = TRIANGLE + np.array([2.0, 1.0])
    order = np.lexsort(np.round(found.inner, 3).T)
    np.testing.assert_allclose(found.inner[order], expected[np.lexsort(expected.T)], atol=1e-5)
    assert (found.directions @ expected.T <= found.heights[:, None] + 1e-12).all()


@pytest.mark.parametrize("tol", [0.05, 5e-3])
def test_a_disc_is_enclosed_to_the_gap_that_is_stated(tol: float) -> None:
    found = search_certified(disc(1.0), None, tol)
    assert found.gap <= tol
    assert np.linalg.norm(found.inner, axis=1) == pytest.approx(1.0, abs=1e-4)
    assert math.pi - 2.0 * math.pi * tol < polygon_area(found.inner) < math.pi
    assert (found.heights >= 1.0 - 1e-12).all()


def test_a_wider_program_adds_nothing_to_what_is_good_enough() -> None:
    alone = search_certified(disc(1.0), None, 1e-2)
    both = search_certified(disc(1.0), disc(1.001), 1e-2)
    assert both.gap == pytest.approx(alone.gap)
    assert len(both.heights) == len(alone.heights)


def test_a_program_without_bound_is_told() -> None:
    """Two half-lines of one value: any amount of both."""
    program = replace(
        hull_of(TRIANGLE[:2]), A=np.array([[1.0, -1.0]]), w=np.zeros(1), start=np.array([1.0, 1.0])
    )
    found = search_certified(program, None, 1e-3)
    assert found.unbounded
    assert found.gap == math.inf
    assert found.inner.shape == (0, 2)


def test_no_polygon_is_an_outline_of_nothing() -> None:
    for gap, unbounded in ((0.0, False), (math.inf, True)):
        nothing = RegionOutline.nothing(gap, unbounded)
        assert (nothing.gap, nothing.unbounded) == (gap, unbounded)
        shapes = nothing.inner.shape, nothing.directions.shape, nothing.heights.shape
        assert shapes == ((0, 2), (0, 2), (0,))
    assert not RegionOutline.nothing(0.0).unbounded


@pytest.mark.parametrize(("tol", "converged"), [(0.2, True), (0.1, True), (0.09, False)])
def test_a_region_has_converged_within_its_tolerance(tol: float, converged: bool) -> None:
    outline = RegionOutline(TRIANGLE, np.eye(2), np.ones(2), 0.1)
    axis = np.array([0.1, 0.0, 1.0])
    region = outline.region(0.3, axis, tol, 500.0)
    assert region.converged is converged
    assert (region.gap, region.height, region.force_limit) == (0.1, 0.3, 500.0)
    np.testing.assert_array_equal(region.axis, axis)
    np.testing.assert_array_equal(region.inner, TRIANGLE)
    assert outline.region(0.3, axis, tol).force_limit == math.inf
