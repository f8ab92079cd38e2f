"""Stairs in heights along a way: found where they are, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.mechanics.terrain import FlatTerrain, StairsTerrain, Terrain, read_terrain
from surefoot.motion.ground.ground_settings import STAIR_DETECTION
from surefoot.motion.ground.stair_detection import FINE, StairWatch, find_edges, find_stairs
from surefoot.motion.ground.stair_fit import StairSteps

WAYS = np.arange(-1.0, 1.1, FINE)


def _blurred(heights: np.ndarray, cells: int, noise: float, seed: int = 0) -> np.ndarray:
    """Return heights as a map has them: means over some samples, with noise."""
    kernel = np.ones(cells) / cells
    padded = np.pad(heights, cells, mode="edge")
    rng = np.random.default_rng(seed)
    return np.convolve(padded, kernel, mode="same")[cells:-cells] + rng.normal(0.0, noise, len(heights))


@pytest.mark.parametrize("rise", [0.08, 0.12, 0.17, -0.08, -0.12, -0.17])
@pytest.mark.parametrize("tread", [0.22, 0.3, 0.45])
@pytest.mark.parametrize("seed", range(3))
def test_stairs_are_found_in_a_blurred_and_noisy_map(rise: float, tread: float, seed: int) -> None:
    stairs = StairsTerrain(rise, tread)
    heights = stairs.height(np.column_stack([0.2 * tread * seed + WAYS, 0.0 * WAYS]))
    flight = find_stairs(_blurred(heights, 3, 0.002, seed))
    assert flight is not None
    found = flight.steps
    assert found.rise == pytest.approx(rise, abs=0.01)
    assert found.tread == pytest.approx(tread, abs=0.02)
    edges = (WAYS[0] + 0.2 * tread * seed + flight.begin) / tread
    assert edges == pytest.approx(round(edges), abs=0.08)


@pytest.mark.parametrize("text", ["flat", "slope:20", "slope:-25", "rough:3,0.05", "stairs:0.03,0.3"])
def test_other_ground_has_none(text: str) -> None:
    ground = read_terrain(text, "terrain")
    heights = ground.height(np.column_stack([WAYS, 0.0 * WAYS]))
    assert find_stairs(_blurred(heights, 3, 0.002)) is None


def test_one_step_and_uneven_ones_are_no_stairs() -> None:
    kerb = np.where(WAYS > 0.2, 0.12, 0.0)
    assert find_stairs(kerb) is None
    places, jumps = find_edges(kerb)
    assert len(places) == 1
    assert jumps == pytest.approx([0.12])
    assert WAYS[0] + FINE * places[0] == pytest.approx(0.2, abs=0.01)
    assert find_stairs(kerb + np.where(WAYS > 0.5, 0.3, 0.0)) is None  # another height: what is not seen yet
    assert find_stairs(np.where(np.abs(WAYS) < 0.15, 0.12, 0.0)) is None  # up and down again
    assert find_stairs(np.where(WAYS > 0.2, 0.12, 0.0) + np.where(WAYS > 1.0, 0.12, 0.0)) is None  # a landing


def _watch(terrain: Terrain, watch: StairWatch, places: np.ndarray, start: float = 0.0) -> float:
    time = start
    for x in places:
        watch.look(terrain, np.array([x, 0.0]), 0.0, time)
        time += 0.1
    return time


def test_what_is_remembered_is_even_and_ends_after_the_last_edge() -> None:
    stairs, watch = StairsTerrain(0.12, 0.3), StairWatch()
    assert watch.steps is None
    time = _watch(stairs, watch, np.full(STAIR_DETECTION.looks - 1, -0.3))
    assert watch.steps is None
    time = _watch(stairs, watch, np.linspace(-0.3, 0.9, 30), time)
    assert watch.steps is not None
    assert watch.steps == pytest.approx(StairSteps(0.12, 0.3), abs=0.005)
    kept = watch.steps
    time = _watch(FlatTerrain(), watch, np.zeros(3), time)
    assert watch.steps == kept
    _watch(FlatTerrain(), watch, np.zeros(2 + round(STAIR_DETECTION.patience / 0.1)), time)
    assert watch.steps is None


def test_the_way_counts_and_not_the_world() -> None:
    stairs, watch = StairsTerrain(0.12, 0.3), StairWatch()
    for k in range(STAIR_DETECTION.looks):
        watch.look(stairs, np.array([1.5, 0.0]), np.pi, 0.1 * k)  # backwards they go down
    assert watch.steps is not None
    assert watch.steps.rise == pytest.approx(-0.12, abs=0.005)
