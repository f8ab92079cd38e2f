"""2,000 random contact problems with known answer: nothing that the package says of them may be false.

`python tests/adversary/hunt.py --count 20000 --seed 100` goes on looking.
"""

from __future__ import annotations

import numpy as np
import pytest
from building import FEASIBLE, case
from families import FAMILIES
from hunt import examine, sweep
from oracle import judge, read

import surefoot as sf

COUNT = {"large_sparse": 6, "medium": 30, "squeezed_many": 30}
"""Problems of the costly families; the others have 90."""
WEAKLY = ("weak",)
"""Families whose infimum is not attained: forces that solve them to any tolerance exist."""
SAMPLE = ("small", "redundant", "unequal_loads", "scales", "decoupled", "squeezed", "squeezed_beside_lawful",
          "no_normal_row", "held_apart", "jamming", "weak", "rank_one", "enormous")  # fmt: skip


@pytest.mark.parametrize("name", sorted(FAMILIES))
def test_no_verdict_of_auto_is_false(name: str) -> None:
    found = [examine(name, seed, max_time=0.5) for seed in range(COUNT.get(name, 90))]
    lies = [f"{f.lies}: {f.command}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])
    if name not in WEAKLY:
        leaks = [f.command for f in found if f.leaks]
        assert not leaks, "\n".join(["SOLVED without having a solution", *leaks[:10]])


@pytest.mark.parametrize("name", SAMPLE)
def test_no_verdict_of_any_solver_is_false(name: str) -> None:
    found = list(sweep([name], range(200, 204), ("all",), 1e-8, ["cold"], 0.25, 3000))
    lies = [f"{f.lies}: {f.command}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])
    assert {"auto", "admm"} <= {f.solver for f in found}


@pytest.mark.parametrize("start", ["huge", "random", "lawful"])
@pytest.mark.parametrize("name", SAMPLE)
def test_a_warm_start_cannot_make_it_lie(name: str, start: str) -> None:
    solvers = ("auto", "nsgs", "admm", "newton", "staggered")
    found = list(sweep([name], range(300, 303), solvers, 1e-8, [start], 0.25, 3000))
    lies = [f"{f.lies}: {f.command}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])


@pytest.mark.parametrize("most", [0, 1, 3])
def test_stopping_early_cannot_make_it_lie(most: int) -> None:
    found = list(sweep(FAMILIES, range(400, 402), ("auto", "nsgs", "admm"), 1e-8, ["cold"], 0.25, most))
    lies = [f"{f.lies}: {f.command} --max-iterations {most}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])


@pytest.mark.parametrize("tol", [0.0, 1e-14, 1e-12, 1e-4])
def test_no_tolerance_makes_it_lie(tol: float) -> None:
    found = list(sweep(FAMILIES, range(500, 503), ("auto",), tol, ["cold"], 0.25))
    lies = [f"{f.lies}: {f.command}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_warm_start_of_nan_is_refused(value: float) -> None:
    problem = sf.ContactProblem(**case("small", 0).arguments)
    with pytest.raises(sf.SurefootError, match="warm_start"):
        sf.solve(problem, warm_start=np.full((problem.contacts, 3), value))


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("tol", [1e-4, 1e-8, 1e-12])
def test_a_body_that_cannot_be_stopped_is_not_solved(law: str, tol: float) -> None:
    """The normal that nothing moves: |f| = 2.5e10 was SOLVED, penetrating at 0.05 m/s."""
    found = sf.solve(sf.ContactProblem(np.diag([1.0, 1.0, 0.0]), [1.0, 0.0, -0.05], 0.5, law=law), tol=tol)  # type: ignore[arg-type]
    assert found.status is sf.Status.INFEASIBLE


def test_residuals_agree_with_the_judge() -> None:
    """What a solution states of itself is what the definition says."""
    for name in ("small", "redundant", "unequal_loads", "scales", "decoupled", "locked"):
        for seed in range(600, 610):
            found = case(name, seed)
            assert found.truth == FEASIBLE
            data, rng = read(found.arguments), np.random.default_rng(seed)
            forces = sf.solve(sf.ContactProblem(**found.arguments)).forces
            forces = forces * (1.0 + 10.0 ** rng.uniform(-6, -1) * rng.normal(size=forces.shape))
            stated = sf.contact.residuals.residuals(sf.ContactProblem(**found.arguments), forces)
            verdict = judge(data, forces)
            share = np.divide(
                verdict.error, verdict.scale, out=np.zeros_like(verdict.error), where=verdict.scale > 0
            )
            assert stated.velocity_error == pytest.approx(share.max(), rel=1e-4, abs=1e-13), (name, seed)
