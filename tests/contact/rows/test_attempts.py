"""Starts of the solver of rows: what Newton's steps from the impulses at hand do not find."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import CONE_ROWS, ROW_PENALTY, STOP_ROW, solve_rows
from surefoot.contact.rows.sweeps import sweep_part
from tests.contact.rows.reached import columns_of


def _tables(dims: list[int], mu: float, G: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the tables of contacts (dim 3 and more) and stops (dim 1)."""
    table, numbers, at = [], [], 0
    for dim in dims:
        diagonal = np.diagonal(G)[at : at + dim]
        rest = max(diagonal[1:], default=1.0)
        table.append([CONE_ROWS if dim > 1 else STOP_ROW, dim, at, 0])
        numbers.append([mu, 0.0, diagonal.sum(), ROW_PENALTY / diagonal[0], ROW_PENALTY / rest, 0.0])
        at += dim
    return np.array(table, dtype=np.int64), np.array(numbers, dtype=np.float64)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_contact_that_catches_sticks(side: float) -> None:
    """Sliding its friction would drive it into the ground (Painlevé): the one solution is to stop it."""
    # the foot of a walker at mu 1.9: G_nn - mu G_nt < 0 for the way that it slides
    G = np.array([[0.42855, -0.31366 * side, 0.0], [-0.31366 * side, 0.74777, 0.0], [0.0, 0.0, 0.5]])
    free = np.array([-0.01127, -0.17162 * side, 0.0])
    table, numbers = _tables([3], 1.9, G)
    M, v, forces = np.linalg.inv(G), free.copy(), np.zeros(3)
    _, error, _ = solve_rows(
        M, v, np.eye(3), np.zeros(3), columns_of(np.eye(3), table), table, numbers, 1e-10, forces
    )
    assert error <= 1e-10
    np.testing.assert_allclose(forces, -np.linalg.solve(G, free), atol=1e-8)
    assert abs(forces[1]) < 1.9 * forces[0]


def test_two_contacts_of_a_foot_that_nearly_do_the_same() -> None:
    """Heel and toe share a planar foot's friction up to where one slides by a hair's breadth."""
    rng, missed = np.random.default_rng(11), 0
    for _ in range(300):
        heights = 0.1 + rng.uniform(0.0, 10.0 ** rng.uniform(-6.0, -3.0), 2)
        J = np.zeros((6, 3))
        for k, x in enumerate(rng.uniform(-0.2, 0.2, 2)):
            J[3 * k], J[3 * k + 1] = [0.0, 1.0, x], [1.0, 0.0, heights[k]]
        M = np.diag(rng.uniform(0.5, 3.0, 3)) + 0.3
        v = rng.normal(size=3) * [1.0, 1.0, 3.0]
        table, numbers = _tables(
            [3, 3], rng.uniform(0.5, 2.0), J @ np.linalg.solve(M, J.T) + 1e-12 * np.eye(6)
        )
        forces = np.zeros(6)
        _, error, speed = solve_rows(M, v, J, np.zeros(6), columns_of(J, table), table, numbers, 1e-8, forces)
        missed += error > 1e-6
        if error <= 1e-6:
            assert (J @ v)[[0, 3]].min() > -1e-6 * speed
            assert np.abs(forces[[1, 4]]).max() <= numbers[0, 0] * forces[[0, 3]].max() + 1e-9
    assert missed == 0


@pytest.mark.parametrize("mu", [0.5, 50.0])
def test_impulses_of_a_step_before_need_few_newton_steps(mu: float) -> None:
    """Four point feet that go on sticking, or sliding: up to three, where a start from nothing takes more."""
    rng, taken = np.random.default_rng(2), []
    for _ in range(20):
        root, J = rng.normal(size=(18, 18)), rng.normal(size=(12, 18))
        M, v, b = root @ root.T + np.eye(18), rng.normal(size=18), np.zeros(12)
        table, numbers = _tables([3, 3, 3, 3], mu, J @ np.linalg.solve(M, J.T))
        columns, forces = columns_of(J, table), np.zeros(12)
        cold = solve_rows(M, v.copy(), J, b, columns, table, numbers, 1e-8, forces)
        again = v + 1e-4 * rng.normal(size=18)
        warm = solve_rows(M, again, J, b, columns, table, numbers, 1e-8, forces)
        assert max(cold[1], warm[1]) <= 1e-8
        taken.append((cold[0], warm[0]))
    cold_steps, warm_steps = np.median(taken, axis=0)
    assert warm_steps <= 3 < cold_steps


def test_sweeps_alone_come_near_whatever_the_rows() -> None:
    """Stops, points and wide contacts: the velocities of the sweeps are close to the exact ones."""
    rng = np.random.default_rng(5)
    for _ in range(30):
        root, J = rng.normal(size=(14, 14)), rng.normal(size=(14, 14))
        M, v, b = root @ root.T + np.eye(14), rng.normal(size=14), np.zeros(14)
        table, numbers = _tables([1, 3, 4, 6], 0.4, J @ np.linalg.solve(M, J.T))
        exact, forces = v.copy(), np.zeros(14)
        assert solve_rows(M, exact, J, b, columns_of(J, table), table, numbers, 1e-9, forces)[1] <= 1e-6
        swept = np.zeros(14)
        sweep_part(M, v, J, b, table, numbers, 3000, swept)
        assert (swept[[0, 1, 4, 8]] >= 0.0).all()
        near = v + np.linalg.solve(M, J.T @ swept)
        assert np.linalg.norm(near - exact) < 0.05 * np.linalg.norm(v)
