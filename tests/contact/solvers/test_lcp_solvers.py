from __future__ import annotations

import itertools

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import NoSolution, SolverNotFound
from surefoot.contact.solvers.lcp_proof import farkas

ALL = ("lemke", "interior_point")


def enumerated(lcp: sf.LCP) -> list[np.ndarray]:
    """All solutions with a regular basis, by trying every set of positive z."""
    found = []
    for active in itertools.product([False, True], repeat=lcp.size):
        on = np.array(active)
        z = np.zeros(lcp.size)
        if on.any():
            try:
                z[on] = np.linalg.solve(lcp.M[np.ix_(on, on)], -lcp.q[on])
            except np.linalg.LinAlgError:
                continue
        if (z >= -1e-12).all() and (lcp.M @ z + lcp.q >= -1e-12).all():
            found.append(z)
    return found


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("skew", [0.0, 1.0])
def test_positive_definite_problems_have_the_one_solution_symmetric_or_not(name: str, skew: float) -> None:
    for seed in range(10):
        rng = np.random.default_rng(seed)
        J, K = rng.normal(size=(2, 7, 7))
        lcp = sf.LCP(J @ J.T + 0.3 * np.eye(7) + skew * (K - K.T), rng.normal(size=7))
        found = sf.solve_lcp(lcp, name, 1e-9).raise_if_failed()
        assert np.allclose(found.z, enumerated(lcp)[0], atol=1e-6)
        assert np.allclose(found.w, lcp.slack(found.z))


def test_lemke_on_p_matrices_and_ties() -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        M = np.triu(rng.integers(-2, 3, size=(6, 6)).astype(float), 1) + np.eye(6)  # a P-matrix
        lcp = sf.LCP(M, -rng.integers(0, 3, size=6).astype(float))
        assert np.allclose(sf.solve_lcp(lcp).raise_if_failed().z, enumerated(lcp)[0], atol=1e-9)


def test_exponential_pivoting_ends() -> None:
    """Murty's example takes Lemke 2^n pivots, and n = 10 still ends; a bound on pivots is kept and told."""
    for n in (4, 6, 10):
        M = np.tril(np.full((n, n), 2.0), -1) + np.eye(n)
        lcp = sf.LCP(M, -np.ones(n))
        found = sf.solve_lcp(lcp, max_iterations=5000).raise_if_failed()
        assert found.iterations == 2**n
        assert found.z == pytest.approx(np.eye(n)[0])
    short = sf.solve_lcp(
        sf.LCP(np.tril(np.full((12, 12), 2.0), -1) + np.eye(12), -np.ones(12)), max_iterations=50
    )
    assert short.status is sf.Status.MAX_ITERATIONS


def test_infeasible_problems_are_proved_so() -> None:
    lcp = sf.LCP([[0.0, 1.0], [-1.0, 0.0]], [1.0, -2.0])  # w_2 = -z_1 - 2
    found = sf.solve_lcp(lcp)
    assert found.status is sf.Status.INFEASIBLE
    v = found.proof
    assert v is not None
    assert (lcp.M.T @ v <= 0.0).all()
    assert lcp.q @ v < 0
    with pytest.raises(NoSolution, match="along a ray"):
        found.raise_if_failed()
    assert not sf.solve_lcp(lcp, "interior_point").solved


@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("guess", [[5e-324, 0.0], [1.7e308, 0.0], [0.0, 0.0], [np.inf, 1.0], [np.nan, 1.0]])
def test_a_proof_is_found_whatever_is_guessed(scale: float, guess: list[float]) -> None:
    """Guesses that vanish or overflow in the scale of the problem are as good as none."""
    lcp = sf.LCP(scale * np.array([[0.0, 1.0], [-1.0, 0.0]]), [1.0, -2.0])
    with np.errstate(all="raise"):
        v = farkas(lcp, np.array(guess))
    assert v is not None
    assert np.isfinite(v).all()
    assert (v >= 0.0).all()
    assert (lcp.M.T @ v <= 0.0).all()
    assert lcp.q @ v < 0


def test_a_ray_without_proof_is_not_called_infeasible() -> None:
    """A bimatrix game (solvable) on which Lemke's first pivot meets a ray."""
    lcp = sf.LCP([[0, 0, 10, 30], [0, 0, 20, 15], [10, 30, 0, 0], [20, 15, 0, 0]], [-1.0, -1, -1, -1])
    assert enumerated(lcp)
    found = sf.solve_lcp(lcp)
    assert found.status is sf.Status.STALLED
    assert "ray" in found.message
    assert found.ray is not None
    assert found.proof is None


def test_unknown_names_and_empty_problems() -> None:
    with pytest.raises(SolverNotFound, match="valid names: interior_point, lemke"):
        sf.solve_lcp(sf.LCP([[1.0]], [1.0]), "simplex")
    assert sf.solve_lcp(sf.LCP(np.zeros((0, 0)), [])).solved
    assert sf.solve_lcp(sf.LCP([[1.0]], [1.0])).z.tolist() == [0.0]


def test_friction_on_one_problem_polyhedral_and_exact() -> None:
    """Lemke's pyramid answer is near the exact one, and the nearer the finer the pyramid."""
    rng = np.random.default_rng(8)
    J = rng.normal(size=(9, 12))
    problem = sf.ContactProblem(J @ J.T, np.tile([0.5, 0.2, -1.0], 3), 0.5)
    exact = sf.solve(problem).raise_if_failed().forces
    gaps = [
        np.linalg.norm(sf.solve(problem.polyhedral(k), "lemke").raise_if_failed().forces - exact)
        for k in (4, 16)
    ]
    assert gaps[1] < 0.3 * gaps[0]
