"""The distance to ground in levels, against the boxes that engines build of it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.terrain import PitTerrain, StairsTerrain, Terrain
from surefoot.mechanics.terrain.levels import LevelsTerrain
from surefoot.mechanics.terrain.surface_shapes import GroundBox

GROUNDS = (StairsTerrain(0.12, 0.3, 4), StairsTerrain(-0.12, 0.3, 4), PitTerrain(0.2, 0.4, 0.1))


def _closest(ground: LevelsTerrain, point: FloatArray) -> float:
    """Return the distance of a point to the closest of the ground's boxes, 0 inside of one [m]."""
    ways = []
    for box in ground.shapes():
        assert isinstance(box, GroundBox)
        half = 0.5 * box.size
        ways.append(point - np.clip(point, box.centre - half, box.centre + half))
    return min(float(np.linalg.norm(way)) for way in ways)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    ground=st.sampled_from(GROUNDS), x=st.floats(-0.5, 1.7), y=st.floats(-1.0, 1.0), up=st.floats(1e-4, 0.4)
)
def test_distance_and_normal_are_those_of_the_boxes(
    ground: LevelsTerrain, x: float, y: float, up: float
) -> None:
    point = np.array([x, y, float(ground.height([x, y])) + up])
    distance, normal = ground.nearest(point)
    wanted = _closest(ground, point)
    assert float(distance) == pytest.approx(wanted, abs=1e-12)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
    # ground against the normal, in a corner at one of two places that are as close, and free air along it
    assert _closest(ground, point - float(distance) * normal) < 1e-9
    assert _closest(ground, point + 1e-3 * normal) > min(wanted, 1e-4)


@pytest.mark.parametrize("ground", GROUNDS, ids=repr)
def test_batches_are_points_one_by_one(ground: Terrain) -> None:
    r = np.random.default_rng(3)
    points = r.uniform([-0.5, -1.0, -0.6], [1.7, 1.0, 0.8], (5, 7, 3))
    distances, normals = ground.nearest(points)
    for i, k in np.ndindex(5, 7):
        distance, normal = ground.nearest(points[i, k])
        assert distance == distances[i, k]
        assert (normal == normals[i, k]).all()


def test_a_point_on_a_face_is_on_the_ground() -> None:
    distance, normal = StairsTerrain(-0.12, 0.3).nearest([0.0, 0.0, -0.06])
    assert float(distance) == 0.0
    assert normal.tolist() == [1.0, 0.0, 0.0]


def test_inside_the_ground_the_tread_above_counts() -> None:
    distance, normal = StairsTerrain(0.12, 0.3).nearest([0.15, 0.0, 0.1])
    assert distance == pytest.approx(-0.02)
    assert normal.tolist() == [0.0, 0.0, 1.0]
