"""The forces benchmark: its rivals and its judgement of them."""

import numpy as np
import pytest

import surefoot as sf
from benchmarks.forces.race import best_known, judge, run_ours
from benchmarks.forces.rivals import EXACT_RIVALS, FACET_RIVALS, available
from benchmarks.problems.allocation_program import objective, program
from benchmarks.problems.allocations import CLASSES, four_feet

ALL = available(EXACT_RIVALS) + available(FACET_RIVALS)


@pytest.mark.parametrize("rival", ALL, ids=lambda r: r.name)
@pytest.mark.parametrize("kind", CLASSES)
def test_rivals_solve_their_program(rival, kind):
    """Each rival's answer satisfies the laws of its own cones, by the residuals of the problem alone."""
    for instance in four_feet(kind, 3, seed=1):
        p = program(instance, None if rival.exact else 8)
        problem = sf.ContactProblem(p.H, p.h, p.mu, p.low[2::3], p.high[2::3], law="convex")
        if not rival.exact:
            problem = problem.polyhedral(8)
        for warm in (False, True):
            x = rival().solve(p, warm)
            if rival.name == "HiGHS" and x is None:
                continue
            assert sf.residuals(problem, p.forces(x)).velocity_error < 1e-3


def test_a_wrong_answer_is_not_counted_as_solved():
    instances = four_feet("near-boundary", 4)
    exact = run_ours(instances)
    programs = [program(i) for i in instances]
    good = [f.ravel() for f in exact.forces]
    wrong = [good[0], good[1] * 1.01, np.full(12, np.nan), None]
    best = best_known(programs, [good])
    np.testing.assert_allclose(best, [objective(p, x) for p, x in zip(programs, good, strict=True)])
    row = judge("x", "exact", "near-boundary", False, np.ones(4), programs, wrong, best, exact, 0.0)
    assert row.solved == 0.25
    assert row.distance_worst == 0.0
