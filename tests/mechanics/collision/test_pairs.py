"""Where solids are, and which of them are near: the kernel against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from surefoot.mechanics.collision import Box, Capsule, Sphere
from surefoot.mechanics.collision.pairs import look_at_balls, place_solids, sweep_boxes
from surefoot.mechanics.collision.rounded_shapes import coal


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


def seen_by_coal(shapes: list, rotation: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Return what coal sees of two shapes: normal, distance and nearest points (10,)."""
    library = coal()
    poses, request, result = [], library.DistanceRequest(), library.DistanceResult()
    request.gjk_tolerance = request.epa_tolerance = 1e-10
    for R, p in zip(rotation, centre, strict=True):
        poses.append(library.Transform3s(R, p))
    one, two = (shape.solid() for shape in shapes)
    apart = library.distance(one, poses[0], two, poses[1], request, result)
    return np.concatenate([result.normal, [apart], result.getNearestPoint1(), result.getNearestPoint2()])


@pytest.mark.parametrize("other", [Box((0.3, 0.5, 0.2)), Capsule(0.07, 0.4), Sphere(0.2)], ids=str)
@pytest.mark.parametrize("ball_first", [False, True])
def test_a_ball_is_where_coal_sees_it(other: Box | Capsule | Sphere, ball_first: bool) -> None:
    rng, ball, inside = np.random.default_rng(3), Sphere(0.06), 0
    shapes = [ball, other] if ball_first else [other, ball]
    half, radius = np.array([s.core for s in shapes]), np.array([s.radius for s in shapes])
    for _ in range(200):
        rotation = Rotation.random(2, rng).as_matrix()
        centre = rng.uniform(-0.25, 0.25, (2, 3))
        seen, balls = look_at_balls(np.array([[0, 1]]), half, radius, rotation, centre)
        assert balls.all()
        expected = seen_by_coal(shapes, rotation, centre)
        # deep inside a box coal's own answer ends at its tolerance
        np.testing.assert_allclose(seen[0, 3], expected[3], atol=1e-7)
        np.testing.assert_allclose(seen[0, :3], expected[:3], atol=2e-4)
        np.testing.assert_allclose(seen[0, 4:], expected[4:], atol=1e-5)
        inside += seen[0, 3] < 0.0
    assert inside > 5


def test_a_ball_in_the_middle_of_a_box_leaves_by_its_least_way() -> None:
    half, radius = np.array([[0.2, 0.1, 0.3], [0.0, 0.0, 0.0]]), np.array([0.0, 0.05])
    seen, _ = look_at_balls(np.array([[0, 1]]), half, radius, np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 3)))
    np.testing.assert_allclose(seen[0], [0.0, 1.0, 0.0, -0.15, 0.0, 0.1, 0.0, 0.0, -0.05, 0.0], atol=1e-15)


def test_two_boxes_are_left_to_coal() -> None:
    half = np.full((2, 3), 0.1)
    _, balls = look_at_balls(np.array([[0, 1]]), half, np.zeros(2), np.tile(np.eye(3), (2, 1, 1)), half)
    assert not balls.any()
