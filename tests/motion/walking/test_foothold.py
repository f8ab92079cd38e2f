"""Footholds: the search around edges, and the plane under the feet."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain, StairsTerrain, rough_ground
from surefoot.motion.walking import foothold
from surefoot.motion.walking.feet_settings import FootholdSettings
from surefoot.motion.walking.foothold import choose_foothold
from surefoot.motion.walking.walking_kernels import plane_through, slope_frames


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
@settings(max_examples=30, deadline=None)
def test_the_search_leaves_planes_alone(x: float, y: float) -> None:
    place = np.array([x, y])
    for ground in (FlatTerrain(), SlopeTerrain(20.0)):
        assert choose_foothold(ground, place, 0.08, 0.03) is place


@given(st.floats(-0.2, 3.5))
@settings(max_examples=60, deadline=None)
def test_the_search_keeps_off_edges(x: float) -> None:
    stairs = StairsTerrain(0.1, 0.3)
    chosen = choose_foothold(stairs, np.array([x, 0.0]), 0.08, 0.03)
    risers = stairs.levels()[0][1:-1]
    assert np.abs(chosen[0] - risers).min() >= 0.03 - 1e-9
    assert np.abs(chosen - [x, 0.0]).max() <= 0.08 + 1e-12
    if np.abs(x - risers).min() > 0.031:
        assert chosen == pytest.approx([x, 0.0])


def test_the_search_prefers_level_places_on_bumps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(foothold, "FOOTHOLDS", FootholdSettings(tilt_weight=0.5))
    ground = rough_ground(3, 0.1)
    rng = np.random.default_rng(0)
    places = rng.uniform(-2.0, 2.0, (60, 2))
    chosen = np.array([choose_foothold(ground, p, 0.08, 0.03) for p in places])
    tilt = [np.arccos(ground.normal(p)[..., 2]).mean() for p in (places, chosen)]
    assert tilt[1] < 0.75 * tilt[0]


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))
@settings(max_examples=40, deadline=None)
def test_the_plane_through_feet_on_a_plane_is_that_plane(a: float, b: float, level: float) -> None:
    xy = np.array([[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]]) + np.array([1.0, -2.0])
    feet = np.column_stack([xy, level + xy @ [a, b]])
    about = np.array([1.1, -2.1])
    height, slope_x, slope_y = plane_through(feet, about, 0.0)
    assert (slope_x, slope_y) == pytest.approx((a, b), abs=1e-9)
    assert height == pytest.approx(level + about @ [a, b], abs=1e-9)


def test_feet_in_a_line_say_nothing_about_the_slope_across() -> None:
    feet = np.array([[0.2, 0.0, 0.1], [-0.2, 0.0, 0.0]])
    _, slope_x, slope_y = plane_through(feet, np.zeros(2), 1e-4)
    assert slope_x == pytest.approx(0.25, rel=0.01)
    assert slope_y == pytest.approx(0.0, abs=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))
@settings(max_examples=40, deadline=None)
def test_the_slope_rotation_is_a_rotation_along_the_surface(yaw: float, a: float, b: float) -> None:
    R = slope_frames(np.array([yaw]), np.array([a, b]))[0]
    assert np.allclose(R.T @ R, np.eye(3), rtol=0.0, atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert np.cross(R[:, 2], [-a, -b, 1.0]) == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("rise", [0.12, -0.12])
def test_on_steps_a_foot_is_moved_between_the_edges(rise: float) -> None:
    """As little as possible: away from a riser by the margin, and from one that it came down over by more."""
    stairs, way = StairsTerrain(rise, 0.3), np.array([0.15, 0.0])
    behind = 0.13 if rise < 0.0 else 0.045
    for x in np.linspace(0.01, 0.29, 29):
        place = choose_foothold(stairs, np.array([0.6 + x, 0.1]), 0.08, 0.045, way)
        assert place[1] == pytest.approx(0.1)
        treads = np.clip(x, [behind - 0.3, behind, behind + 0.3], [-0.045, 0.255, 0.555])
        assert abs(place[0] - 0.6 - x) == pytest.approx(np.abs(treads - x).min(), abs=0.006)
        assert np.abs(place[0] - 0.6 - treads).min() < 0.006
    narrow = StairsTerrain(rise, 0.08)
    place = choose_foothold(narrow, np.array([0.17, 0.0]), 0.08, 0.045, way)
    assert place[0] % 0.08 == pytest.approx(0.04, abs=0.011)


def test_without_edges_along_the_way_the_search_is_the_old_one() -> None:
    rough = rough_ground(1, 0.02)
    for place in np.random.default_rng(0).uniform(-1.0, 1.0, (5, 2)):
        along = choose_foothold(rough, place, 0.08, 0.03, np.array([0.1, 0.0]))
        np.testing.assert_array_equal(along, choose_foothold(rough, place, 0.08, 0.03))


def test_a_tread_is_kept_only_if_it_is_not_much_farther() -> None:
    stairs, way = StairsTerrain(0.12, 0.3), np.array([0.15, 0.0])
    place, last = np.array([0.29, 0.0]), np.array([0.39, 0.0])  # 1 cm before an edge, and beyond it
    for before, more, moved in (
        (None, 1.0, -0.035),
        (last, 1.0, 0.055),
        (last, 0.03, 0.055),
        (last, 0.01, -0.035),
    ):
        chosen = choose_foothold(stairs, place, 0.08, 0.045, way, before, more)
        assert chosen[0] - place[0] == pytest.approx(moved, abs=0.006)
