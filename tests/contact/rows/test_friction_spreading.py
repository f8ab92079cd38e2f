"""Loads of a sole's corners: the same on the body, inside every cone."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import CONE_ROWS, ROW_PENALTY
from surefoot.contact.rows.friction_spreading import spread_friction
from tests.contact.rows.reached import columns_of

MU = 0.6
CORNERS = np.array([[0.1, 0.03], [0.1, -0.03], [-0.07, -0.03], [-0.07, 0.03]])


def _sole() -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Return M, J, table and numbers of a plate on four corners, 0.05 m below its centre."""
    M = np.diag([2.0, 2.0, 2.0, 0.01, 0.02, 0.03])
    J = np.zeros((12, 6))
    for k, (x, y) in enumerate(CORNERS):
        # normal, then two tangents; columns: velocity and rate of turning
        J[3 * k] = [0.0, 0.0, 1.0, y, -x, 0.0]
        J[3 * k + 1] = [1.0, 0.0, 0.0, 0.0, -0.05, -y]
        J[3 * k + 2] = [0.0, 1.0, 0.0, 0.05, 0.0, x]
    G = np.diagonal(J @ np.linalg.solve(M, J.T)).reshape(4, 3)
    table = np.array([[CONE_ROWS, 3, 3 * k, 0] for k in range(4)])
    numbers = [[MU, 0.0, g.sum(), ROW_PENALTY / g[0], ROW_PENALTY / g[1:].max(), 0.0] for g in G]
    return M, J, table, np.array(numbers)


def _spread(x: FloatArray) -> FloatArray:
    M, J, table, numbers = _sole()
    out = x.copy()
    spread_friction(M, J, columns_of(J, table), table, numbers, out)
    return out


def _use(x: FloatArray) -> FloatArray:
    """Return the shares of the friction that is available, corner by corner."""
    forces = x.reshape(4, 3)
    return np.hypot(forces[:, 1], forces[:, 2]) / (MU * forces[:, 0])


def test_a_corner_at_its_border_is_relieved() -> None:
    """What the body feels stays, normal forces stay, friction follows them."""
    _, J, _, _ = _sole()
    rng = np.random.default_rng(0)
    for _ in range(50):
        x = np.zeros((4, 3))
        x[:, 0] = rng.uniform(0.05, 2.0, 4)
        angle = rng.uniform(-0.5, 0.5, 4)
        use = np.array([1.0, *rng.uniform(0.0, 0.3, 3)])  # the first corner slides, they say
        x[:, 1:] = (use * MU * x[:, 0])[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        after = _spread(x.ravel())
        scale = np.abs(J.T @ x.ravel()).max()
        np.testing.assert_allclose(J.T @ after, J.T @ x.ravel(), atol=2e-3 * scale)
        np.testing.assert_array_equal(after[::3], x[:, 0])
        assert _use(after).max() < _use(x.ravel()).max()
        # the least sum of x_t² / x_n: no other spread of the same load is evener
        assert ((after.reshape(4, 3)[:, 1:] ** 2).sum(1) / x[:, 0]).sum() <= (
            (x[:, 1:] ** 2).sum(1) / x[:, 0]
        ).sum() * (1.0 + 1e-9)


def test_what_all_slides_and_what_all_sticks_is_left_alone() -> None:
    """A sole that turns on the ground has friction at all borders: no load to be spread."""
    load = np.array([1.0, 0.4, 0.7, 0.2])
    for use in (1.0, 0.5):
        x = np.zeros((4, 3))
        x[:, 0] = load
        x[:, 1:] = (use * MU * load)[:, None] * np.column_stack([-CORNERS[:, 1], CORNERS[:, 0]])
        x[:, 1:] *= (use * MU * load / np.hypot(x[:, 1], x[:, 2]))[:, None]
        np.testing.assert_array_equal(_spread(x.ravel()), x.ravel())
    one_open = np.zeros((4, 3))
    one_open[0] = 1.0, MU, 0.0
    np.testing.assert_array_equal(_spread(one_open.ravel()), one_open.ravel())
