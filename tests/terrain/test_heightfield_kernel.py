"""The compiled bicubic surface against plain NumPy and finite differences."""

import numpy as np
import pytest

from surefoot.terrain import HeightfieldTerrain


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


def test_normals_are_those_of_the_heights(ground: HeightfieldTerrain) -> None:
    size = ground.spacing * (np.array(ground.heights.shape) - 1.0)
    places = ground.origin + size * (0.02 + 0.96 * np.random.default_rng(2).random((200, 2)))
    step = 1e-6
    slopes = [
        (ground.height(places + d) - ground.height(places - d)) / (2.0 * step) for d in step * np.eye(2)
    ]
    normal = ground.normal(places)
    assert -normal[:, 0] / normal[:, 2] == pytest.approx(slopes[0], abs=1e-7)
    assert -normal[:, 1] / normal[:, 2] == pytest.approx(slopes[1], abs=1e-7)


def test_outside_the_ground_goes_on_level(ground: HeightfieldTerrain) -> None:
    far = np.array([[-9.0, 0.2], [50.0, 50.0]])
    assert ground.height(far) == pytest.approx([ground.heights[0, 0], ground.heights[-1, -1]])
    assert ground.normal(far) == pytest.approx(np.tile([0.0, 0.0, 1.0], (2, 1)))


def test_shapes_are_kept(ground: HeightfieldTerrain) -> None:
    assert np.shape(ground.height([0.0, 1.0])) == ()
    assert ground.height(np.zeros((2, 3, 2))).shape == (2, 3)
    assert ground.normal(np.zeros((2, 3, 2))).shape == (2, 3, 3)
