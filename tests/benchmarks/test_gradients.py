"""The tasks of docs/reports/gradients.md: slopes against differences, statistics against known answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.gradients.__main__ import main
from benchmarks.gradients.estimators import Grid, Task, compare, of_landing, of_system
from benchmarks.gradients.landing import Landing
from benchmarks.gradients.search import descend, race
from benchmarks.gradients.tasks import Ball, Block, Hopper, Slide

CASES = [(Ball(), 0.7), (Block(), 0.25), (Hopper(), 60.0), (Slide(), 0.3)]


@pytest.mark.parametrize(("system", "theta"), CASES, ids=lambda case: getattr(case, "name", ""))
def test_implicit_slopes_are_those_of_differences(system: Ball, theta: float) -> None:
    task, e = of_system(system), 1e-5
    difference = (task.loss(theta + e) - task.loss(theta - e)) / (2.0 * e)
    assert task.exact(theta) == pytest.approx(difference, rel=1e-5)
    assert task.smooth(theta, 1e-6) == pytest.approx(difference, rel=0.05)


def test_the_landing_of_the_robot_has_its_slope() -> None:
    task, e = of_landing(Landing(steps=60)), 1e-4
    difference = (task.loss(0.3 + e) - task.loss(0.3 - e)) / (2.0 * e)
    assert task.exact(0.3) == pytest.approx(difference, rel=1e-4)


def _step_task(jump: float) -> Task:
    """Return a task whose loss is x² with a jump at zero, its slope blind to it."""

    def loss(x: float) -> float:
        return x * x + (jump if x > 0.0 else 0.0)

    return Task("step", -1.0, 1.0, loss, lambda x: 2.0 * x, lambda x, s: 2.0 * x, lambda x, k: loss(x))


def test_randomised_moments_of_a_known_loss() -> None:
    grid = Grid(_step_task(3.0), 4001)
    sigma = grid.task.sigma
    told = grid.moments(0.0)
    # the smoothed step has the slope of the normal density at its middle
    assert told.zeroth == pytest.approx(3.0 / (sigma * np.sqrt(2.0 * np.pi)), rel=0.02)
    assert told.first == pytest.approx(0.0, abs=1e-9)
    assert told.first_spread == pytest.approx(2.0 * sigma, rel=0.02)
    rows = {row.method: row for row in compare(grid, 21, np.array([1e-2]), np.array([1e4]))}
    assert rows["randomised, zeroth order"].bias_smoothed == 0.0
    assert rows["randomised, first order"].bias_smoothed > 0.5
    assert rows["implicit, exact"].bias_exact == 0.0


def test_a_descent_arrives_where_the_slope_leads() -> None:
    task = _step_task(0.0)
    end = descend(task, lambda x, _: task.exact(x), 0.7, 40, 0)
    assert abs(end) < 0.02
    grid = Grid(task, 201)
    outcomes = {o.method: o for o in race(grid, 3, 30)}
    assert outcomes["implicit, exact"].arrived == 3


@pytest.mark.long
def test_the_command_runs_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["--quick", "--out", str(tmp_path)])
    assert "pushed block" in capsys.readouterr().out
    assert (tmp_path / "gradients.png").stat().st_size > 10_000
