"""Proofs of infeasibility: what counts, what does not, and that they are found."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import NoSolution
from surefoot.contact.solvers.infeasibility import find_proof


def walls(approach: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A point mass between two walls that both come nearer at this speed."""
    J = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0], [0, -1, 0], [0, 0, -1]])
    return J @ J.T, np.array([0, 0, -approach, 0, 0, -approach])


def exact_reach(G: np.ndarray, g: np.ndarray, d: np.ndarray) -> float:
    """|g·d| over the largest ||(G d)_k||, in rational arithmetic of the numbers given."""
    exact = [[Fraction(x) for x in row] for row in G.tolist()]
    direction = [Fraction(x) for x in d.ravel().tolist()]
    work = sum(Fraction(x) * y for x, y in zip(g.tolist(), direction, strict=True))
    drift = [sum(a * b for a, b in zip(row, direction, strict=True)) for row in exact]
    worst = max(sum(x * x for x in drift[k : k + 3]) for k in range(0, len(drift), 3))
    assert work < 0
    return float(np.inf) if worst == 0 else float(-work) / float(worst) ** 0.5


@pytest.mark.parametrize("law", ["coulomb", "convex"])
@pytest.mark.parametrize("facets", [None, 4])
def test_a_squeezed_mass(law: str, facets: int | None) -> None:
    G, g = walls()
    problem = sf.ContactProblem(G, g, 0.5, law=law, facets=facets)  # type: ignore[arg-type]
    found = sf.solve(problem)
    assert found.status is sf.Status.INFEASIBLE
    assert found.proof is not None
    assert found.proof.conclusive
    assert found.proof.reach <= exact_reach(problem.G, g, found.proof.direction) * (1 + 1e-12)
    with pytest.raises(NoSolution):
        found.raise_if_failed()
    G, g = walls(-1e-6)  # the walls give way
    assert sf.solve(sf.ContactProblem(G, g, 0.5, law=law, facets=facets)).solved  # type: ignore[arg-type]


def test_what_a_direction_may_be() -> None:
    """Signs, tangents and bounded contacts are taken out before anything is claimed."""
    G, g = walls()
    problem = sf.ContactProblem(G, g, 0.5)
    good = sf.check_proof(problem, np.array([[0, 0, 2.0], [0, 0, 2.0]]))
    assert good is not None
    assert good.direction.tolist() == [[0, 0, 1.0], [0, 0, 1.0]]
    assert good.work == pytest.approx(-2.0)
    for bad in ([[0, 0, -1.0], [0, 0, -1.0]], [[1.0, 0, 0], [-1.0, 0, 0]], [[np.nan] * 3] * 2):
        assert sf.check_proof(problem, np.array(bad)) is None
    short = sf.check_proof(problem, np.array([[0, 0, 1.0], [0, 0, 0.5]]))
    assert short is not None
    assert not short.conclusive
    bounded = problem.replace(normal_max=[10.0, np.inf])
    one_sided = sf.check_proof(bounded, good.direction)
    assert one_sided is None or not one_sided.conclusive
    assert find_proof(bounded) is None
    assert sf.solve(bounded).status is not sf.Status.INFEASIBLE


@pytest.mark.long
def test_random_proofs_are_found_and_hold() -> None:
    """Rank-deficient contacts whose pushes cancel, part of them bilateral, beside a part that is well."""
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(40):
        n = int(rng.integers(2, 9))
        J = rng.normal(size=(3 * n, 6))
        held = rng.random(n) < 0.3
        d = np.zeros((n, 3))
        d[:, 2] = rng.uniform(0.2, 2.0, n)
        d[held] = rng.normal(size=(int(held.sum()), 3))
        last = np.flatnonzero(~held)[-1] if not held.all() else 0
        rest = d.copy()
        rest[last, 2] = 0.0
        J[3 * last + 2] = -(rest.ravel() @ J) / d[last, 2]
        G = np.zeros((3 * n + 3, 3 * n + 3))
        G[:-3, :-3], G[-3:, -3:] = J @ J.T, np.eye(3)
        g = np.append(J @ rng.normal(size=6) - 10.0 ** rng.uniform(-3, 0) * d.ravel(), [0.0, 0.0, -1e3])
        problem = sf.ContactProblem(G, g, rng.uniform(0, 1, n + 1), bilateral=np.append(held, False))
        solution = sf.solve(problem)
        assert not solution.solved
        if solution.proof is not None:
            assert solution.status is sf.Status.INFEASIBLE
            assert solution.proof.reach <= exact_reach(problem.G, g, solution.proof.direction) * (1 + 1e-12)
            assert not solution.proof.direction[-1].any()
            found += 1
    assert found >= 38


def test_none_is_found_where_there_is_a_solution() -> None:
    rng = np.random.default_rng(6)
    for _ in range(30):
        n = int(rng.integers(1, 8))
        J = rng.normal(size=(3 * n, 6))
        forces = np.zeros((n, 3))
        forces[:, 2] = rng.uniform(0.0, 1.0, n) * (rng.random(n) < 0.6)
        u = np.zeros((n, 3))
        u[:, 2] = np.where(forces[:, 2] > 0.0, 0.0, rng.random(n))
        G = J @ J.T
        for law in ("coulomb", "convex"):
            assert find_proof(sf.ContactProblem(G, u.ravel() - G @ forces.ravel(), 0.5, law=law)) is None
