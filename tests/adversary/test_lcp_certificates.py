"""Attempts to make LCP verdicts lie; the judge computes with exact rationals and shares no code with them."""

from __future__ import annotations

from collections import Counter
from fractions import Fraction

import numpy as np
import pytest

import surefoot as sf

Rows = list[list[Fraction]]


def exact(lcp: sf.LCP) -> tuple[Rows, list[Fraction]]:
    """The problem's numbers as the rationals that they are."""
    return [[Fraction(float(x)) for x in row] for row in lcp.M], [Fraction(float(x)) for x in lcp.q]


def no_solution_proven(lcp: sf.LCP, v: np.ndarray | None) -> bool:
    """Farkas: v >= 0, each column of M weighed by v is <= 0, and q weighed by v is < 0."""
    if v is None:
        return False
    M, q = exact(lcp)
    y = [Fraction(float(x)) for x in v]
    columns = [sum((M[i][j] * y[i] for i in range(len(y))), Fraction(0)) for j in range(len(y))]
    return min(y) >= 0 and max(columns) <= 0 and sum(a * b for a, b in zip(q, y, strict=True)) < 0


def exact_error(lcp: sf.LCP, z: np.ndarray) -> float:
    """The largest |min(m z_i, w_i)| over the largest |q|, for a problem that is one part."""
    M, q = exact(lcp)
    x = [Fraction(float(value)) for value in z]
    w = [sum((a * b for a, b in zip(row, x, strict=True)), c) for row, c in zip(M, q, strict=True)]
    m = max(abs(a) for row in M for a in row)
    return float(max(abs(min(m * a, b)) for a, b in zip(x, w, strict=True)) / max(abs(c) for c in q))


def positive_definite(seed: int, spread: float, condition: float) -> sf.LCP:
    """A positive definite matrix whose rows and columns are scaled over `spread` decades."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    Q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    A = Q @ np.diag(10.0 ** -rng.uniform(0.0, condition, size=n)) @ Q.T
    D = 10.0 ** rng.uniform(-spread / 2, spread / 2, size=n)
    q = rng.normal(size=n) * (D if seed % 2 else 10.0 ** rng.uniform(-3, 3))
    M = D[:, None] * (A + A.T) * D
    return sf.LCP(0.5 * (M + M.T), q)


@pytest.mark.parametrize(
    ("spread", "condition", "least"), [(4, 2, 1.0), (10, 6, 0.7), (40, 10, 0.3), (240, 12, 0.1)]
)
@pytest.mark.sampled(2)
def test_positive_definite_problems_are_never_called_infeasible(
    spread: float, condition: float, least: float
) -> None:
    found: Counter[sf.Status] = Counter()
    for seed in range(120):
        lcp = positive_definite(seed, spread, condition)
        for name in ("lemke", "interior_point") if seed < 20 else ("lemke",):
            solution = sf.solve_lcp(lcp, name)
            assert solution.status not in (sf.Status.INFEASIBLE, sf.Status.INVALID), (seed, name)
            assert np.isfinite(solution.z).all(), (seed, name)
            if solution.solved:
                assert exact_error(lcp, solution.z) <= 2e-8, (seed, name)
        found[sf.solve_lcp(lcp).status] += 1
    assert found[sf.Status.SOLVED] >= least * sum(found.values()), found


def contradiction(seed: int, spread: float) -> sf.LCP:
    """The optimality conditions of a quadratic program whose inequalities contradict each other."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    J = rng.normal(size=(n, n))
    A, b = rng.normal(size=(m, n)), rng.normal(size=m)
    # y . A <= 0 and y . b > 0 for some y >= 0: A x >= b has no x >= 0
    y = rng.uniform(0.1, 1.0, size=m)
    A[-1] = (-(y[:-1] @ A[:-1]) - rng.uniform(0.01, 1.0, size=n)) / y[-1]
    b[-1] = (-(y[:-1] @ b[:-1]) + rng.uniform(0.01, 1.0)) / y[-1]
    M = np.block([[J @ J.T, -A.T], [A, np.zeros((m, m))]])
    q = np.concatenate([rng.normal(size=n), -b])
    D = 2.0 ** np.round(rng.uniform(-spread / 2, spread / 2, size=n + m))
    order = rng.permutation(n + m)
    return sf.LCP((D[:, None] * M * D)[np.ix_(order, order)], (D * q)[order])


@pytest.mark.parametrize("spread", [0.0, 12.0, 60.0])
def test_contradictions_are_proven(spread: float) -> None:
    """Hardly one is left unproven, none is solved, and every proof holds for the numbers as they are."""
    proven = 0
    for seed in range(80):
        lcp = contradiction(seed, spread)
        solution = sf.solve_lcp(lcp)
        assert not solution.solved, seed
        if solution.status is sf.Status.INFEASIBLE:
            proven += 1
            assert no_solution_proven(lcp, solution.proof), seed
        else:
            assert solution.proof is None
    assert proven >= 76


