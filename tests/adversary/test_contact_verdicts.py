"""2,000 random contact problems with known answer: nothing that the package says of them may be false.

`python tests/adversary/hunt.py --count 20000 --seed 100` goes on looking.
"""

from __future__ import annotations

import numpy as np
import pytest
from building import FEASIBLE, bodies_matrix, case, feasible_case, rescaled
from families import FAMILIES
from hunt import Finding, examine, sweep
from insoluble import squeezed_twins
from oracle import check_proof, judge, read

import surefoot as sf
from surefoot.contact.problem.residuals import residuals

COUNT = {
    "large_sparse": 8,
    "squeezed_sparse": 4,
    "medium": 40,
    "squeezed_many": 30,
    "jamming": 20,
    "gripped": 30,
}
"""Problems of the costly families; the others have 46."""
SAMPLE = ("small", "redundant", "unequal_loads", "scales", "decoupled", "squeezed", "squeezed_beside_lawful",
          "no_normal_row", "held_apart", "jamming", "weak", "rank_one", "enormous")  # fmt: skip


def check(found: list[Finding], more: str = "") -> None:
    """Say which verdicts are false, and by which command they come again."""
    lies = [f"{f.lies}: {f.command}{more}" for f in found if f.lies]
    assert not lies, "\n".join([f"{len(lies)} of {len(found)}", *lies[:10]])


@pytest.mark.parametrize("share", [0, *(pytest.param(k, marks=pytest.mark.long) for k in (1, 2))])
@pytest.mark.parametrize("name", sorted(FAMILIES))
@pytest.mark.sampled(24)
def test_no_verdict_of_auto_is_false(name: str, share: int) -> None:
    found = [examine(name, seed, max_time=0.1) for seed in range(share, COUNT.get(name, 46), 3)]
    check(found)
    leaks = [f.command for f in found if f.leaks]
    # a least energy that is only approached: forces of a few million newtons may come within the tolerance
    most = len(found) // 10 if name.startswith("weak") else 0
    assert len(leaks) <= most, "\n".join(["SOLVED without having a solution", *leaks[:10]])


@pytest.mark.parametrize("name", SAMPLE)
def test_no_verdict_of_any_solver_is_false(name: str) -> None:
    found = list(sweep([name], range(200, 201), ("all",), 1e-8, ["cold"], 0.05, 1000))
    check(found)
    assert {"auto", "admm"} <= {f.solver for f in found}


@pytest.mark.parametrize("start", ["huge", "random", "lawful"])
@pytest.mark.parametrize("name", SAMPLE)
def test_a_warm_start_cannot_make_it_lie(name: str, start: str) -> None:
    solvers = ("auto", "nsgs", "admm", "newton")
    found = list(sweep([name], range(300, 302), solvers, 1e-8, [start], 0.05, 1000))
    check(found)


@pytest.mark.parametrize("most", [0, 1, 3])
@pytest.mark.long
def test_stopping_early_cannot_make_it_lie(most: int) -> None:
    found = list(sweep(SAMPLE, range(400, 403), ("auto", "nsgs", "admm"), 1e-8, ["cold"], 0.05, most))
    check(found, f" --max-iterations {most}")


@pytest.mark.parametrize("tol", [0.0, 1e-14, 1e-12, 1e-4])
@pytest.mark.sampled(2)
def test_no_tolerance_makes_it_lie(tol: float) -> None:
    found = list(sweep(SAMPLE, range(500, 504), ("auto",), tol, ["cold"], 0.05, 1000))
    check(found)


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


@pytest.mark.long
def test_rounding_of_a_huge_friction_coefficient_is_counted() -> None:
    """A sliding speed of rounding's size, times mu, is a velocity that the law sees: such are not SOLVED."""
    rng = np.random.default_rng(5)
    for _ in range(150):
        n, mu = int(rng.integers(1, 7)), 10.0 ** rng.uniform(3.0, 12.0)
        A = rng.normal(size=(3 * n, max(3, 2 * n)))
        arguments = {"G": A @ A.T / n, "g": rng.normal(size=3 * n), "mu": mu}
        found = sf.solve(sf.ContactProblem(**arguments))
        if found.solved:
            assert judge(read(arguments), found.forces).worst <= 1e-7, (n, mu)


