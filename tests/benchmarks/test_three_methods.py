"""The jump by three methods: the judgement is strict, the tables are printed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.three_methods.__main__ import main
from benchmarks.three_methods.methods import METHODS, solve_task
from benchmarks.three_methods.task import hopper_jump, reached

pytest.importorskip("casadi")


def test_torques_beyond_the_limits_do_not_count() -> None:
    task = hopper_jump()
    motion, _ = METHODS["given schedule"](task, task.problem, None)
    assert reached(task.problem, motion)
    weaker = replace(task.problem, torque_limits=0.5 * np.abs(motion.torques).max(axis=0))
    assert not reached(weaker, motion)


def test_a_start_that_cannot_be_stepped_is_not_solved() -> None:
    task = hopper_jump()
    over = task.variations["starts 0.1 m over the ground"](task.problem)
    assert not solve_task(METHODS["given schedule"], task, over, None).solved


@pytest.mark.long
def test_quick_tables(capsys) -> None:
    main(["--quick"])
    said = capsys.readouterr().out
    assert all(said.count(name) == 2 for name in METHODS)
    assert "2 of 2" in said
