"""The compiled bicubic surface against plain NumPy and finite differences."""

import numpy as np
import pytest

from surefoot.mechanics.terrain import HeightfieldTerrain


def catmull_rom(u: np.ndarray) -> np.ndarray:
    """Return the four weights at u: (..., 4), from the spline's matrix."""
    matrix = 0.5 * np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], dtype=float)
    return np.stack([np.ones_like(u), u, u**2, u**3], axis=-1) @ matrix


def twin(ground: HeightfieldTerrain, xy: np.ndarray) -> float:
    at = (xy - ground.origin) / ground.spacing
    cell = np.minimum(np.floor(at), np.array(ground.heights.shape) - 2.0).astype(int)
    wx, wy = catmull_rom(at - cell)
    return float(wx @ ground._extended[cell[0] : cell[0] + 4, cell[1] : cell[1] + 4] @ wy)


@pytest.fixture(scope="module")
def ground() -> HeightfieldTerrain:
    return HeightfieldTerrain(np.random.default_rng(0).normal(size=(7, 9)), 0.3, origin=[-0.5, 0.2])


def test_heights_match_plain_numpy(ground: HeightfieldTerrain) -> None:
    size = ground.spacing * (np.array(ground.heights.shape) - 1.0)
    places = ground.origin + size * np.random.default_rng(1).random((200, 2))
    assert ground.height(places) == pytest.approx([twin(ground, p) for p in places], abs=1e-12)
