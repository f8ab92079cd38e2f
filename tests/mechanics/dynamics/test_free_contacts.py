"""Contacts of free bodies in blocks, against dense matrices of the same."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.mechanics.dynamics.free_contacts import BlockRows, FreeContacts


def random_contacts(seed: int, count: int, bodies: int) -> tuple[FreeContacts, np.ndarray, np.ndarray]:
    """Return contacts, the bodies' factors L (n, 6, 6), and the dense J (3p, 6n)."""
    rng = np.random.default_rng(seed)
    pairs = np.array([rng.choice(bodies, 2, replace=False) for _ in range(count)])
    pairs[rng.random((count, 2)) < 0.2] = -1
    blocks, J = rng.normal(size=(count, 2, 3, 6)), np.zeros((count, 3, bodies, 6))
    for c, side in np.argwhere(pairs >= 0):
        J[c, :, pairs[c, side]] = blocks[c, side]
    root = rng.normal(size=(bodies, 6, 6))
    L = np.linalg.cholesky(root @ root.swapaxes(1, 2) + np.eye(6))
    frames = np.tile(np.eye(3), (count, 1, 1))
    contacts = FreeContacts(np.zeros(count), np.zeros((count, 3)), frames, pairs, blocks, 6 * bodies)
    return contacts, L, J.reshape(3 * count, 6 * bodies)


@pytest.mark.parametrize("count", [5, 40, 200])
def test_rows_squares_and_pushes_are_those_of_dense_matrices(count: int) -> None:
    contacts, L, J = random_contacts(count, count, 17)
    whole, rng = np.zeros((102, 102)), np.random.default_rng(1)
    for b in range(17):
        whole[6 * b : 6 * b + 6, 6 * b : 6 * b + 6] = L[b]
    v, free, impulses = rng.normal(size=102), rng.normal(size=102), rng.normal(size=(count - 2, 3))
    near = np.arange(1, count - 1)
    chosen = (3 * near[:, None] + np.arange(3)).ravel()
    rows, G, _ = contacts.assemble(L, v, free, contacts.gaps, near, 1e-3, 1.0)
    expected = np.linalg.solve(whole, J[chosen].T).T
    np.testing.assert_allclose(contacts.factor(rows).toarray(), expected, atol=1e-12)
    dense = G if isinstance(G, np.ndarray) else G.toarray()
    np.testing.assert_allclose(dense, expected @ expected.T, atol=1e-10)
    assert count > 128 or (dense == dense.T).all()
    after = free + np.linalg.solve(whole.T, expected.T @ impulses.ravel())
    np.testing.assert_allclose(contacts.apply(L, rows, impulses, free), after, atol=1e-10)
    np.testing.assert_allclose(contacts.J, J)
    np.testing.assert_allclose(contacts.effort(np.ones((count, 3))), J.T @ np.ones(3 * count), atol=1e-12)
    np.testing.assert_allclose(contacts.velocities(v), (J @ v).reshape(-1, 3), atol=1e-12)


def test_the_matrix_of_rows_is_made_once() -> None:
    contacts, _, _ = random_contacts(0, 4, 3)
    rows = BlockRows(contacts.bodies, contacts.blocks, contacts.nv)
    assert rows.matrix is rows.matrix
