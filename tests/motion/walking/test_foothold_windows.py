"""Footholds between edges and on bumps, by hand: windows on treads, least moves, level places, catching."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from surefoot.mechanics.terrain import Terrain
from surefoot.motion.walking.foothold import (
    catching_place,
    choose_foothold,
    nearest_shift,
    step_place,
    step_windows,
)

X, Y = np.array([1.0, 0.0]), np.array([0.0, 1.0])
INF = math.inf


class Treads(Terrain):
    """Levels between edges along a direction."""

    def __init__(
        self, edges: list[float], levels: list[float], along: np.ndarray = X, noise: float = 0.0,
        learns: bool = False,
    ) -> None:  # fmt: skip
        self._edges, self._levels, self._along = np.array(edges), np.array(levels), along
        self.noise = noise
        vars(self)["learns"] = learns

    def height(self, xy: Any) -> Any:
        return self._levels[np.searchsorted(self._edges, np.asarray(xy) @ self._along, side="right")]


class Post(Terrain):
    """Level ground with a post of 6 mm."""

    def __init__(self, x: float, y: float, height: float = 0.1) -> None:
        self._place, self._height = np.array([x, y]), height

    def height(self, xy: Any) -> Any:
        return self._height * (np.linalg.norm(np.asarray(xy) - self._place, axis=-1) < 3e-3)


@pytest.mark.parametrize("along", [X, Y, -X])
@pytest.mark.parametrize("where", [0.0, 0.7])
def test_a_step_up_keeps_the_margin_on_both_sides(along: np.ndarray, where: float) -> None:
    ground = Treads([where + 0.1025], [0.0, 0.1], along)
    windows = step_windows(ground, where * along, along, 0.04)
    assert windows is not None
    np.testing.assert_allclose(windows, [[-INF, 0.1425], [0.0625, INF]], atol=1e-12)


@pytest.mark.parametrize(
    ("margin", "learns", "behind"), [(0.04, False, 0.13), (0.04, True, 0.14), (0.2, False, 0.2)]
)
def test_a_step_down_keeps_the_shin_off_the_edge_behind(margin: float, learns: bool, behind: float) -> None:
    windows = step_windows(Treads([-0.0525], [0.1, 0.0], learns=learns), np.zeros(2), X, margin)
    assert windows is not None
    np.testing.assert_allclose(windows, [[-INF, behind - 0.0525], [-0.0525 - margin, INF]], atol=1e-12)


@pytest.mark.parametrize(
    ("levels", "edges", "low", "high"),
    [
        ([0.0, 0.1, 0.2], [0.0525, 0.2025], 0.0925, 0.1625),  # long enough
        ([0.0, 0.1, 0.2], [0.0525, 0.1025], 0.0775, 0.0775),  # too short going up: in its middle
        (
            [0.2, 0.1, 0.0],
            [0.0525, 0.2025],
            0.1625,
            0.1625,
        ),  # going down: as far out as the next edge lets it
        ([0.2, 0.1, 0.0], [0.0525, 0.1025], 0.0775, 0.0775),
    ],
)
def test_a_tread_has_a_window_or_a_place(
    levels: list[float], edges: list[float], low: float, high: float
) -> None:
    windows = step_windows(Treads(edges, levels), np.zeros(2), X, 0.04)
    assert windows is not None
    assert [len(side) for side in windows] == [3, 3]
    assert (windows[0][1], windows[1][1]) == pytest.approx((low, high))


@pytest.mark.parametrize(
    ("jump", "noise", "found"),
    [
        (0.029, 0.0, False), (0.031, 0.0, True), (-0.031, 0.0, True), (-0.029, 0.0, False),
        (0.039, 0.02, False), (0.041, 0.02, True),
    ],
)  # fmt: skip
def test_a_step_is_three_centimetres_and_twice_the_noise(jump: float, noise: float, found: bool) -> None:
    windows = step_windows(Treads([0.1025], [0.0, jump], noise=noise), np.zeros(2), X, 0.04)
    assert (windows is not None) is found


def test_edges_are_looked_for_within_thirty_centimetres() -> None:
    for edge, found in ((0.2975, True), (0.3025, False), (-0.2975, True), (-0.3025, False)):
        assert (step_windows(Treads([edge], [0.0, 0.1]), np.zeros(2), X, 0.04) is not None) is found
    ways = np.arange(-1.0, 1.0, 0.01)
    assert step_windows(Treads([0.6], [0.0, 0.1]), np.zeros(2), X, 0.04, ways) is not None


def test_the_least_move_into_any_window() -> None:
    windows = np.array([-INF, 0.1, 0.5]), np.array([-0.04, 0.3, INF])
    for ahead, move in (
        (-1.0, 0.0), (-0.03, -0.01), (0.029, -0.069), (0.031, 0.069), (0.2, 0.0), (0.39, -0.09), (0.41, 0.09),
        (9.0, 0.0),
    ):  # fmt: skip
        assert nearest_shift(windows, np.array([ahead])) == pytest.approx([move])


def test_a_foot_moves_along_its_way_whatever_that_s_length() -> None:
    ground, place = Treads([0.1025], [0.0, 0.1]), np.array([0.08, 0.3])
    for way in ([0.5, 0.0], [2e-6, 0.0]):
        chosen = choose_foothold(ground, place, 0.08, 0.04, np.array(way))
        np.testing.assert_allclose(chosen, [0.0625, 0.3], atol=3e-3)


def test_a_foot_that_would_move_too_far_looks_for_a_level_place() -> None:
    """Down by a step with its edge 4 cm behind: 9 cm on is near, with a margin of 20 cm it is too far."""
    ground, place = Treads([-0.0425], [0.1, 0.0]), np.zeros(2)
    near = choose_foothold(ground, place, 0.08, 0.04, X)
    np.testing.assert_allclose(near, [-0.0825, 0.0], atol=3e-3)
    far = choose_foothold(Treads([0.0], [0.0, 0.1]), np.array([0.0025, 0.0]), 0.08, 0.2, X)
    assert far[0] % 0.02 == pytest.approx(0.0025)  # a place of the grid about it, not one along the way


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_level_places_are_sought_every_two_centimetres_ahead_and_four_aside(side: float) -> None:
    for along, moved in ((X, [-0.02 * side, 0.0]), (Y, [0.0, -0.04 * side])):
        ground = Treads([0.015], [0.0, 0.1], along * side)
        chosen = choose_foothold(ground, np.zeros(2), 0.08, 0.03)
        np.testing.assert_allclose(chosen, moved, atol=1e-12)


@pytest.mark.parametrize(("noise", "moved"), [(0.0955, -0.02), (0.096, 0.0), (0.0, -0.02), (0.2, 0.0)])
def test_a_move_costs_its_way_and_an_edge_its_height_beyond_the_noise(noise: float, moved: float) -> None:
    """2 cm of way against 3 + 0.05 / 0.03 = 4.67 times the height: 4.29 mm."""
    ground = Treads([0.015], [0.0, 0.1], noise=noise)
    np.testing.assert_allclose(choose_foothold(ground, np.zeros(2), 0.08, 0.03), [moved, 0.0], atol=1e-12)


@pytest.mark.parametrize(("height", "moved"), [(0.0044, True), (0.0042, False), (-0.0044, True)])
def test_a_post_under_a_foot_is_an_edge_too(height: float, moved: bool) -> None:
    chosen = choose_foothold(Post(0.0, 0.0, height), np.zeros(2), 0.08, 0.03)
    assert bool(chosen.any()) is moved


@pytest.mark.parametrize("eighth", range(8))
def test_the_ground_is_felt_in_eight_directions_at_the_margin(eighth: int) -> None:
    angle = eighth * math.pi / 4.0
    around = Post(0.03 * math.cos(angle), 0.03 * math.sin(angle))
    assert choose_foothold(around, np.zeros(2), 0.08, 0.03).any()
    between = Post(0.03 * math.cos(angle + math.pi / 8.0), 0.03 * math.sin(angle + math.pi / 8.0))
    assert not choose_foothold(between, np.zeros(2), 0.08, 0.03).any()


PENDULUM = math.sqrt(0.3 / 9.81)


@pytest.mark.parametrize(
    ("speed", "wanted", "ahead"),
    [
        (0.2, 0.0, 0.05 * 0.2 + PENDULUM * 0.2), (0.2, 0.1, 0.05 * 0.2 + PENDULUM * 0.1),
        (0.2, 0.3, 0.05 * 0.2),
        (0.2, -1.0, 0.05 * 0.2 + PENDULUM * 0.2), (-0.2, -0.1, -0.05 * 0.2 - PENDULUM * 0.1),
        (-0.2, -0.3, -0.05 * 0.2), (-0.2, 1.0, -0.05 * 0.2 - PENDULUM * 0.2),
    ],
)  # fmt: skip
@pytest.mark.parametrize("quarter", [0, 1, 2, 3])
def test_a_catching_foot_stands_where_a_pendulum_comes_to_its_speed(
    speed: float, wanted: float, ahead: float, quarter: int
) -> None:
    """Half the way of the stance and the capture point's offset, from where the hip is at touchdown."""
    yaw = quarter * math.pi / 2.0
    R = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    com, left, arm = np.array([1.0, 2.0, 0.3]), 0.1, np.array([0.2, 0.1])
    for axis, way in ((0, [ahead + left * speed, 0.0]), (1, [0.0, ahead + left * speed])):
        v, velocity = np.zeros(3), np.zeros(3)
        v[:2], velocity[axis] = speed * R[:, axis], wanted
        place = catching_place(com, v, arm, yaw, velocity, left, 0.3, 0.1)
        np.testing.assert_allclose(place, com[:2] + R @ (arm + way), atol=1e-12)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_catching_foot_stays_on_its_side_and_within_reach(side: float) -> None:
    """Reach is 0.8 of a height of 0.3 m, and the least distance from the middle 0.35 of the usual one."""
    arm, zero = np.array([0.2, 0.1 * side]), np.zeros(3)
    inwards = catching_place(zero, np.array([0.0, -2.0 * side, 0.0]), arm, 0.0, zero, 0.0, 0.3, 0.1)
    np.testing.assert_allclose(inwards, [0.2, 0.035 * side], atol=1e-12)
    fast = np.array([3.0, 4.0 * side, 0.0])
    outwards = catching_place(zero, fast, arm, 0.0, zero, 0.0, 0.3, 0.1)
    np.testing.assert_allclose(outwards, [0.2 + 0.6 * 0.24, side * (0.1 + 0.8 * 0.24)], atol=1e-12)
    later = catching_place(zero, fast, arm, 0.0, zero, 0.05, 0.3, 0.1)
    np.testing.assert_allclose(later - outwards, [0.15, 0.2 * side], atol=1e-12)


def test_a_turning_body_steps_ahead_of_its_turn() -> None:
    """By hand: the hip turned by 0.3 + 0.5 x 0.2, half of a stance's turn, and the swerve by half of h/g."""
    com, v = np.array([1.0, 2.0, 0.3]), np.array([0.4, -0.1, 0.0])
    arm, velocity, left, stance = np.array([0.2, 0.1]), np.array([0.5, 0.1, 0.5]), 0.2, 0.3
    yaw = 0.3 + 0.5 * left
    R = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    wanted, hip = R @ velocity[:2], R @ arm
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    expected = com[:2] + left * wanted + hip + 0.5 * stance * wanted + PENDULUM * (v[:2] - wanted)
    expected = expected - 0.5 * PENDULUM**2 * 0.5 * (quarter @ wanted) + 0.5 * stance * 0.5 * (quarter @ hip)
    place = step_place(com, v, arm, 0.3, velocity, left, 0.3, stance)
    np.testing.assert_allclose(place, expected, atol=1e-12)
