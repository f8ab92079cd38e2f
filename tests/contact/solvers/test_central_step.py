"""A compiled step along the central path solves the linearised equations and stays inside the cones."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.contact.solvers.central_step import Iterate, Scaling, central_step, fill_residual
from surefoot.contact.solvers.cone_pairs import centrality, scale_pairs
from surefoot.contact.solvers.reduced_structure import find_structure
from surefoot.contact.solvers.reduced_system import ReducedSystem

NOTHING = np.empty(0)


def inside(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) strictly inside their cones, and how far (n,)."""
    points = rng.normal(size=(n, 3))
    border = rng.uniform(0.1, 1.0, n)
    points[:, 2] = np.hypot(points[:, 0], points[:, 1]) + border
    return points, border


@pytest.mark.parametrize("share", [0.0, 1.0])
@pytest.mark.parametrize("r", [4, 30])
def test_a_step_leaves_its_share_of_the_residual(share: float, r: int) -> None:
    """The equations of a held shift are linear: a step of length t leaves 1 - t of what was wrong."""
    rng = np.random.default_rng(r)
    n = 12
    rows = rng.normal(size=(3 * n, r))
    (x, border_x), (y, border_y) = inside(rng, n), inside(rng, n)
    g, shift, speed = rng.normal(size=(n, 3)), rng.uniform(0.0, 1.0, n), np.ones(n)

    def left(x: np.ndarray, y: np.ndarray, out: np.ndarray) -> float:
        u = (rows @ (rows.T @ x.ravel())).reshape(n, 3) + g
        lift = NOTHING if share else shift
        return float(fill_residual(y, np.ones((n, 3)), u, lift, speed, out))

    point = Iterate(x, border_x, y, border_y)
    scaling = Scaling(np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3, 3)))
    gap = scale_pairs(*point, share, *scaling)
    residual, rest = np.empty((n, 3)), np.empty((n, 3))
    assert left(x, y, residual) == np.abs(residual).max()
    system = ReducedSystem(rows, np.ones((n, 3)), find_structure(rows))
    factors = system.factorise(scaling.weights)
    assert factors is not None
    after = Iterate(np.empty_like(x), np.empty(n), np.empty_like(y), np.empty(n))
    length = central_step(factors, system.rows, point, residual, scaling, gap, share, 0.3, after)
    assert 0.0 < length <= 1.0
    assert (after[1] > 0.0).all()
    assert (after[3] > 0.0).all()
    assert centrality(*after) >= 1e-2
    left(after[0], after[2], rest)
    wanted = (1.0 - length) * residual
    if share:  # what is not linear is the length of the tangents: its second order is left
        bent = np.hypot(*after[2][:, :2].T) - np.hypot(*y[:, :2].T)
        turned = np.sum(y[:, :2] * (after[2] - y)[:, :2], axis=1) / np.hypot(*y[:, :2].T)
        wanted[:, 2] -= bent - turned
    np.testing.assert_allclose(rest, wanted, atol=1e-10 * max(1.0, np.abs(rows).max() ** 2))
