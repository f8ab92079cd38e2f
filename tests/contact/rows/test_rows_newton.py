"""Rows solved in velocities against the solver of forces, random mechanisms and hard cases."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact import (
    CONE_ROWS,
    DRY_ROW,
    HELD_ROW,
    ROW_PENALTY,
    SOFT_ROWS,
    STOP_ROW,
    solve_rows,
)
from tests.contact.rows.reached import columns_of


def _tables(kinds: list[tuple[int, int, float, float]], G: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the tables of blocks (kind, rows, mu, limit)."""
    table, numbers, at = [], [], 0
    for kind, dim, mu, limit in kinds:
        diagonal = np.diagonal(G)[at : at + dim]
        rest = max(diagonal[1:], default=1.0)
        table.append([kind, dim, at, 0])
        numbers.append([mu, limit, diagonal.sum(), ROW_PENALTY / diagonal[0], ROW_PENALTY / rest, 0.0])
        at += dim
    return np.array(table, dtype=np.int64), np.array(numbers, dtype=np.float64)


def _mechanism(rng: np.random.Generator, n: int, m: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    root = rng.normal(size=(n, n))
    return root @ root.T + 0.5 * np.eye(n), rng.normal(size=(m, n)), rng.normal(size=n)


def test_points_are_those_of_the_solver_of_forces() -> None:
    """Random point contacts: velocities and certificate of `sf.solve`, whose arithmetic is another."""
    rng, unsolved = np.random.default_rng(3), 0
    for _ in range(60):
        n, count = int(rng.integers(6, 14)), int(rng.integers(1, 5))
        M, J, v = _mechanism(rng, n, 3 * count)
        G = J @ np.linalg.solve(M, J.T)
        mu = rng.uniform(0.1, 0.9, count)
        table, numbers = _tables([(CONE_ROWS, 3, float(m), 0.0) for m in mu], G)
        free, forces = v.copy(), np.zeros(3 * count)
        _, error, _ = solve_rows(
            M, free, J, np.zeros(3 * count), columns_of(J, table), table, numbers, 1e-9, forces
        )
        unsolved += error > 1e-8
        if error > 1e-8:
            continue
        # (normal, tangents) here, (tangents, normal) there
        order = np.concatenate([[3 * k + 1, 3 * k + 2, 3 * k] for k in range(count)])
        problem = sf.ContactProblem(0.5 * (G + G.T)[np.ix_(order, order)], (J @ v)[order], mu)
        judged = sf.residuals(problem, forces[order].reshape(-1, 3))
        assert judged.velocity_error < 1e-7
        np.testing.assert_allclose(free, v + np.linalg.solve(M, J.T @ forces), atol=1e-9)
    # rows of numbers without a mechanism: normals and tangents tied more than any body ties them
    assert unsolved <= 6


def test_every_kind_keeps_its_law() -> None:
    """Joints do not move, dry rows and stops are complementary, wide cones dissipate the most."""
    rng = np.random.default_rng(4)
    kinds = [
        (HELD_ROW, 1, 0.0, 0.0), (DRY_ROW, 1, 0.0, 0.05), (STOP_ROW, 1, 0.0, 0.0), (CONE_ROWS, 4, 0.5, 0.0),
        (CONE_ROWS, 6, 0.3, 0.0),
    ]  # fmt: skip
    rows = sum(kind[1] for kind in kinds)
    for _ in range(60):
        M, J, v = _mechanism(rng, 16, rows)
        table, numbers = _tables(kinds, J @ np.linalg.solve(M, J.T))
        free, forces = v.copy(), np.zeros(rows)
        _, error, speed = solve_rows(
            M, free, J, np.zeros(rows), columns_of(J, table), table, numbers, 1e-10, forces
        )
        assert error <= 1e-9
        u, tol = J @ free, 1e-7 * speed
        assert abs(u[0]) < tol
        assert abs(forces[1]) <= 0.05 * (1 + 1e-12)
        assert abs(u[1]) < tol or forces[1] * u[1] < 0.0
        assert min(forces[2], u[2]) > -tol
        assert abs(forces[2] * u[2]) < 1e-7
        for first, dim, mu in ((3, 4, 0.5), (7, 6, 0.3)):
            f, w = forces[first : first + dim], u[first : first + dim]
            assert np.linalg.norm(f[1:]) <= mu * f[0] + 1e-9
            assert w[0] > -tol
            assert abs(f[0] * w[0]) < 1e-7
            assert f[1:] @ w[1:] == pytest.approx(-mu * f[0] * np.linalg.norm(w[1:]), abs=1e-7)


def test_redundant_rows_share_and_contradicting_ones_are_told() -> None:
    """Twice the same row is one of them; rows that ask for two velocities leave the error they must."""
    M, row = np.diag([2.0, 1.0]), np.array([[1.0, 0.0], [1.0, 0.0]])
    table, numbers = _tables([(HELD_ROW, 1, 0.0, 0.0)] * 2, row @ np.linalg.solve(M, row.T))
    v, forces = np.array([1.0, 1.0]), np.zeros(2)
    _, error, _ = solve_rows(M, v, row, np.zeros(2), columns_of(row, table), table, numbers, 1e-10, forces)
    assert error <= 1e-10
    np.testing.assert_allclose(forces, [-1.0, -1.0], atol=1e-8)
    v, forces = np.array([1.0, 1.0]), np.zeros(2)
    _, error, _ = solve_rows(
        M, v, row, np.array([0.5, -0.5]), columns_of(row, table), table, numbers, 1e-10, forces
    )
    assert error > 0.1
    v, forces = np.array([np.nan, 1.0]), np.zeros(2)
    assert (
        not solve_rows(M, v, row, np.zeros(2), columns_of(row, table), table, numbers, 1e-10, forces)[1]
        <= 1.0
    )


def test_a_soft_row_is_a_spring() -> None:
    """λ = -u / R where it presses: (M + 1 / R) v = M v_free."""
    M, J = np.array([[2.0]]), np.array([[1.0]])
    table, numbers = _tables([(SOFT_ROWS, 1, 0.0, 0.0)], np.array([[0.5]]))
    v, forces = np.array([-3.0]), np.array([0.25])
    solve_rows(M, v, J, np.zeros(1), columns_of(J, table), table, numbers, 1e-10, forces)
    assert v[0] == pytest.approx(-3.0 * 2.0 / (2.0 + 4.0))
    assert forces[0] == pytest.approx(4.0)
