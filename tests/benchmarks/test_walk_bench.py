"""The MPC benchmark: its scenes ask for what they say, and every rival really solves."""

import numpy as np
import pytest

from benchmarks.problems.walking import SCENES, choose_scenes, controller, record
from benchmarks.walk import race as walk
from benchmarks.walk.horizon import horizon_program
from benchmarks.walk.race import ACCURACY, measure
from benchmarks.walk.rivals import Variant, matrices, rivals, solve_exact

NAMES = [f"{r.solver}-{r.facets}" for r in rivals()]


@pytest.fixture(scope="module")
def programs():
    scene = choose_scenes(["limit"])[0]
    mpc = controller(scene)
    return mpc, [horizon_program(mpc, *inputs) for inputs in record(scene, 40)[18:40:7]]


@pytest.mark.parametrize("which", range(len(NAMES)), ids=NAMES)
@pytest.mark.sampled(3)
def test_every_rival_solves_in_every_form(programs, which):
    mpc, todo = programs
    rival = rivals()[which]
    for form in rival.forms:
        for warm in rival.warm:
            solve = rival.make(Variant(form, warm, 1e-9))
            for program in todo:
                own = solve_exact(matrices(mpc, program, rival.facets, sparse=False, dense=False), 1e-11)
                assert np.linalg.norm(solve(rival.pack(mpc, program, form)) - own) < ACCURACY


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
@pytest.mark.sampled(2)
def test_scenes_are_what_they_say(scene):
    inputs = record(scene, 60)
    share = np.mean([item.contacts.mean() for item in inputs])
    assert share == pytest.approx(scene.duty, abs=0.06)
    assert np.allclose(inputs[0].frames[..., 2] @ scene.normal, 1.0, atol=6.0 * scene.tilt**2 + 1e-12)
    again = record(scene, 60)
    assert all(np.array_equal(a.state.position, b.state.position) for a, b in zip(inputs, again, strict=True))
    off = [np.linalg.norm(item.state.position - item.reference.position[0]) for item in inputs]
    assert max(off) < 0.3
    moved = inputs[-1].state.position - inputs[0].state.position
    assert np.linalg.norm(moved) == pytest.approx(0.59 * np.hypot(*scene.velocity), abs=0.15)


@pytest.mark.long
def test_rows_add_up(monkeypatch):
    monkeypatch.setattr(walk, "TUNING_INPUTS", 5)
    bench = measure(["limit"], calls=24, robots=["a1"])
    assert len(bench.rows) == 1 + len(NAMES)
    ours = bench.rows[0]
    assert ours.ratio == 1.0
    assert ours.accurate
    assert ours.violation < 1e-9
    assert abs(ours.lost) < 1e-3
    for row in bench.rows:
        assert 0.0 < row.timing.median <= row.timing.p99 <= row.timing.worst
        assert row.ratio == pytest.approx(row.timing.median / ours.timing.median)
        if "facets" in row.method:  # inner pyramids leave friction unused and cost more
            assert row.lost > 0.01
            assert row.cost > 0.0
    whole, step, plan = bench.steps
    assert (whole.call, step.call) == ("whole step", "whole-body step")
    assert whole.timing.calls == step.timing.calls > 10 * plan.timing.calls
    assert whole.timing.median > step.timing.median
    assert 0.0 < step.timing.median < 0.1
    four, eight = (np.mean([r.lost for r in bench.rows if f"{k} facets" in r.method]) for k in (4, 8))
    assert four > eight
