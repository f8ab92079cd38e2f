"""Reading a Delassus operator: its checks, what is taken for rounding, and the compliance on its diagonal."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.contact.problem.blocks import checked_mirror, checked_mirror_sparse

ASYMMETRY = 1e-8
"""Largest |G - Gᵀ|, and largest -λ for an eigenvalue λ, over largest |G| that is taken for rounding.

G is then replaced by its symmetric part."""
SINGLE_ASYMMETRY = 1e-5
"""The same where all entries are of single precision: J M⁻¹ Jᵀ of a robot comes out 1e-7 to 1e-6 off."""
DENSE_NORM = 150
"""Rows up to which all eigenvalues are the quickest way to the largest."""


def read_compliance(value: Any, contacts: int, counts: int | IntArray) -> FloatArray | None:
    """Return R as (m,) for contacts with so many rows each, None where it is zero."""
    if isinstance(value, (int, float)) and value == 0.0:
        return None
    R = finite_array("compliance", value)
    size = int(np.sum(np.broadcast_to(counts, contacts)))
    if R.shape == (contacts,):
        R = np.repeat(R, counts)
    elif R.ndim == 0:
        R = np.full(size, float(R))
    if R.shape != (size,):
        raise ProblemError(
            f"compliance must be a number or have shape ({contacts},) or ({size},), got {R.shape}"
        )
    if (R < 0.0).any():
        raise ProblemError(f"compliance[{int(np.argmax(R < 0.0))}] must be >= 0, got {R.min():g}")
    return R


def read_dense(G: ArrayLike, compliance: FloatArray | None, out: FloatArray, threes: bool = True) -> None:
    """Fill `out` (m, m) with the symmetric part of G, and the compliance (m,) on its diagonal.

    `threes` tells whether all contacts have three rows: messages then name them.
    """
    plain = type(G) is np.ndarray and G.dtype.kind == "f"
    matrix = np.asarray(G) if plain else finite_array("G", G)
    if matrix.shape != out.shape:
        finite_array("G", G, out.shape)  # says so
    out[:] = matrix
    scale, gap, _, _ = checked_mirror(out, ASYMMETRY)
    if not scale < np.inf:
        finite_array("G", G, out.shape)  # names the entry
    if gap < 0.0 or gap > ASYMMETRY * scale:
        _refuse_unless_single(matrix, out, threes)
    if compliance is not None:
        out[np.diag_indices(out.shape[0])] += compliance


def _refuse_unless_single(matrix: Any, out: FloatArray, threes: bool) -> None:
    """Check a dense G again as one of single precision, if it is; else say what is wrong with it."""
    entries = np.asarray(matrix, dtype=np.float64)
    with np.errstate(over="ignore"):
        single = bool((entries == entries.astype(np.float32)).all())
    limit = SINGLE_ASYMMETRY if single else ASYMMETRY
    out[:] = entries
    scale, gap, i, j = checked_mirror(out, limit)
    if gap > limit * scale:
        raise ProblemError(_asymmetry(i, j, float(entries[i, j]), float(entries[j, i]), limit))
    if gap < 0.0:
        raise ProblemError(_indefinite(i, j, out, threes))


def _asymmetry(i: int, j: int, one: float, other: float, limit: float) -> str:
    return (
        f"G must be symmetric, but G[{i}, {j}] = {one:g} and G[{j}, {i}] = {other:g}; "
        f"up to {limit:g} of the largest entry is taken for rounding"
    )


def _indefinite(i: int, j: int, G: Any, threes: bool = True) -> str:
    """Say which entries show that G is not positive semidefinite, as `checked_mirror` returned them."""
    text = "G must be positive semidefinite, but "
    if i == j:
        return f"{text}G[{i}, {i}] = {G[i, i]:g}"
    if j > i:
        block = f"contact {i // 3} (rows {i} to {i + 2})" if threes else f"rows {i} to {i + 2}"
        return f"{text}its block of {block} has a negative eigenvalue"
    return f"{text}G[{i}, {j}] = {G[i, j]:g} with G[{i}, {i}] = {G[i, i]:g} and G[{j}, {j}] = {G[j, j]:g}"


def checked_sparse(G: Any, size: int, compliance: FloatArray | None) -> Any:
    """Return the symmetric part of a sparse G (size, size), compliance (size,) on its diagonal, in CSR."""
    if G.shape != (size, size):
        raise ProblemError(f"G must have shape ({size}, {size}), got {G.shape}")
    matrix = sp.csr_matrix(G, copy=True)
    matrix.data = finite_array("the entries of G", matrix.data)
    matrix.sum_duplicates()
    with np.errstate(over="ignore"):
        single = bool((matrix.data == matrix.data.astype(np.float32)).all())
    limit = SINGLE_ASYMMETRY if single else ASYMMETRY
    mirror = matrix.T.tocsr()
    if not (np.array_equal(matrix.indptr, mirror.indptr) and np.array_equal(matrix.indices, mirror.indices)):
        matrix, mirror = _with_places_of(matrix, mirror), _with_places_of(mirror, matrix)
    places, even = (matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64)), matrix.data.copy()
    scale, gap, i, j = checked_mirror_sparse(*places, even, mirror.data, limit)
    if gap > limit * scale:
        raise ProblemError(_asymmetry(i, j, float(matrix[i, j]), float(mirror[i, j]), limit))
    matrix.data = even
    if gap < 0.0:
        raise ProblemError(_indefinite(i, j, matrix))
    if compliance is not None:
        matrix = matrix + sp.diags(compliance)
    return matrix.tocsr()


def _with_places_of(matrix: Any, other: Any) -> Any:
    """Return a CSR matrix with zeros where another one has entries and it has none."""
    one, two = matrix.tocoo(), other.tocoo()
    rows, columns = np.concatenate([one.row, two.row]), np.concatenate([one.col, two.col])
    return sp.csr_matrix((np.append(one.data, 0.0 * two.data), (rows, columns)), shape=matrix.shape)


def read_factor(Y: Any) -> Any:
    """Return a factor Y (m, nv) of G = Y Yᵀ in CSR without columns of bodies that no contact moves."""
    rows = sp.csr_matrix(Y, dtype=np.float64)
    used = np.flatnonzero(np.bincount(rows.indices, minlength=rows.shape[1]))
    return rows if len(used) == rows.shape[1] else rows[:, used]


def spectral_norm(G: Any) -> float:
    """Return ||G||₂ of a symmetric matrix (m, m), dense or sparse: largest |eigenvalue|, to about 1e-9."""
    import scipy.linalg
    import scipy.sparse.linalg

    if G.shape[0] == 0 or not abs(G).max() > 0.0:  # ARPACK takes neither
        return 0.0
    size = G.shape[0]
    if size <= DENSE_NORM:
        dense = G if isinstance(G, np.ndarray) else G.toarray()
        return float(np.abs(scipy.linalg.eigvalsh(dense)[[0, -1]]).max())
    # more vectors than ARPACK's 20: the largest eigenvalues of long chains of contacts nearly coincide
    start = np.random.default_rng(0).uniform(0.5, 1.5, size)  # no symmetry that a mechanism could share
    ends = scipy.sparse.linalg.eigsh(G, 1, which="LM", v0=start, ncv=60, tol=1e-7, return_eigenvectors=False)
    return float(np.abs(ends[0]))
