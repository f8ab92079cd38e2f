"""From other projects' contact problems to ours: the order of a contact, planar problems, global ones.

What the readers of `files` share; the notes on what is changed on reading are there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.contact.problem.problem import ContactProblem

LARGEST_ASYMMETRY = 0.2
"""Largest |G - Gᵀ| over largest |G| that is read."""
NOTED_ASYMMETRY = 1e-12
SHRINKS, SMALL = 1100, 1 << 20
"""An array claims at most so many times its bytes in the file, deflate's limit, beside so many bytes."""
LARGEST_DENSE = 2**27
"""Entries of the largest dense matrix that is made of a sparse one in a file: 1 GB."""


def check_dense(what: str, rows: int, columns: int) -> None:
    """Refuse to fill a (rows, columns) matrix that no memory holds, before it is asked for.

    Raises
    ------
    ProblemError
        If it has more entries than `LARGEST_DENSE`.
    """
    if rows * columns > LARGEST_DENSE:
        raise ProblemError(f"{what} of {rows}x{columns} entries is too large")


def turned(count: int, dimension: int = 3) -> IntArray:
    """Return the order that takes (normal, tangent, ...) to (tangent, ..., normal) for `count` contacts."""
    within = np.roll(np.arange(dimension), -1)
    return np.asarray((dimension * np.arange(count)[:, None] + within).ravel())


def from_foreign(
    matrix: Any,
    q: FloatArray,
    mu: FloatArray,
    dimension: int,
    name: str,
    reference: FloatArray | None = None,
) -> ContactProblem:
    """Return the contact problem of a matrix and vectors, any unit, in (normal, tangent, tangent) order."""
    count = q.size // dimension
    if q.size != dimension * count or mu.size != count or matrix.shape != (q.size, q.size):
        raise ProblemError(
            f"{name}: sizes disagree: matrix {matrix.shape}, q {q.size}, mu {mu.size}, dimension {dimension}"
        )
    notes: list[str] = []
    order = turned(count, dimension)
    matrix = sp.csr_matrix(matrix)[order][:, order]
    q = q[order]
    if dimension == 2:
        matrix, q = _in_space(matrix, q)
        notes.append("planar: given a second tangent that is coupled to nothing")
        if reference is not None:
            reference = np.column_stack([reference[:, 1], 0 * reference[:, 0], reference[:, 0]])
    elif reference is not None:
        reference = reference[:, [1, 2, 0]]
    largest = float(abs(matrix).max()) if matrix.nnz else 0.0
    off = float(abs(matrix - matrix.T).max()) / largest if largest > 0.0 else 0.0
    if off > LARGEST_ASYMMETRY:
        raise ProblemError(f"{name}: the matrix is not symmetric (by {off:.0%} of its largest entry)")
    if off > NOTED_ASYMMETRY:
        notes.append(
            f"not symmetric as published ({off:.1e} of the largest entry): its symmetric part is used"
        )
    matrix = 0.5 * (matrix + matrix.T)
    sparse = matrix.nnz < 0.3 * q.size**2 and count > 40
    problem = ContactProblem(matrix.tocsr() if sparse else matrix.toarray(), q, mu)
    problem.notes, problem.reference = tuple(notes), reference
    return problem


def condensed(
    M: Any, H: Any, f: FloatArray, w: FloatArray, G: Any = None, b: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return W = Hᵀ K H and q = Hᵀ v_free + w of M v = H r + G l + f, u = Hᵀ v + w, Gᵀ v + b = 0.

    Parameters
    ----------
    M, H, G
        (p, p), (p, m) and, if there are equality constraints, (p, k); arrays or SciPy sparse matrices.
    f, w, b
        (p,), (m,) and (k,).

    Raises
    ------
    ProblemError
        If shapes disagree, or the system without contacts is singular.
    """
    M, H = sp.csc_matrix(M), sp.csr_matrix(H)
    size = M.shape[0]
    if M.shape != (size, size) or H.shape != (size, w.size) or f.shape != (size,):
        raise ProblemError(
            f"a global problem's sizes disagree: M {M.shape}, H {H.shape}, f {f.size}, w {w.size}"
        )
    check_dense("a global problem's H", *H.shape)
    right = np.column_stack([H.toarray(), f])
    if G is not None and b is not None:
        # the saddle point system of M v - G l = H r + f, Gᵀ v = -b: one factor for all columns of H and for f
        M = sp.bmat([[M, -G], [G.T, None]], format="csc")
        rest = np.zeros((G.shape[1], right.shape[1]))
        rest[:, -1] = -b
        right = np.vstack([right, rest])
    from scipy.sparse.linalg import splu

    try:
        solved = splu(M).solve(right)[:size]
    except RuntimeError as error:
        raise ProblemError("the mass matrix of a global problem is singular") from error
    return np.asarray(H.T @ solved[:, :-1]), np.asarray(H.T @ solved[:, -1] + w)


def _in_space(matrix: Any, q: FloatArray) -> tuple[Any, FloatArray]:
    """Return a planar (tangent, normal) problem with an idle second tangent."""
    count = q.size // 2
    place = (3 * np.arange(count)[:, None] + [0, 2]).ravel()
    entries = sp.coo_matrix(matrix)
    idle = 3 * np.arange(count) + 1
    # the idle tangent is given the mean of its contact's diagonal, which leaves ||G_kk|| as it is
    size = matrix.diagonal().reshape(-1, 2).mean(axis=1)
    rows = np.concatenate([place[entries.row], idle])
    columns = np.concatenate([place[entries.col], idle])
    full = sp.csr_matrix(
        (np.concatenate([entries.data, size]), (rows, columns)), shape=(3 * count, 3 * count)
    )
    g = np.zeros(3 * count)
    g[place] = q
    return full, g
