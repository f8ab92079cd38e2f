"""The small problems are found, and exact steps that know nothing of an optimiser repeat them."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.planning.tasks import ball, hopper, push
from surefoot.planning.tasks.task import Request
from surefoot.planning.transcription.continuation import follow
from surefoot.planning.transcription.forms import FORMS, schedule
from surefoot.planning.transcription.judge import judge
from surefoot.planning.transcription.program import transcribe
from surefoot.planning.transcription.replay import replay
from surefoot.planning.transcription.textbook import PROBLEMS

pytest.importorskip("casadi")


@pytest.mark.parametrize("task", [ball.TASK, hopper.TASK, push.TASK], ids=lambda task: task.name)
def test_a_task_is_solved_and_lawful(task: object) -> None:
    heard = []
    plan = task.plan(Request(None, task.default, 0.5, None, None, "relaxed", 0, None), heard.append)  # type: ignore[attr-defined]
    assert plan.status.value == "solved", plan.facts["goal"]
    assert plan.law_residual < 1e-8
    assert heard[-1].note == "modes held"
    assert heard[-1].number == plan.iterations


@pytest.mark.parametrize("name", ["ball", "slide", "kicker"])
def test_exact_steps_repeat_what_was_found(name: str) -> None:
    problem = PROBLEMS[name]()
    answer = follow(
        transcribe(problem, FORMS["relaxed"]), problem.guess(0), schedule(0.1, 1e-8), polished=True
    )
    steps = replay(problem, answer.motion.u)
    assert answer.outcome.solved
    assert steps.law_residual < 1e-8
    assert np.abs(steps.motion.q - answer.motion.q).max() < 1e-6


def test_the_judge_sees_faults() -> None:
    problem = PROBLEMS["ball"]()
    exact = replay(problem, np.zeros((problem.knots, 0))).motion
    assert judge(problem, exact).solved
    exact.normal[3, 0] += 0.1  # a force in the air
    wrong = judge(problem, exact)
    assert not wrong.solved
    assert wrong.complementarity == pytest.approx(0.1)
    assert wrong.defect == pytest.approx(0.1)
