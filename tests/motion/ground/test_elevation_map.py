"""The height map: its compiled loops against plain NumPy and SciPy, and what it believes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from surefoot.base.errors import ProblemError
from surefoot.motion.ground import elevation_kernels as kernels
from surefoot.motion.ground.elevation_map import ElevationMap, MapSettings

Array = NDArray[np.float64]
SEEDS = range(3)


@pytest.mark.parametrize("seed", SEEDS)
def test_unknown_cells_take_the_lowest_nearby_or_the_plane(seed: int) -> None:
    rng = np.random.default_rng(seed)
    heights, known = rng.normal(size=(30, 30)), rng.random((30, 30)) < 0.15
    known[:12] = False
    variances, out = np.where(known, 1e-4, np.inf), np.empty((30, 30))
    kernels.fill_unknown(heights, variances, 5.0, 0.1, -0.2, out)
    i, j = np.indices(known.shape)
    for a in range(30):
        for b in range(30):
            rings = np.maximum(abs(i - a), abs(j - b))
            if known[a, b]:
                wanted = float(np.median(heights[known & (rings <= 1)]))
            else:
                nearest = int(rings[known].min())
                plane = 5.0 + 0.1 * a - 0.2 * b
                ring = known & (rings == nearest)
                off = heights - (5.0 + 0.1 * i - 0.2 * j)
                wanted = plane + (float(off[ring].min()) if nearest <= kernels.REACH else 0.0)
            assert out[a, b] == pytest.approx(wanted)


@pytest.mark.parametrize("seed", SEEDS)
def test_heights_between_cells_are_bilinear(seed: int) -> None:
    rng = np.random.default_rng(seed)
    filled, corner = rng.normal(size=(8, 8)), rng.normal(size=2)
    places = corner + rng.uniform(-0.2, 1.0, (50, 2))
    axes = [corner[k] + 0.1 * np.arange(8) for k in range(2)]
    inside = np.clip(places, corner, corner + 0.7)
    wanted = RegularGridInterpolator(axes, filled, bounds_error=False, fill_value=None)(inside)
    out = kernels.bilinear(filled, corner, 0.1, places)
    assert out == pytest.approx(wanted)
    assert np.isnan(kernels.bilinear(filled, corner, 0.1, np.array([[np.nan, 0.0]]))).all()


def seen(rng: np.random.Generator, heights: object, count: int = 4000, noise: float = 0.005) -> Array:
    """Return points within 0.9 m on a ground, with noise."""
    xy = rng.uniform(-0.9, 0.9, (count, 2))
    return np.column_stack([xy, heights(xy) + noise * rng.normal(size=count)])  # type: ignore[operator]


def slope(xy: Array) -> Array:
    return np.asarray(0.36 * xy[:, 0])


def step(xy: Array) -> Array:
    return 0.12 * (xy[:, 0] > 0.3)


def test_a_slope_is_seen_with_its_normal() -> None:
    rng, ground = np.random.default_rng(1), ElevationMap()
    for _ in range(10):
        ground.see(seen(rng, slope), np.full(4000, 2.5e-5))
    places = rng.uniform(-0.7, 0.7, (200, 2))
    assert np.abs(ground.height(places) - slope(places)).max() < 0.01
    off = ground.gradient(places) - [0.36, 0.0]
    assert np.abs(off).max() < 0.1
    assert np.abs(off.mean(axis=0)).max() < 0.02  # the ridge's share


def test_an_edge_stays_an_edge_and_its_sides_stay_level() -> None:
    rng, ground = np.random.default_rng(2), ElevationMap()
    for _ in range(10):
        ground.see(seen(rng, step), np.full(4000, 2.5e-5))
    for x in (0.0, 0.2, 0.26, 0.34, 0.5):
        assert ground.height([x, 0.1]) == pytest.approx(0.12 * (x > 0.3), abs=0.012)
        assert np.abs(ground.gradient([x, 0.1])).max() < 0.12
    assert ground.height([0.4, 0.0]) - ground.height([0.2, 0.0]) > 0.1


def test_one_stray_point_does_nothing_and_a_changed_ground_is_believed() -> None:
    ground = ElevationMap()
    level, raised = np.array([[0.2, 0.2, 0.0]]), np.array([[0.2, 0.2, 0.1]])
    for _ in range(20):
        ground.see(level, np.array([1e-4]))
    ground.see(raised, np.array([1e-4]))
    assert ground.height([0.2, 0.2]) == pytest.approx(0.0, abs=0.003)
    for _ in range(4):
        ground.see(raised, np.array([1e-4]))
    assert ground.height([0.2, 0.2]) == pytest.approx(0.1, abs=0.02)


def test_feet_move_a_map_that_is_too_high() -> None:
    rng, ground = np.random.default_rng(3), ElevationMap()
    for _ in range(5):
        ground.see(seen(rng, lambda xy: np.full(len(xy), 0.015)), np.full(4000, 2.5e-5))
    for k in range(30):
        ground.touch(np.array([0.02 * k, 0.1, 0.0]))
    assert ground.height([-0.3, -0.3]) == pytest.approx(0.0, abs=0.003)
    before = ground.offset
    ground.touch(np.array([0.0, -0.5, -0.12]))  # it stands in a hole that the map does not show
    assert ground.offset == before


def test_the_map_moves_with_the_robot_and_forgets_what_it_leaves() -> None:
    ground = ElevationMap()
    for _ in range(3):
        ground.see(np.array([[0.2, 0.0, 0.3], [-1.1, 0.0, 0.3]]), np.full(2, 1e-4))
    ground.move([0.5, 0.0])
    assert ground.height([0.2, 0.0]) == pytest.approx(0.3)
    assert np.isfinite(ground.variance([0.2, 0.0]))
    ground.move([0.0, 0.0])
    assert np.isinf(ground.variance([-1.1, 0.0]))
    ground.move([50.0, 0.0])
    assert np.isinf(ground.variance([50.0, 0.0]))


def test_nothing_known_is_the_plane_under_the_feet() -> None:
    ground = ElevationMap(MapSettings(half=0.5))
    ground.begin([1.0, 2.0], 0.4, [0.1, 0.2])
    assert ground.height([[1.0, 2.0], [1.2, 1.9]]) == pytest.approx([0.4, 0.4 + 0.02 - 0.02])


@pytest.mark.parametrize("wrong", [{"spacing": 0.0}, {"half": 0.01}, {"gate": np.nan}, {"anchor": -1.0}])
def test_wrong_settings_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ProblemError, match=next(iter(wrong))):
        MapSettings(**wrong)  # type: ignore[arg-type]


def test_a_stray_point_in_the_dark_digs_no_hole() -> None:
    ground, x = ElevationMap(), np.linspace(0.2, 0.5, 300)
    for _ in range(3):
        ground.see(np.column_stack([x, 0.0 * x, 0.0 * x]), np.full(300, 1e-4))
    ground.see(np.array([[0.6, 0.0, -0.9]]), np.full(1, 1e-4))
    assert np.isinf(ground.variance([0.6, 0.0]))
    assert ground.height([0.6, 0.0]) == pytest.approx(0.0, abs=1e-3)
    ground.see(np.array([[0.6, 0.0, -0.1]]), np.full(1, 1e-4))  # takes the stray one's place
    ground.see(np.array([[0.6, 0.0, -0.1]]), np.full(1, 1e-4))
    assert ground.height([0.6, 0.0]) == pytest.approx(-0.1, abs=0.01)
    ground.touch(np.array([0.1, 0.3, 0.05]))  # a foot is believed at once
    ground.refresh()
    assert np.isfinite(ground.variance([0.1, 0.3]))
