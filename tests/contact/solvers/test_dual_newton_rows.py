"""The proof that no force keeps the rows, against many forces."""

import numpy as np
import pytest

from surefoot.contact.solvers.dual_newton import dense as newton
from surefoot.contact.solvers.dual_newton import distribution_memory as layout
from surefoot.contact.solvers.dual_newton import row_proofs as proofs
from surefoot.contact.solvers.dual_newton import rows as rows_of


def loaded(seed, n=4, count=2):
    """Return a random program with rows: T (count, 3n), limits, and its work arrays, loaded."""
    rng = np.random.default_rng(seed)
    T = rng.normal(size=(count, 3 * n))
    low, high = -rng.uniform(0.5, 2.0, count), rng.uniform(0.5, 2.0, count)
    work = layout.new_work(n)
    unit_t, unit_n = rng.uniform(0.5, 3.0, (2, n))
    work[:n, layout.TANGENT], work[:n, layout.NORMAL] = unit_t, unit_n
    work[:n, layout.MU] = rng.uniform(0.1, 1.0, n) * unit_n / unit_t
    work[:n, layout.LOW], work[:n, layout.HIGH] = 0.5, 4.0
    work[:n, layout.BLOCK : layout.BLOCK + 18] = rng.normal(size=(n, 18))
    work[:n, layout.CENTRE : layout.CENTRE + 3] = rng.normal(size=(n, 3))
    work[n, layout.ROOT : layout.ROOT + 6] = rng.uniform(0.5, 2.0, 6)
    arrays = rows_of.rows_work(n, count)
    w = rng.normal(size=6)
    rows_of._load_rows(w, np.ascontiguousarray(T.T), low, high, work, arrays[:5], arrays[5], 0.0)
    units = np.column_stack([unit_t, unit_t, unit_n]).ravel()
    return T, low, high, units, w, work, arrays


@pytest.mark.parametrize("seed", range(30))
def test_proof_of_emptiness_is_one(seed):
    """The direction separates exactly if the best of many forces cannot reach the best of the limits."""
    T, low, high, units, _, work, (columns, sets, _, _, _, rows) = loaded(seed)
    rng = np.random.default_rng(50 + seed)
    direction = rng.normal(size=2)
    offset = rng.uniform(-60.0, 60.0)
    sets[4:, newton.LOW] += offset * rows[:, proofs.LIGHT]
    sets[4:, newton.HIGH] += offset * rows[:, proofs.LIGHT]
    rows[:, proofs.MOVED] = direction
    angle = np.linspace(0.0, 2.0 * np.pi, 2000)
    pull = (T.T @ direction * units).reshape(4, 3)
    most = 0.0
    for k in range(4):
        mu = work[k, layout.MU]
        circle = np.column_stack([mu * np.cos(angle), mu * np.sin(angle), np.ones(2000)])
        top = max((z * circle @ pull[k]).max() for z in (0.5, 4.0))
        most += top
    least = np.sum(np.minimum(direction * (low + offset), direction * (high + offset)))
    if abs(most - least) > 1e-3:
        assert proofs.proves_empty(columns, sets, rows) == (most < least)
