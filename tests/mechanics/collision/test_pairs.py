"""Where solids are, and which of them are near: the kernel against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from surefoot.mechanics.collision.pairs import place_solids, sweep_boxes


@pytest.mark.parametrize("seed", range(5))
def test_solids_are_placed_and_near_ones_found(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints, solids = 4, 9
    turns, turn = (Rotation.random(n, rng).as_matrix() for n in (joints, solids))
    places, place = rng.normal(size=(joints, 3)), 0.1 * rng.normal(size=(solids, 3))
    carrier = rng.integers(joints, size=solids)
    half, radius = rng.uniform(0.0, 0.3, (solids, 3)), rng.uniform(0.0, 0.1, solids)
    pairs = np.array([(a, b) for a in range(solids) for b in range(a)], dtype=np.int64)
    rotation, centre, reach = np.empty((solids, 3, 3)), np.empty((solids, 3)), 0.1
    near, _ = place_solids(
        turns, places, carrier, turn, place, half, radius, pairs, reach, rotation, centre
    )  # fmt: skip
    assert np.abs(rotation - turns[carrier] @ turn).max() < 1e-14
    assert np.abs(centre - places[carrier] - np.einsum("sij,sj->si", turns[carrier], place)).max() < 1e-14
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    reached = np.einsum("sij,skj->ski", rotation, corners * half[:, None]) + centre[:, None]
    low, high = reached.min(axis=1) - radius[:, None], reached.max(axis=1) + radius[:, None]
    a, b = pairs.T
    apart = np.maximum(low[a] - high[b], low[b] - high[a])
    assert near.tolist() == np.flatnonzero((apart < reach).all(axis=1)).tolist()
    assert 0 < near.size < len(pairs)


@pytest.mark.parametrize("seed", range(3))
def test_the_sweep_finds_the_pairs_that_are_close_along_every_axis(seed: int) -> None:
    rng = np.random.default_rng(seed)
    centre, extent, reach = rng.uniform(0.0, 1.0, (60, 3)), rng.uniform(0.0, 0.1, (60, 3)), 0.05
    apart = np.abs(centre[:, None] - centre) - extent[:, None] - extent
    expected = np.argwhere(np.triu((apart < reach).all(axis=2), 1))
    assert sweep_boxes(centre, extent, reach).tolist() == expected.tolist()
    assert len(expected) > 20
