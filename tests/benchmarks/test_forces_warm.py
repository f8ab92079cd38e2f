"""The part of the forces benchmark that measures warm starts: its trajectories, its rows and its picture."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.forces.race import distributor_for
from benchmarks.forces.warm import loop_times, measure
from benchmarks.problems.allocations import pushed_stance
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


def test_loops_take_the_same_steps_as_calls():
    """The compiled loop is given each step's memory anew, so its iterations are those of single calls."""
    trajectory = pushed_stance(40, 0.02)
    for warm in (False, True):
        distributor = distributor_for(trajectory[0])
        expected = []
        for instance in trajectory:
            if not warm:
                distributor.reset()
            distributor.solve(instance.grasp_map, instance.wrench)
            expected.append(distributor.iterations)
        times, iterations = loop_times(trajectory, warm)
        assert np.all(times > 0.0)
        assert len(set(expected)) > 1
        np.testing.assert_array_equal(iterations, expected)
