"""Many stances as arrays: frames by hand, single stances taken out, and shapes that are refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance.stance_batch import StanceBatch

PLACES = np.arange(18.0).reshape(3, 2, 3)


def tilted(angle: float) -> np.ndarray:
    """Return a normal turned from x towards y."""
    return np.array([math.cos(angle), math.sin(angle), 0.0])


@pytest.mark.parametrize("angle", [math.pi / 2.0, 1.0, -2.0, 1e-4, 1.5e-5])
def test_x_of_a_frame_is_the_world_s_in_the_surface(angle: float) -> None:
    """Of a normal in the plane of x and y it is at a right angle to it there, on the side of x."""
    batch = StanceBatch(PLACES, tilted(angle))
    side = math.copysign(1.0, math.sin(angle))
    x = side * np.array([math.sin(angle), -math.cos(angle), 0.0])
    frame = np.column_stack([x, np.cross(tilted(angle), x), tilted(angle)])
    assert batch.rotations.shape == (3, 2, 3, 3)
    np.testing.assert_allclose(batch.rotations, np.broadcast_to(frame, (3, 2, 3, 3)), atol=1e-10)
    assert batch.rotations.flags.c_contiguous


@pytest.mark.parametrize("angle", [0.0, math.pi, 5e-6])
def test_a_normal_along_x_has_the_frame_of_a_single_contact(angle: float) -> None:
    R = StanceBatch(PLACES, tilted(angle)).rotations[1, 1]
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(R[:, 2], tilted(angle), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(R, sf.PointContact([0, 0, 0], tilted(angle)).rotation_world_contact, atol=1e-9)


def test_level_frames_are_the_world_s_without_negative_zeros() -> None:
    rotations = StanceBatch(PLACES).rotations
    np.testing.assert_array_equal(rotations, np.broadcast_to(np.eye(3), (3, 2, 3, 3)))
    assert not np.signbit(rotations).any()


def test_normals_are_given_once_or_for_each_contact() -> None:
    normals = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (3, 2, 3)).copy()
    normals[2, 1] = [0.0, 0.6, 0.8]
    batch = StanceBatch(PLACES, normals)
    np.testing.assert_allclose(
        batch.rotations[2, 1], [[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]], atol=1e-15
    )
    np.testing.assert_array_equal(batch.rotations[2, 0], np.eye(3))


@pytest.mark.parametrize("size", [1.0 + 3e-6, 1.0 - 3e-6, 0.0, 2.0])
def test_normals_that_are_not_unit_are_refused(size: float) -> None:
    with pytest.raises(ProblemError, match="normal"):
        StanceBatch(PLACES, [0.0, 0.0, size])


def test_normals_of_unit_length_up_to_rounding_are_taken() -> None:
    for size in (1.0 + 5e-7, 1.0 - 5e-7):
        batch = StanceBatch(PLACES, [0.0, 0.6 * size, 0.8 * size])
        np.testing.assert_allclose(batch.rotations[0, 0, :, 2], [0.0, 0.6, 0.8], atol=1e-9)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"normals": np.zeros((2, 3))}, r"normals must have shape \(3,\) or \(3, 2, 3\), got \(2, 3\)"),
        ({"mu": -0.1}, "mu must be >= 0, got -0.1"),
        ({"mu": [[0.1, 0.2, 0.3]]}, r"mu must be a number or broadcast to \(3, 2\), got \(1, 3\)"),
        ({"counts": [1, 2, 3]}, "counts must be whole numbers from 0 to 2"),
        ({"counts": [1, -1, 2]}, "counts must be whole numbers from 0 to 2"),
        ({"counts": [1, 0.5, 2]}, "counts must be whole numbers from 0 to 2"),
        ({"counts": [1, 2]}, "counts"),
    ],
)
def test_what_does_not_fit_is_told(words: dict[str, Any], said: str) -> None:
    with pytest.raises(ProblemError, match=said):
        StanceBatch(PLACES, **words)


def test_a_stance_taken_out_has_its_own_contacts() -> None:
    mu = np.array([[0.0, 0.1], [0.2, 0.3], [0.4, 0.5]])
    batch = StanceBatch(PLACES, [0.0, 0.6, 0.8], mu, [2, 0, 1])
    assert len(batch) == 3
    assert [len(batch[k]) for k in range(3)] == [2, 0, 1]
    one = batch[2].contacts[0]
    np.testing.assert_array_equal(one.position, [12.0, 13.0, 14.0])
    np.testing.assert_allclose(one.rotation_world_contact, batch.rotations[2, 0], atol=1e-12)
    assert one.mu == 0.4
    assert [(where.tolist(), count) for where, count in batch.groups()] == [([1], 0), ([2], 1), ([0], 2)]
    assert StanceBatch(PLACES).counts.tolist() == [2, 2, 2]
    assert StanceBatch(PLACES).mu.tolist() == 3 * [[0.6, 0.6]]


def test_stances_of_points_and_soles_become_arrays() -> None:
    ramp = sf.PointContact([1.0, 2.0, 3.0], [0.0, 0.6, 0.8], 0.3)
    sole = sf.SoleContact([0.0, 0.0, 0.0], sf.Sole(0.2, 0.1, 0.7))
    batch = StanceBatch.of([sf.Stance([]), sf.Stance([ramp, sole]), sf.Stance([ramp])])
    assert batch.counts.tolist() == [0, 5, 1]
    assert batch.mu.tolist() == [5 * [0.0], [0.3, *4 * [0.7]], [0.3, *4 * [0.0]]]
    corners = sorted((x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.05, 0.05))
    np.testing.assert_allclose(sorted(map(tuple, batch.positions[1, 1:].tolist())), corners, atol=1e-12)
    np.testing.assert_array_equal(batch.positions[2], [[1.0, 2.0, 3.0], *4 * [[0.0, 0.0, 0.0]]])
    np.testing.assert_allclose(
        batch.rotations[2, 0], [[1.0, 0.0, 0.0], [0.0, 0.8, 0.6], [0.0, -0.6, 0.8]], atol=1e-12
    )
    np.testing.assert_array_equal(batch.rotations[1, 1], np.eye(3))
    assert len(StanceBatch.of([])) == 0
