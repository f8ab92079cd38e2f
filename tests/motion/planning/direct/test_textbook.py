"""The small problems are found by the direct method, and bodies that touch each other take exact steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.motion.planning import rollout
from surefoot.motion.planning.direct import DirectProblem, Facets, plan_direct
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.direct.textbook import pushed_block, sliding_point
from surefoot.motion.planning.planner import plan
from surefoot.motion.planning.transcription.exact_rollout import follow
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.motion_errors import complementarity, window_miss
from surefoot.motion.planning.transcription.pair_rollout import rollout_with_pairs

pytest.importorskip("casadi")


@pytest.mark.parametrize("task", ["ball", "hopper", "push"])
@pytest.mark.long
def test_a_task_is_solved_and_lawful(task: str) -> None:
    heard = []
    made = plan(None, task, mu=0.5, tell=heard.append)
    assert made.status.value == "solved", made.facts["goal"]
    assert (made.method, made.law_residual < 1e-8) == ("direct", True)
    assert heard[-1].note == "modes"
    assert heard[-1].number == made.iterations


def test_the_slide_of_a_point_is_what_exact_steps_make_of_it() -> None:
    small = sliding_point()
    found = plan_direct(small.problem, guess=small.guess(1))
    exact = rollout(small.problem.robot, small.problem.q, small.problem.v, np.zeros((40, 2)), dt=0.02, mu=0.5)
    assert np.abs(found.motion.q - exact.q).max() < 1e-6
    assert exact.q[-1, 0] == pytest.approx(0.5 * 2.0**2 / (0.5 * 9.81), rel=0.06)  # v² / (2 mu g), and a step
    assert window_miss(replace(small.problem, end=small.done), exact) == 0.0


def pushed() -> tuple[DirectProblem, np.ndarray]:
    """A block that a steady force of 12 N pushes along, and the torques."""
    problem = pushed_block().problem
    torques = np.zeros((problem.knots, 4))
    torques[:, 2], torques[:, 3] = 12.0, 0.5 * 9.81 + 0.02  # the foot ends a little above the ground
    return problem, torques


def test_the_push_between_bodies_is_newtons() -> None:
    """What the foot loses the block gains, and the block's friction is mu times its load."""
    problem, torques = pushed()
    motion = rollout_with_pairs(problem, lambda k, q, v: torques[k])
    assert motion.lawful
    assert motion.law_residual < 1e-8
    assert motion.touch_impulses is not None
    push = motion.touch_impulses[:, 0]
    moving = slice(12, 25)
    assert (push[moving, 2] > 0.0).all()
    gained = 2.0 * np.diff(motion.v[:, 0]) - motion.impulses[:, 0, 0]
    assert np.abs(gained - push[:, 2]).max() < 1e-9
    lost = 0.5 * np.diff(motion.v[:, 2]) - problem.dt * 12.0 - motion.impulses[:, 1, 0]
    assert np.abs(lost + push[:, 2]).max() < 1e-9
    sliding = motion.impulses[moving, 0]
    assert np.abs(sliding[:, 0] + 0.4 * sliding[:, 2]).max() < 1e-9
    apart = motion.q[1:, 0] - motion.q[1:, 2] - 0.12
    assert apart.min() > -1e-9


def test_exact_steps_with_touches_obey_the_rows() -> None:
    problem, torques = pushed()
    motion = rollout_with_pairs(problem, lambda k, q, v: torques[k])
    assert motion.touch_impulses is not None
    guess = Guess(motion.q, motion.v, motion.torques, np.hstack([motion.impulses, motion.touch_impulses]))
    free = replace(problem, end=type(problem.end)(), joint_limits=False)
    nlp = DirectNlp(free, Facets())
    settings = dict.fromkeys(("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac"), 1e-16)
    assert nlp.solve(nlp.pack(guess), 1e-8, max_iter=0, **settings).violation < 1e-6
    weak = replace(guess, impulses=guess.impulses * np.array([1.0, 1.0, 0.5])[:, None])
    assert nlp.solve(nlp.pack(weak), 1e-8, max_iter=0, **settings).violation > 1e-3
    closing, sliding = nlp.contact_speeds(guess)
    assert complementarity(guess.impulses, problem.dt * closing, sliding, problem.frictions) < 1e-7
    spoilt = guess.impulses.copy()
    spoilt[3, 0, 2] += 0.1  # more load than its friction goes with
    assert complementarity(spoilt, problem.dt * closing, sliding, problem.frictions) > 1e-3
    assert np.array_equal(follow(problem, guess).q, motion.q)
