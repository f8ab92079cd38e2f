"""Settings of ground decide: another value is another answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.terrain import StairsTerrain
from surefoot.motion.ground import plane_ahead, stair_detection
from surefoot.motion.ground.elevation_map import ElevationMap, MapSettings
from surefoot.motion.ground.ground_settings import (
    GROUND_PLANE,
    STAIR_DETECTION,
    GroundEstimateSettings,
    StairDetectionSettings,
)


def test_a_jump_below_the_least_one_is_no_edge(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.repeat([0.0, 0.1, 0.2], 30)
    assert len(stair_detection.find_edges(heights)[0]) == 2
    monkeypatch.setattr(stair_detection, "STAIR_DETECTION", replace(STAIR_DETECTION, least_jump=0.15))
    assert not len(stair_detection.find_edges(heights)[0])


def test_treads_outside_the_allowed_ones_are_no_stairs(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.repeat([0.0, 0.1, 0.2, 0.3], 28)
    assert stair_detection.find_stairs(heights) is not None
    monkeypatch.setattr(stair_detection, "STAIR_DETECTION", replace(STAIR_DETECTION, treads=(0.3, 0.6)))
    assert stair_detection.find_stairs(heights) is None


def test_a_longer_window_sees_stairs_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first riser is at x = 0; a metre before it a window of 0.6 m does not reach it."""
    given = StairsTerrain(0.1, 0.3), np.array([-1.0, 0.0]), 0.0, np.zeros(2), 0.3
    assert plane_ahead.plane_ahead(*given)[1] == pytest.approx([0.0, 0.0], abs=1e-12)
    monkeypatch.setattr(plane_ahead, "GROUND_PLANE", replace(GROUND_PLANE, half_length=5.0))
    assert plane_ahead.plane_ahead(*given)[1][0] > 1e-3


def test_a_neighbour_across_an_edge_belongs_to_the_surface_only_within_slope_and_step() -> None:
    slopes = []
    for step in (0.012, 0.4):
        ground = ElevationMap(MapSettings(half=0.5, neighbour_step=step))
        x, y = np.meshgrid(np.arange(-0.4, 0.4, 0.01), np.arange(-0.1, 0.1, 0.01))
        heights = np.where(x > 0.0, 0.3, 0.0)
        points = np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
        ground.see(points, np.full(len(points), 1e-6))
        slopes.append(abs(float(ground.gradient([-0.05, 0.0])[0])))
    assert slopes[0] < 0.05
    assert slopes[1] > 0.5


@pytest.mark.parametrize(
    ("kind", "wrong"),
    [(GroundEstimateSettings, {"forgetting": 1.5}), (StairDetectionSettings, {"looks": 0})],
)
def test_a_value_out_of_range_is_refused(kind: type, wrong: dict[str, float]) -> None:
    with pytest.raises(ProblemError, match=next(iter(wrong))):
        kind(**wrong)
