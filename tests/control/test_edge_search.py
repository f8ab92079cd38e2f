"""Feet that slide to the edges of steps down: a robot of points that goes where it is told to."""

from __future__ import annotations

import math

import numpy as np
import pytest

from surefoot.arrays import FloatArray
from surefoot.control.edge_search import EdgeSearch, inwards, moved_inside, to_diagonal

RADIUS, HEIGHT, DT, FASTEST = 0.022, 0.3, 1e-3, 0.3
STANDS = np.array([[0.15, 0.18, -0.12], [0.26, -0.06, -0.12], [-0.09, 0.25, 0.0], [-0.29, -0.15, 0.0]])
ONE_BEYOND = np.array([[0.09, 0.18, -0.12], [-0.06, -0.06, 0.0], [-0.35, 0.25, 0.0], [-0.29, -0.15, 0.0]])
ALONG = np.array([1.0, 0.0])


def ground(x: float, edges: tuple[float, ...]) -> float:
    """Return how low a sole is at x over edges of steps of 12 cm: a sphere on a corner sinks first."""
    level = -0.12 * sum(x > e for e in edges)
    for edge in edges:
        if 0.0 < x - edge < RADIUS:
            level = max(
                level, -0.12 * sum(edge > e for e in edges) - RADIUS + math.sqrt(RADIUS**2 - (x - edge) ** 2)
            )
    return level


def searched(
    edges: tuple[float, ...], drift: float = 0.0, reach: float = math.inf, stands: FloatArray = STANDS
) -> EdgeSearch:
    """Return a finished search; the estimated height drifts [m/s], legs reach so far forward [m]."""
    search = EdgeSearch(ALONG, (-0.03, 0.07), 0.12, HEIGHT, RADIUS)
    stands, carrying, com = stands.copy(), np.ones(4, dtype=bool), np.array([0.06, 0.07, 0.25])
    soles, flow = stands.copy(), np.zeros(3)
    for k in range(12000):
        off = np.array([0.0, 0.0, drift * k * DT])
        search.update(k * DT, com + off, flow, stands + off, soles + off, carrying)
        if search.done or search.failed:
            return search
        flow[:2] += 0.01 * (search.shift - flow[:2])
        com = com + DT * flow
        if search.probe is None:
            continue
        foot, place, _, down = search.probe
        move = place - off - soles[foot]
        move[:2] = np.clip(move[:2], -FASTEST * DT, FASTEST * DT)  # its tread holds it back
        soles[foot] += move
        soles[foot, 0] = min(soles[foot, 0], com[0] + reach)
        floor = ground(float(soles[foot, 0]), edges) + max(soles[foot, 0] - com[0] - reach + 0.02, 0.0)
        soles[foot, 2] = max(soles[foot, 2], floor)
        carrying[foot] = down and soles[foot, 2] <= floor + 1e-4
        if carrying[foot]:
            stands[foot] = soles[foot]
    raise AssertionError("the search does not end")


def test_a_triangle_has_its_inside_and_the_nearest_place_within() -> None:
    triangle = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    for corners in (triangle, triangle[::-1]):
        normals, offsets = inwards(corners)
        assert (normals @ [0.3, 0.3] > offsets).all()
        assert not (normals @ [0.6, 0.6] > offsets).all()
        assert moved_inside(corners, np.array([0.3, -0.2]), 0.1) == pytest.approx([0.3, 0.1])
        assert moved_inside(corners, np.array([0.3, 0.3]), 0.1) == pytest.approx([0.3, 0.3])


@pytest.mark.parametrize("edges", [(0.0, 0.3, 0.6), (0.02, 0.37, 0.72), (-0.02, 0.28, 0.58)])
@pytest.mark.parametrize("drift", [0.0, -0.004])
def test_both_edges_are_found(edges: tuple[float, ...], drift: float) -> None:
    search = searched(edges, drift)
    assert search.done
    assert search.edges == pytest.approx(edges[:2], abs=0.008)
    assert search.probe is None


@pytest.mark.parametrize("edges", [(0.0, 0.3, 0.6), (-0.02, 0.26, 0.54)])
def test_one_front_foot_beyond_is_joined_by_the_other(edges: tuple[float, ...]) -> None:
    search = searched(edges, stands=ONE_BEYOND)
    assert search.done
    assert search.edges == pytest.approx(edges[:2], abs=0.008)


def test_a_foot_that_slides_off_stands_beyond() -> None:
    search, stands = EdgeSearch(ALONG, (-0.03, 0.07), 0.12, HEIGHT, RADIUS), ONE_BEYOND.copy()
    com, far = np.array([-0.05, 0.05, 0.25]), np.array([0.4, 0.0, 0.0])
    search.update(0.0, com, far, stands, stands, np.ones(4, dtype=bool))
    stands[1] = [0.08, -0.06, -0.12]
    for k in range(1, 1000):
        search.update(k * DT, com, np.zeros(3), stands, stands, np.ones(4, dtype=bool))
        com = com + DT * np.array([*search.shift, 0.0])
        if search.probe is not None:
            break
    assert search.probe is not None
    assert search.probe.foot in (2, 3)  # both front feet are down: a hind foot finds the first edge


def test_feet_that_are_all_on_one_level_find_nothing() -> None:
    search, flat = EdgeSearch(ALONG, (-0.03, 0.07), 0.12, HEIGHT, RADIUS), STANDS * [1.0, 1.0, 0.0]
    for k in range(6000):
        search.update(k * DT, np.array([0.0, 0.05, 0.25]), np.zeros(3), flat, flat, np.ones(4, dtype=bool))
        if search.failed:
            break
    assert search.failed
    assert not search.done


def test_the_walk_goes_on_from_the_line_between_the_feet_ahead() -> None:
    search = searched((0.0, 0.3, 0.6))
    soles = np.array([[0.15, 0.18], [0.26, -0.06], [-0.09, 0.25], [-0.29, -0.15]])
    assert search.leading in (0, 1)
    for leading, feet in ((0, (1, 2)), (3, (1, 2)), (1, (0, 3)), (2, (0, 3))):
        way = to_diagonal(soles.mean(axis=0), soles, leading)
        line = soles[feet[1]] - soles[feet[0]]
        assert float(way @ line) == pytest.approx(0.0, abs=1e-12)
        place = soles.mean(axis=0) + way - soles[feet[0]]
        assert float(place[0] * line[1] - place[1] * line[0]) == pytest.approx(0.0, abs=1e-12)


def test_a_tread_without_an_end_within_reach_is_a_step() -> None:
    search = searched((0.0, 3.0), reach=0.36)
    assert search.done
    assert search.edges[0] == pytest.approx(0.0, abs=0.008)
    assert math.isnan(search.edges[1])


def test_without_a_first_edge_it_has_failed() -> None:
    search = searched((0.6, 0.9), reach=0.28)
    assert search.failed
    assert not search.done


def test_a_body_that_cannot_come_to_rest_ends_it() -> None:
    search = EdgeSearch(ALONG, (-0.03, 0.07), 0.12, HEIGHT, RADIUS)
    for k in range(2000):
        search.update(
            k * DT,
            np.array([0.06, 0.07, 0.25]),
            np.array([0.5, 0.0, 0.0]),
            STANDS,
            STANDS,
            np.ones(4, dtype=bool),
        )
    assert search.failed
    assert search.probe is None
