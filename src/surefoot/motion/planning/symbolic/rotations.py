"""Rotations as CasADi expressions: matrices, and the power series of turns, which have no branch at rest."""

from __future__ import annotations

from typing import Any

from surefoot.base.libraries import import_casadi

Expression = Any
"""A CasADi SX matrix."""
TERMS = 14
"""Terms of the power series of rotations: exact to round-off up to half a turn per step."""


def turn_matrix(quaternion: Expression) -> Expression:
    """Return the rotation matrix of a unit quaternion (x, y, z, w) in symbols."""
    ca = import_casadi()
    x, y, z, w = (quaternion[k] for k in range(4))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return ca.vertcat(*(ca.horzcat(*row) for row in rows))


def rotate(vector: Expression, rotation: Expression) -> Expression:
    """Return a vector (3, 1) after a turn by a rotation vector (3, 1), in symbols."""
    ca = import_casadi()
    square, once = ca.dot(rotation, rotation), ca.cross(rotation, vector)
    return vector + even_series(square, 1) * once + even_series(square, 2) * ca.cross(rotation, once)


def even_series(square: Expression, order: int) -> Expression:
    """Return Σ (-1)^k t^2k / (2k + order)!: cos t, sin t / t, (1 - cos t) / t², (t - sin t) / t³."""
    total, size = 0.0, 1.0
    for n in range(2, order + 1):
        size /= n
    terms = [size]
    for k in range(1, TERMS + order % 2):
        size /= -(2 * k + order - 1) * (2 * k + order)
        terms.append(size)
    for term in reversed(terms):
        total = term + square * total
    return total
