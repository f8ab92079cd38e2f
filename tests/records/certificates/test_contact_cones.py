"""Cones of contacts about a frame: which points touch, how fast they slide, and what their forces do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from surefoot.records.certificates.contact_cones import PointArrays, Rules, gather, room_for
from surefoot.records.certificates.window_kernels import MotionArrays, Window

FRAMES, ARM, CLEARANCE, STICK = 9, 0.3, 0.02, 0.1
RNG = np.random.default_rng(12)
COM = RNG.normal(size=(FRAMES, 3))
WINDOW = Window(2, 2, 2, 0.02)
RULES = Rules(CLEARANCE, STICK, 0.9, 0.4, 0.7, 1.0, False, 30.0, ARM)


def motion() -> MotionArrays:
    none = np.zeros((FRAMES, 1, 3))
    return MotionArrays(
        np.zeros((FRAMES, 1, 3, 3)), none, none, np.zeros((FRAMES, 1, 6)), none, COM,
        np.zeros(1, dtype=np.int64), np.zeros((FRAMES, 1)),
    )  # fmt: skip


def points(count: int = 1, level: bool = True) -> PointArrays:
    """Return points that touch nothing and do not move, on ground that is tilted unless it is level."""
    normals = np.array([[[0.0, 0.0, 1.0]]])
    if not level:
        normals = RNG.normal(size=(FRAMES, count, 3))
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return PointArrays(
        np.arange(count), np.zeros(count, dtype=np.int64), np.linspace(0.5, 1.0, count),
        RNG.normal(size=(FRAMES, count, 3)), np.full((FRAMES, count), 0.5), normals,
        np.zeros((FRAMES - 1, count, 3)),
    )  # fmt: skip


def gathered(own: PointArrays, k: int = 4) -> tuple[int, Any, Any]:
    contacts = room_for(len(own.body))
    count, touch = gather(motion(), own, WINDOW, RULES, k, contacts)
    return count, touch, contacts


def assert_cone(contacts: Any, c: int, point: int, mu: float, axis: Any, place: Any, k: int = 4) -> None:
    """Hold a cone against an axis and a place: a frame of its axes, and the wrenches of their forces."""
    frame, lever = contacts.frames[c], np.asarray(place) - COM[k]
    assert contacts.point[c] == point
    assert contacts.mu[c] == pytest.approx(mu)
    np.testing.assert_allclose(frame[:, 2], np.asarray(axis) / np.linalg.norm(axis), atol=1e-12)
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    np.testing.assert_allclose(contacts.places[c], lever, atol=1e-12)
    moments = np.cross(lever, frame.T) / ARM
    np.testing.assert_allclose(contacts.maps[c, :, :6], np.hstack([frame.T, moments]), atol=1e-12)
    assert not contacts.maps[c, :, 6:].any()


def test_room_is_for_six_rays_a_point_and_twenty_four_torques() -> None:
    contacts = room_for(3)
    assert [array.shape for array in contacts] == [(42,), (42, 3, 3), (42,), (42, 3), (42, 3, 30)]


def test_nothing_touches_beyond_the_clearance() -> None:
    own = points(2)
    own.gaps[4], own.gaps[1] = [0.021, 0.3], -1.0  # frame 1 lies before the window
    count, touch, _ = gathered(own)
    assert (count, touch.points, touch.sliding, touch.slowest) == (0, 0, 0, np.inf)
    assert touch.lowest == pytest.approx(0.021)


@pytest.mark.parametrize("frame", [2, 6])
def test_the_window_has_both_of_its_ends(frame: int) -> None:
    own = points()
    own.gaps[frame] = CLEARANCE
    count, touch, contacts = gathered(own)
    assert (count, touch.points, touch.sliding) == (1, 1, 0)
    assert touch.lowest == CLEARANCE
    assert_cone(contacts, 0, 0, 0.9 * 0.5, [0.0, 0.0, 1.0], own.places[frame, 0])


@pytest.mark.parametrize("frame", [1, 7])
def test_what_touches_beyond_the_window_does_not_count(frame: int) -> None:
    own = points()
    own.gaps[frame] = -0.1
    count, touch, _ = gathered(own)
    assert (count, touch.points) == (0, 0)
    assert touch.lowest == 0.5


def test_a_point_that_sticks_has_a_cone_at_the_mean_of_its_places() -> None:
    own = points(2, level=False)
    own.gaps[[3, 5], 1] = 0.01
    own.slides[2:6, 1] = [0.3, 0.0, 0.0]
    own.slides[4, 1] = [0.0, 0.06, 0.07]  # the slowest of the intervals beside frames 3 and 5
    count, touch, contacts = gathered(own)
    assert (count, touch.points, touch.sliding) == (1, 1, 0)
    assert touch.slowest == pytest.approx(np.hypot(0.06, 0.07))
    # intervals 2 to 5 have an end that touches: the middle one is the third
    assert_cone(contacts, 0, 1, 0.9, own.normals[3, 1], (own.places[3, 1] + own.places[5, 1]) / 2)


def test_points_stick_up_to_a_speed() -> None:
    own = points()
    own.gaps[2:7] = 0.0
    for speed, sliding in ((STICK, 0), (STICK + 1e-6, 1)):
        own.slides[:] = [0.0, 0.0, speed]
        assert gathered(own)[1].sliding == sliding


def test_a_point_that_slides_has_rays_against_three_of_its_ways() -> None:
    own = points(level=False)
    own.gaps[:] = 0.0
    own.slides[:] = RNG.normal(size=own.slides.shape)
    count, touch, contacts = gathered(own)
    assert (count, touch.points, touch.sliding) == (6, 1, 1)
    assert touch.slowest == pytest.approx(np.linalg.norm(own.slides[2:6, 0], axis=1).min())
    normal, place, c = own.normals[3, 0], own.places[2:7, 0].mean(axis=0), 0
    for s in (2, 3, 5):  # of the intervals 2 to 5
        for mu in (0.4, 0.7):
            way = own.slides[s, 0] / np.linalg.norm(own.slides[s, 0])
            assert_cone(contacts, c, 0, 0.0, normal - mu * way, place)
            c += 1


def test_a_way_that_stands_for_two_has_its_rays_once() -> None:
    own = points()
    own.slides[:] = [1.0, 0.0, 0.0]
    own.gaps[2] = 0.0  # one interval touches
    assert gathered(own)[0] == 2
    own.gaps[2], own.gaps[4] = 0.5, 0.0  # two do
    assert gathered(own)[0] == 4
    own.gaps[4], own.gaps[6] = 0.5, 0.0
    assert gathered(own)[0] == 2


def test_frames_of_cones_are_right_handed_whichever_way_they_point() -> None:
    for axis in ([1.0, 0.0, 0.0], [0.81, 0.3, -0.2], [0.79, -0.4, 0.1], [-0.9, 0.1, 0.2], [0.0, -2.0, 0.0]):
        own = points(level=False)
        own.gaps[:] = 0.0
        own.normals[:] = axis
        _, _, contacts = gathered(own)
        assert_cone(contacts, 0, 0, 0.45, axis, own.places[2:7, 0].mean(axis=0))


def test_the_slowest_of_all_points_and_the_lowest_are_told() -> None:
    own = points(3)
    own.gaps[:] = [0.01, -0.02, 0.6]
    own.slides[:] = [[0.5, 0.0, 0.0], [0.0, 0.04, 0.0], [0.0, 0.0, 0.0]]
    count, touch, contacts = gathered(own)
    assert (touch.points, touch.sliding) == (2, 1)
    assert (touch.slowest, touch.lowest) == (pytest.approx(0.04), pytest.approx(-0.02))
    assert contacts.point[:count].tolist() == [0] * 6 + [1]
