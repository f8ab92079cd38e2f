from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from benchmarks.problems.contacts import Maker
from benchmarks.problems.heaps import capsules, cups, masonry, rocks
from surefoot.contact import ContactProblem
from surefoot.solvers.backends import ConeProgram, solve_program

SMALL: dict[str, tuple[Maker, int]] = {
    "capsules": (lambda r: capsules(r, 20, 50, 0.5), 50),
    "rocks": (lambda r: rocks(r, 12, 60, 0.6), 60),
    "rocks of mixed density": (lambda r: rocks(r, 12, 60, 0.6, ratio=1e3), 60),
    "cups": (lambda r: cups(r, 4, 12, 0.5, 0.02), 48),
    "masonry": (lambda r: masonry(r, 2, 3, 3, 0.6), 90),
}


def widest_opening(problem: ContactProblem) -> float:
    """Return the largest t <= 1 for which some motion opens all contacts by t inside the dual cones."""
    pytest.importorskip("clarabel")
    n = problem.contacts
    G = sp.csc_matrix(problem.G)
    order = np.array([[3 * k + 2, 3 * k, 3 * k + 1] for k in range(n)]).ravel()
    scale = sp.diags(np.column_stack([np.ones(n), problem.mu, problem.mu]).ravel())
    normal = sp.csc_matrix(np.tile([1.0, 0.0, 0.0], n)[:, None])
    cones = sp.hstack([-scale @ (G / abs(G).max())[order], normal])
    program = ConeProgram.of(
        sp.diags(np.append(np.full(3 * n, 1e-9), 0.0)), np.append(np.zeros(3 * n), -1.0),
        nonneg=(sp.eye(1, 3 * n + 1, 3 * n), [1.0]), second_order=(cones, np.zeros(3 * n)),
    )  # fmt: skip
    found = solve_program(program, tol=None)
    return float(found.x[-1])


@pytest.mark.parametrize("name", SMALL)
def test_all_contacts_can_open_strictly(name: str) -> None:
    maker, _ = SMALL[name]
    assert widest_opening(maker(np.random.default_rng(1))) > 1e-3
