"""The part of the forces benchmark that measures warm starts: its trajectories, its rows and its picture."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.forces.pictures import plot_warm_starts
from benchmarks.forces.race import distributor_for
from benchmarks.forces.warm import loop_times, measure, measure_all, on_the_edge, same_feet
from benchmarks.problems.allocations import four_feet, pushed_stance
from benchmarks.problems.trajectories import SCENES, simulate
from surefoot.cli.parsing import push


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


def test_commands_describe_the_scenes():
    for scene in SCENES:
        words = scene.command.split()
        texts = [words[k + 1] for k, word in enumerate(words) if word == "--push"]
        parsed = [push(text) for text in texts]
        assert [(p.start, p.force, p.duration) for p in parsed] == list(scene.pushes)
        assert words[words.index("--slope") + 1] == f"{scene.slope:g}"
        assert words[words.index("--mu") + 1] == f"{scene.mu:g}"


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


def test_edges_are_seen():
    for kind, share in (("easy", 0.2), ("infeasible-wrench", 1.0)):
        instances = four_feet(kind, 20)
        forces = [distributor_for(i).solve(i.grasp_map, i.wrench) for i in instances]
        found = np.mean([on_the_edge(i, f) for i, f in zip(instances, forces, strict=True)])
        assert abs(found - share) <= 0.2
    instance = instances[0]
    assert not on_the_edge(instance, np.tile([1.0, 0.0, 50.0], (4, 1)))
    assert on_the_edge(instance, np.array([[0.0, 0.0, 50.0]] * 3 + [[0.0, 0.0, 5.0]]))


def test_only_steps_on_the_same_feet_count():
    trajectory = pushed_stance(6)
    lifted = replace(trajectory[3], normal_max=np.array([250.0, 250.0, 0.0, 250.0]))
    assert len(same_feet([*trajectory[:3], lifted, *trajectory[4:]])) == 5


def test_picture(tmp_path):
    rows = list(measure_all([("a", pushed_stance(20)), ("b", pushed_stance(20, 0.01))]))
    assert plot_warm_starts(rows, tmp_path).stat().st_size > 8_000
