"""Contact frames of many normals at once, against that of one, and against what a frame is."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics.terrain.frames import frames_on

AXES = np.concatenate([np.eye(3), -np.eye(3)])


def normals(seed: int) -> np.ndarray:
    """Return random unit normals, axes, and some that are nearly the heading."""
    rng = np.random.default_rng(seed)
    drawn = np.concatenate([rng.normal(size=(30, 3)), AXES, AXES + 1e-7 * rng.normal(size=AXES.shape)])
    return drawn / np.linalg.norm(drawn, axis=1)[:, None]


@pytest.mark.parametrize("seed", range(4))
def test_many_frames_are_those_of_each_normal(seed: int) -> None:
    given = normals(seed)
    found = frames_on(given)
    np.testing.assert_allclose(found, [rotation_from_normal(n) for n in given], atol=1e-12)
    np.testing.assert_allclose(
        found @ np.swapaxes(found, 1, 2), np.tile(np.eye(3), (len(given), 1, 1)), atol=1e-8
    )
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-8)
    assert (found[:, :, 2] == given).all()


def test_frames_keep_the_shape_of_their_normals() -> None:
    given = normals(9)[:12].reshape(2, 3, 2, 3)
    assert frames_on(given).shape == (2, 3, 2, 3, 3)
    np.testing.assert_array_equal(frames_on(given)[1, 2, 0], frames_on(given[1, 2, 0]))
    assert frames_on(np.zeros((0, 3))).shape == (0, 3, 3)