def test_whole_numbers_have_whole_proofs() -> None:
    """Symmetric and singular: M v = 0 must hold exactly, with v known to rounding only at first."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 7))
        v = rng.integers(1, 5, size=n)
        B = rng.integers(-3, 4, size=(n, n)).astype(float)
        B[:, -1], B[:, :-1] = -(B[:, :-1] @ v[:-1]), B[:, :-1] * v[-1]  # B v = 0
        lcp = sf.LCP(B.T @ B, -rng.integers(1, 9, size=n).astype(float))
        solution = sf.solve_lcp(lcp)
        assert solution.status is sf.Status.INFEASIBLE, (seed, solution.status, solution.message)
        assert no_solution_proven(lcp, solution.proof), seed


def test_what_is_singular_up_to_rounding_is_not_proven() -> None:
    """The rounded matrix may have a solution at 1e16: neither solved nor, unproven, infeasible."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        v = rng.uniform(0.1, 1.0, size=4)
        J = rng.normal(size=(4, 4))
        J -= np.outer(J @ v, v) / (v @ v)
        lcp = sf.LCP(J.T @ J, -rng.uniform(0.1, 1.0, size=4))
        solution = sf.solve_lcp(lcp)
        assert not solution.solved, seed
        if solution.status is sf.Status.INFEASIBLE:
            assert no_solution_proven(lcp, solution.proof), seed


def test_solvable_problems_of_any_kind_are_never_called_infeasible() -> None:
    for seed in range(200):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 7))
        M = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-6, 6, size=(n, 1))
        M[rng.uniform(size=(n, n)) < 0.3] = 0.0
        on = rng.uniform(size=n) < 0.5
        q = np.where(on, 0.0, rng.uniform(0.1, 1.0, size=n)) - M @ np.where(on, rng.uniform(size=n), 0.0)
        for name in ("lemke", "interior_point"):
            assert sf.solve_lcp(sf.LCP(M, q), name).status is not sf.Status.INFEASIBLE, (seed, name)


def test_a_claimed_proof_must_hold_in_every_row() -> None:
    lcp = sf.LCP([[0.0191, -550.0], [-550.0, 3.6e7]], [-90.0, 20.0])
    assert not lcp.proves_infeasible([1.0, 1.5e-5])  # M' v = (0.0109, -10): small beside 3.6e7, yet positive
    tight = sf.LCP([[0.0, 1.0], [-1.0, 1e-300]], [1.0, -2.0])
    assert not tight.proves_infeasible([0.0, 1.0])  # by 1e-300
    assert not tight.proves_infeasible([np.nan, 1.0])
    assert not tight.proves_infeasible([-1e-300, 1.0])
    assert not tight.proves_infeasible([0.0, 0.0])
    assert sf.LCP([[0.0, 1.0], [-1.0, 0.0]], [1.0, -2.0]).proves_infeasible([0.0, 1e-300])
    huge = sf.LCP([[-1e308, 1e308], [1e308, -1e308]], [-1e308, 1e-308])
    assert huge.proves_infeasible([1e308, 1e308])
    assert not sf.LCP(huge.M, [-1e-308, 1e308]).proves_infeasible([1e308, 1e308])


def test_an_unrelated_part_hides_nothing() -> None:
    """1e12 beside 1: the small part has no solution, or a wrong answer, and that is what is said."""
    M = np.diag([1.0, 0.0])
    solution = sf.solve_lcp(sf.LCP(M, [-1e12, -1.0]))
    assert solution.status is sf.Status.INFEASIBLE
    assert no_solution_proven(solution.problem, solution.proof)
    lcp = sf.LCP(np.eye(2), [-1e12, -1.0])
    assert lcp.residual([1e12, 0.0]) == pytest.approx(1.0)
    assert sf.solve_lcp(lcp).z.tolist() == [1e12, 1.0]


def test_answers_that_rounding_swallows_are_not_solved() -> None:
    """w = 1e9 z_1 - 1e9 z_2 - 1 with z near 1e16: what double precision makes of it proves nothing."""
    lcp = sf.LCP([[1.0, -1.0], [-1.0, 1.0 + 2.0**-52]], [-1.0, -1.0])
    solution = sf.solve_lcp(lcp)
    assert not solution.solved
    assert solution.status is not sf.Status.INFEASIBLE
    assert lcp.rounding([1e16, 1e16]) > 1.0


@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-150, 1e150, 1e300, 1e308])
@pytest.mark.parametrize("name", ["lemke", "interior_point"])
def test_extreme_sizes_end_in_a_verdict(scale: float, name: str) -> None:
    for M, q in (
        (np.array([[2.0, 1.0], [1.0, 2.0]]) * min(scale, 5e307), [-5.0, -6.0]),
        (np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-0.5, -0.6]) * scale),
        (np.array([[scale, 1.0], [-1.0, 1.0 / max(scale, 1e-300)]]), [-1.0, -1.0]),
    ):
        solution = sf.solve_lcp(sf.LCP(M, q), name, max_iterations=500)
        assert np.isfinite(solution.z).all()
        assert solution.status is not sf.Status.INFEASIBLE
        if solution.solved:
            assert exact_error(solution.problem, solution.z) <= 2e-8


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused(bad: float) -> None:
    with pytest.raises(sf.ProblemError, match=r"M\[0, 1\] is"):
        sf.LCP([[1.0, bad], [0.0, 1.0]], [1.0, 1.0])
    with pytest.raises(sf.ProblemError, match=r"q\[1\] is"):
        sf.LCP(np.eye(2), [1.0, bad])