def test_residuals_agree_with_the_judge() -> None:
    """What a solution states of itself is what the definition says."""
    for name in ("redundant", "unequal_loads", "spread", "decoupled", "compliant", "locked"):  # all w_k > 0
        for seed in range(600, 610):
            found = case(name, seed)
            assert found.truth == FEASIBLE
            data, rng = read(found.arguments), np.random.default_rng(seed)
            forces = sf.solve(sf.ContactProblem(**found.arguments)).forces
            forces = forces * (1.0 + 10.0 ** rng.uniform(-6, -1) * rng.normal(size=forces.shape))
            stated = residuals(sf.ContactProblem(**found.arguments), forces)
            verdict = judge(data, forces)
            share = np.divide(
                verdict.error, verdict.scale, out=np.zeros_like(verdict.error), where=verdict.scale > 0
            )
            assert stated.velocity_error == pytest.approx(share.max(), rel=1e-4, abs=1e-13), (name, seed)


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_one_solver_for_many_matrices(law: str) -> None:
    """Lawful, squeezed and meaningless problems in turn: the last answer must not colour the next."""
    rng = np.random.default_rng(8)
    mu = np.array([0.5, 0.8, 0.6])
    contacts = sf.ContactSolver(3, mu, law, max_iterations=500)  # type: ignore[arg-type]
    statuses = []
    for turn in range(120):
        lawful = feasible_case(rng, bodies_matrix(rng, 3, 1 + turn % 3)[2], {"mu": mu, "law": law})
        found = lawful if turn % 3 else squeezed_twins(rng, {"mu": mu, "law": law}, 3, 0.5)[1]
        scale = 10.0 ** rng.integers(-6, 7)
        found = rescaled(found, scale, 10.0 ** rng.integers(-6, 7))
        G, g = found.arguments["G"], found.arguments["g"]
        if turn % 10 == 9:
            g = np.full(9, np.nan)
        answer = contacts.solve(G, g)
        assert np.isfinite(answer.forces).all()
        statuses.append(answer.status.name)
        if turn % 10 == 9:
            assert answer.status is sf.Status.INVALID
            continue
        verdict = judge(read(found.arguments), answer.forces)
        assert not answer.solved or verdict.share <= 1e-7
        if answer.status is sf.Status.INFEASIBLE:
            assert (
                check_proof(read(found.arguments), answer.proof.direction, answer.proof.reach).fault is None
            )
    assert {"SOLVED", "INFEASIBLE", "INVALID"} <= set(statuses)
    assert statuses.count("SOLVED") >= 60


def test_a_problem_changed_in_place() -> None:
    """Arrays of a problem may be written to between solves; verdicts are about what they hold."""
    for seed in range(20):
        one, two = case("redundant", seed), case("redundant", seed + 100)
        n = min(len(x.arguments["g"]) for x in (one, two)) // 3
        cut = {"G": one.arguments["G"][: 3 * n, : 3 * n], "g": one.arguments["g"][: 3 * n], "mu": 0.5}
        problem = sf.ContactProblem(**cut)
        sf.solve(problem, max_time=0.1)
        problem.g[:] = two.arguments["g"][: 3 * n]
        problem.mu[:] = two.arguments["mu"][:n]
        problem.normal_max[: n // 2] = 0.3
        found = sf.solve(problem, max_time=0.1)
        now = {"G": problem.G, "g": problem.g, "mu": problem.mu, "normal_max": problem.normal_max}
        assert not found.solved or judge(read(now), found.forces).share <= 1e-7


def test_one_contact_without_a_figure_hides_no_other() -> None:
    """A speed whose inverse overflows came between a contact that falls and one that lifts: error 0."""
    problem = sf.ContactProblem(np.eye(9), [0, 0, -1.0, 0, 0, -1e-310, 0, 0, 1.0], 0.5)
    assert not residuals(problem, np.zeros((3, 3))).velocity_error < 0.5  # NaN is as good an answer
