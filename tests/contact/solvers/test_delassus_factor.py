"""A factor of G is a factor of G: sparse where contacts meet few others, dense where not, of its own rank."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from benchmarks.problems.contacts import stack, wall
from surefoot.contact.solvers import delassus_factor
from surefoot.contact.solvers.delassus_factor import find_factor, sparse_factor


def largest_miss(factor: object, G: np.ndarray) -> float:
    """Return how far Y Yᵀ is from G, over the largest entry of G."""
    Y = factor if isinstance(factor, np.ndarray) else factor.toarray()  # type: ignore[attr-defined]
    return float(np.abs(Y @ Y.T - G).max() / np.abs(G).max())


@pytest.mark.parametrize(
    "made",
    [stack(np.random.default_rng(0), 40, 0.6, 1.0, 0.2), wall(np.random.default_rng(0), 6, 6, 0.6, 1.0)],
)
def test_walls_and_stacks_have_a_sparse_one(made: sf.ContactProblem) -> None:
    problem = sf.ContactProblem(made.G, made.g, made.mu)  # G alone
    found = find_factor(problem, np.ones(problem.g.size, dtype=bool))
    assert found is not None
    Y, structure = found
    assert sp.issparse(Y)
    assert structure.sparse
    assert Y.shape[1] == np.linalg.matrix_rank(problem.G, tol=1e-9)
    assert largest_miss(Y, problem.G) <= 1e-10


def test_some_of_the_contacts_have_theirs() -> None:
    made = stack(np.random.default_rng(1), 40, 0.6, 1.0, 0.2)
    rows = np.repeat(np.arange(made.contacts) % 3 != 0, 3)
    Y = sparse_factor(sf.ContactProblem(made.G, made.g, made.mu), rows)
    assert largest_miss(Y, made.G[np.ix_(rows, rows)]) <= 1e-10


@pytest.mark.parametrize("seed", range(6))
def test_what_misses_g_is_not_taken(seed: int) -> None:
    """Of any semidefinite matrix the factor is near, or there is none; then a dense one takes its place."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(300, 150)) * 10.0 ** rng.uniform(-6.0, 0.0, size=150)
    problem = sf.ContactProblem(J @ J.T, rng.normal(size=300), 0.5)
    rows = np.ones(300, dtype=bool)
    Y = sparse_factor(problem, rows)
    assert Y is None or largest_miss(Y, problem.G) <= 1e-9
    found = find_factor(problem, rows)
    assert found is not None
    assert largest_miss(found[0], problem.G) <= 1e-9


def test_the_own_factor_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    made = stack(np.random.default_rng(0), 5, 0.6, 1.0, 0.2)
    rows = np.ones(made.g.size, dtype=bool)
    monkeypatch.setattr(delassus_factor, "sparse_factor", None)
    if made.factor is None:
        made.factor = np.linalg.cholesky(made.G + 1e-9 * np.eye(made.g.size))
    found = find_factor(made, rows)
    assert found is not None
    assert largest_miss(found[0], made.G) <= 1e-6


def test_heavy_ones_are_left() -> None:
    made = stack(np.random.default_rng(2), 40, 0.6, 1.0, 0.2)
    problem, rows = sf.ContactProblem(made.G, made.g, made.mu), np.ones(made.g.size, dtype=bool)
    assert find_factor(problem, rows, most=10.0) is None
    many = sf.ContactProblem(sp.identity(2400, format="csr"), np.zeros(2400), 0.5)
    assert sparse_factor(many, np.ones(2400, dtype=bool)) is None
