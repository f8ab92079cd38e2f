"""Normal forces that friction drives, as in Painlevé's rod: problems whose solution is known beforehand."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.solution import Status


def coupled(rng: np.random.Generator) -> sf.ContactProblem:
    """Return a problem made from its solution: open, sticking, sliding contacts; tangents follow normals."""
    n, mu = int(rng.choice([1, 2, 3, 4, 6, 8, 12])), float(rng.choice([0.5, 1.0, 2.0, 3.0, 10.0]))
    coupling, rank = float(rng.choice([1.0, 2.0, 4.0, 10.0, 50.0])), 3 * n
    if rng.random() < 0.5:
        rank = max(3, int(2.1 * n))
    A = rng.normal(size=(n, 3, rank))
    way = rng.uniform(0.0, 2.0 * np.pi, n)
    for k, size in enumerate(coupling * rng.uniform(0.5, 2.0, n)):
        for axis, share in enumerate((np.cos(way[k]), np.sin(way[k]))):
            A[k, axis] = size * share * A[k, 2] + 0.2 * rng.normal(size=rank)
    forces, velocities = np.zeros((n, 3)), np.zeros((n, 3))
    for f, u, mode in zip(forces, velocities, rng.integers(3, size=n), strict=True):
        a = rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(a), np.sin(a)])
        if mode == 0:
            u[:] = *rng.normal(size=2), rng.uniform(0.01, 2.0)
            continue
        f[2] = rng.uniform(0.2, 2.0)
        f[:2] = mu * f[2] * along * (1.0 if mode == 2 else rng.uniform(0.0, 0.9))
        u[:2] = -along * rng.uniform(0.1, 2.0) * (mode == 2)
    G = A.reshape(3 * n, rank) @ A.reshape(3 * n, rank).T / rank
    return sf.ContactProblem(G, velocities.ravel() - G @ forces.ravel(), mu)


@pytest.mark.parametrize(
    ("count", "least"), [(36, 30), pytest.param(180, 150, marks=pytest.mark.long)], ids=["36", "180"]
)
def test_five_of_six_are_solved_and_none_is_called_infeasible(count: int, least: int) -> None:
    rng, solved = np.random.default_rng(52), 0
    for _ in range(count):
        problem = coupled(rng)
        solution = sf.solve(problem)
        assert solution.status is not Status.INFEASIBLE
        solved += solution.status is Status.SOLVED
        if solution.status is Status.SOLVED:
            assert sf.residuals(problem, solution.forces).velocity_error < 1e-6
    print(f"\n{solved} of {count}")
    assert solved >= least
