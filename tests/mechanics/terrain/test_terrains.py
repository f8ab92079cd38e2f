"""Every terrain: normals are unit and agree with the slope of the height; gaps on planes are exact."""

import math

import numpy as np
import pytest

from surefoot import FlatTerrain, ProblemError, SlopeTerrain, StairsTerrain
from surefoot.mechanics.terrain import HeightfieldTerrain, rough_ground


@pytest.mark.parametrize("ground", [FlatTerrain(), SlopeTerrain(30.0)])
def test_gap_is_the_distance_to_a_plane(ground):
    rng = np.random.default_rng(1)
    places, above = rng.normal(size=(50, 2)), rng.normal(size=50)
    feet = np.column_stack([places, ground.height(places)]) + above[:, None] * ground.normal(places)
    np.testing.assert_allclose(ground.gap(feet), above, atol=1e-12)


def test_slope_rises_along_x():
    assert SlopeTerrain(30.0).height([1.0, 5.0]) == pytest.approx(math.tan(math.radians(30.0)))
    R = SlopeTerrain(30.0).frame([0, 0])
    assert R[2, 0] == pytest.approx(0.5)  # the frame's x axis climbs


def test_stairs():
    stairs = StairsTerrain(rise=0.2, tread=0.3, steps=4)
    x = np.array([-1.0, -1e-9, 0.0, 0.299, 0.3, 0.9, 1.19, 7.0])
    expected = 0.2 * np.array([0, 0, 1, 1, 2, 4, 4, 4])
    np.testing.assert_allclose(stairs.height(np.column_stack([x, 0 * x])), expected, atol=1e-12)
    np.testing.assert_array_equal(stairs.normal(np.zeros((3, 2))), np.tile([0, 0, 1.0], (3, 1)))
    assert stairs.gap([0.4, 0, 0.5]) == pytest.approx(0.1)
    assert StairsTerrain(rise=-0.1).height([0.1, 0.0]) == pytest.approx(-0.1)


def test_heightfield_goes_through_its_points_and_is_smooth():
    rng = np.random.default_rng(2)
    heights = rng.normal(size=(6, 5))
    ground = HeightfieldTerrain(heights, 0.5, origin=[1.0, -2.0])
    i, j = np.meshgrid(np.arange(6), np.arange(5), indexing="ij")
    places = np.stack([1.0 + 0.5 * i, -2.0 + 0.5 * j], axis=-1)
    np.testing.assert_allclose(ground.height(places), heights, atol=1e-12)
    for edge in (places[3, 2], places[2, 1]):  # normals do not jump where cells meet
        left, right = ground.normal(edge - 1e-9), ground.normal(edge + 1e-9)
        np.testing.assert_allclose(left, right, atol=1e-6)
    assert ground.height([99.0, -2.0]) == pytest.approx(heights[-1, 0])
    np.testing.assert_array_equal(ground.normal([99.0, 99.0]), [0, 0, 1])


def test_heightfield_of_a_plane_is_the_plane():
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    ground = HeightfieldTerrain(0.3 * x - 0.2 * y + 1.0, 0.25)
    places = np.random.default_rng(3).uniform(-0.99, 0.99, size=(200, 2))
    np.testing.assert_allclose(
        ground.height(places), 0.3 * places[:, 0] - 0.2 * places[:, 1] + 1.0, atol=1e-12
    )


def test_rough_ground_is_seeded():
    places = np.random.default_rng(4).uniform(-1, 1, size=(50, 2))
    np.testing.assert_array_equal(rough_ground(3, 0.08).height(places), rough_ground(3, 0.08).height(places))
    assert np.abs(rough_ground(4, 0.08).height(places) - rough_ground(3, 0.08).height(places)).max() > 0.01


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: StairsTerrain(tread=0.0), "tread"),
        (lambda: StairsTerrain(steps=0), "steps"),
        (lambda: StairsTerrain(rise=math.nan), "rise"),
        (lambda: HeightfieldTerrain([[1.0]], 0.1), "2 x 2"),
        (lambda: HeightfieldTerrain([[1.0, math.nan], [0, 0]], 0.1), "heights"),
        (lambda: HeightfieldTerrain(np.zeros((3, 3)), 0.0), "spacing"),
    ],
)
def test_bad_terrains_are_named(make, message):
    with pytest.raises(ProblemError, match=message):
        make()
