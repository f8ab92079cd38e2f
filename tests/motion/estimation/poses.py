"""The group SE_k(3) as tests need it: exponential, logarithm, product, inverse and adjoint."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import rotation_log, skew
from surefoot.motion.estimation.extended_poses import gammas, move


def exponential(xi: FloatArray) -> FloatArray:
    """Return the element (3, 3 + k) of a vector (3 + 3k,) of the algebra, its rotation in [rad]."""
    k = len(xi) // 3 - 1
    X = np.hstack([np.eye(3), np.zeros((3, k))])
    move(X, np.ascontiguousarray(xi, dtype=np.float64))
    return X


def logarithm(X: FloatArray) -> FloatArray:
    """Return the vector (3 + 3k,) of an element (3, 3 + k), its rotation below π."""
    G, phi = np.empty((3, 3, 3)), rotation_log(X[:, :3])
    gammas(phi, G)
    return np.concatenate([phi, np.linalg.solve(G[1], X[:, 3:]).T.ravel()])


def product(X: FloatArray, Y: FloatArray) -> FloatArray:
    """Return the element X Y, (3, 3 + k) each."""
    out = X[:, :3] @ Y
    out[:, 3:] += X[:, 3:]
    return np.asarray(out)


def inverse(X: FloatArray) -> FloatArray:
    """Return the inverse of an element (3, 3 + k)."""
    back = X[:, :3].T
    return np.asarray(np.hstack([back, -back @ X[:, 3:]]))


def adjoint(X: FloatArray) -> FloatArray:
    """Return Ad_X, (3 + 3k, 3 + 3k): X exp(ξ) X⁻¹ = exp(Ad_X ξ)."""
    R, k = X[:, :3], X.shape[1] - 3
    out: FloatArray = np.asarray(np.kron(np.eye(1 + k), R), dtype=np.float64)
    for j in range(k):
        out[3 + 3 * j : 6 + 3 * j, :3] = skew(X[:, 3 + j]) @ R
    return out
