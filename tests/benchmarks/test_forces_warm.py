"""The part of the forces benchmark that measures warm starts: its trajectories, its rows and its picture."""

from dataclasses import replace

import pytest

from benchmarks.forces.warm import measure
from benchmarks.problems.trajectories import SCENES, simulate


def test_a_simulated_stand_on_a_slope_has_active_cones():
    scene = next(s for s in SCENES if s.name == "sliding")
    scene = replace(scene, pushes=((0.05, (60.0, 30.0, 0.0), 0.2),))
    trajectory = simulate(scene, 0.2)
    assert len(trajectory) == 200
    assert all(i.mu == pytest.approx(0.5) for i in trajectory)
    row = measure("slope", trajectory[100:160])
    assert row.steps == 60
    assert row.active == 1.0
    assert row.iterations_warm < row.iterations_cold
    assert 0.0 < row.loop_warm.median < row.warm.median
