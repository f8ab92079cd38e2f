"""The matrix of an interior point's step is the same, dense or sparse, and so are its solutions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp

from surefoot.contact.solvers.reduced_structure import find_structure
from surefoot.contact.solvers.reduced_system import (
    Factors,
    ReducedSystem,
    apply_rows,
    gather_rows,
    solve_factors,
)


def heap(bodies: int, seed: int) -> sp.csr_matrix:
    """Return rows Y of bodies that touch others near them, or the ground, their numbers shuffled."""
    rng = np.random.default_rng(seed)
    name, blocks = rng.permutation(bodies), []
    for k in range(bodies):
        for other in {min(k + 1, bodies - 1), min(k + 3, bodies - 1)}:
            rows = np.zeros((3, 6 * bodies))
            for one in {name[k], name[other]}:
                rows[:, 6 * one : 6 * one + 6] = rng.normal(size=(3, 6))
            blocks.append(sp.csr_matrix(rows))
    return sp.vstack(blocks, "csr")


def weights_of(contacts: int, seed: int) -> np.ndarray:
    """Return (n, 3, 3) weights that are not symmetric, as a linearised shift leaves them."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(contacts, 3, 3))
    out = A @ A.transpose(0, 2, 1)
    out[:, :, 0] += 0.5 * out[:, :, 2]
    return out


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sparse", [False, True])
def test_the_system_is_what_it_says(seed: int, sparse: bool) -> None:
    Y = heap(30, seed)
    n = Y.shape[0] // 3
    rng = np.random.default_rng(seed)
    scale, weights = rng.uniform(0.3, 1.0, size=(n, 3)), weights_of(n, seed)
    factor = Y if sparse else Y.toarray()
    structure = find_structure(factor)
    assert structure.sparse == sparse
    system = ReducedSystem(factor, scale, structure)
    rows, r = system.rows, Y.shape[1]
    place = structure.place if sparse else np.arange(r)
    own = np.zeros((3 * n, rows.size))
    own[:, place] = scale.reshape(-1, 1) * Y.toarray()
    forces, v = rng.normal(size=(n, 3)), rng.normal(size=rows.size)
    right, r = v.copy(), rows.size
    gathered, applied = np.empty(r), np.empty(3 * n)
    gather_rows(rows, forces, gathered)
    apply_rows(rows, v, applied)
    np.testing.assert_allclose(gathered, own.T @ forces.ravel(), atol=1e-12)
    np.testing.assert_allclose(applied, own @ v, atol=1e-12)
    square = np.asarray(Y @ (Y.T @ forces.ravel())).reshape(n, 3)
    np.testing.assert_allclose(system.multiply_square(forces), square, atol=1e-10)
    matrix = np.eye(r)
    for k in range(n):
        part = own[3 * k : 3 * k + 3]
        matrix += part.T @ weights[k] @ part
    factors = system.factorise(weights)
    assert factors is not None
    solve_factors(factors, v)
    np.testing.assert_allclose(matrix @ v, right, atol=1e-8)
    assert factors.sign == np.linalg.slogdet(matrix)[0]


def test_the_sign_is_the_sign_of_the_determinant() -> None:
    """Of matrices of either sign, dense and sparse: I + Yᵀ W Y with weights that are not positive."""
    signs = []
    for seed in range(20):
        Y = heap(12, seed)
        n, dense = Y.shape[0] // 3, Y.toarray()
        weights = np.random.default_rng(seed).normal(size=(n, 3, 3))
        found = []
        for factor in (Y, dense):
            factors = ReducedSystem(factor, np.ones((n, 3)), find_structure(factor)).factorise(weights)
            assert factors is not None
            found.append(factors.sign)
        matrix = np.eye(Y.shape[1])
        for k in range(n):
            matrix += dense[3 * k : 3 * k + 3].T @ weights[k] @ dense[3 * k : 3 * k + 3]
        signs.append(np.linalg.slogdet(matrix)[0])
        assert found == [signs[-1]] * 2
    assert set(signs) == {-1.0, 1.0}


def test_few_bodies_that_all_touch_each_other_are_dense() -> None:
    rng = np.random.default_rng(0)
    blocks = []
    for one, other in ((0, 1), (0, 2), (1, 2)):
        rows = np.zeros((3, 18))
        rows[:, 6 * one : 6 * one + 6], rows[:, 6 * other : 6 * other + 6] = rng.normal(size=(2, 3, 6))
        blocks.append(rows)
    assert not find_structure(sp.csr_matrix(np.vstack(blocks))).sparse


def test_a_singular_matrix_has_no_factors() -> None:
    Y = sp.csr_matrix(np.kron(np.eye(8), np.ones((3, 1))))
    system = ReducedSystem(Y, np.ones((8, 3)), find_structure(Y))
    weights = np.zeros((8, 3, 3))
    weights[0, 0, 0] = -1.0
    assert isinstance(system.factorise(0.0 * weights), Factors)
    assert system.factorise(weights) is None


@pytest.mark.parametrize("seed", range(3))
def test_bodies_in_any_order_and_those_without_contacts_change_nothing(seed: int) -> None:
    """A factor with its bodies permuted, columns of zeros, and entries in two parts solves the same."""
    rng = np.random.default_rng(seed)
    Y = heap(25, seed)
    n, r = Y.shape[0] // 3, Y.shape[1]
    bodies = np.arange(r + 12).reshape(-1, 6)
    columns = rng.permutation(bodies).ravel()
    more = sp.hstack([Y, sp.csr_matrix((Y.shape[0], 12))]).tocsr()[:, columns].tocsr()
    halves = np.repeat(0.5 * more.data, 2), np.repeat(more.indices, 2), 2 * more.indptr
    more = sp.csr_matrix(halves, shape=more.shape)
    forces, weights = rng.normal(size=(n, 3)), weights_of(n, seed)
    moved = []
    for factor in (Y, more):
        structure = find_structure(factor)
        assert structure.sparse
        system = ReducedSystem(factor, np.ones((n, 3)), structure)
        np.testing.assert_allclose(
            system.multiply_square(forces).ravel(), Y @ (Y.T @ forces.ravel()), atol=1e-10
        )
        factors = system.factorise(weights)
        assert factors is not None
        v = np.empty(system.rows.size)
        gather_rows(system.rows, forces, v)
        solve_factors(factors, v)
        applied = np.empty(3 * n)
        apply_rows(system.rows, v, applied)
        moved.append(applied)
    np.testing.assert_allclose(moved[0], moved[1], atol=1e-8)
