"""The compiled central path against the interior point of `contact.derivative.central_path`."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.batch.central_path import follow_path, path_blocks
from surefoot.contact.derivative.central_path import central_path


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_the_point_and_its_derivative_are_those_of_the_interior_point(law: str) -> None:
    """Over twelve orders of magnitude of κ, with frictionless contacts among them."""
    rng = np.random.default_rng(0)
    for _ in range(150):
        n = int(rng.integers(1, 6))
        Z = rng.normal(size=(3 * n, 3 * n + 2))
        G, g = Z @ Z.T * 10.0 ** rng.uniform(-2, 1), rng.normal(size=3 * n) * 10.0 ** rng.uniform(-2, 1)
        mu = np.where(rng.random(n) < 0.1, 0.0, rng.uniform(0.0, 1.5, n))
        problem = sf.ContactProblem(G, g, mu, law=law)
        solution = sf.solve(problem, tol=1e-10)
        assert solution.solved
        kappa = float(10.0 ** rng.uniform(-10, 0) * np.abs(g).max() ** 2)
        forces, blocks = np.array(solution.forces), np.empty((3 * n, 4 * n))
        wanted = central_path(problem, solution.forces, kappa)
        assert follow_path(G, g, mu, law == "convex", kappa, forces)
        assert path_blocks(G, g, mu, law == "convex", kappa, forces, blocks)
        assert forces == pytest.approx(wanted.forces, abs=1e-10 * np.abs(forces).max())
        expected = wanted.after[0][:, : 4 * n]  # by g and by mu
        assert blocks == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_where_it_is_not_reached_it_says_so() -> None:
    G, g = np.full((3, 3), np.nan), np.array([0.1, 0.0, -1.0])
    assert not follow_path(G, g, np.array([0.5]), False, 1e-3, np.zeros((1, 3)))
