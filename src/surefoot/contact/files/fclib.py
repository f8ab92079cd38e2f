"""FCLIB HDF5 files: local problems (W, q, mu) and global ones (M, H, f, w, mu, and G, b if there are any).

Source: V. Acary, M. Bremond, T. Koziara, F. Perignon, "FCLIB: a collection of discrete 3D frictional
contact problems", INRIA RT-0444, 2014. Matrices are sparse as in CSparse: nz = -1 columns, -2 rows, else
triplets with p the columns. A global problem M v = H r + G l + f, u = Hᵀ v + w, Gᵀ v + b = 0 is condensed
to its contacts.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError, needs
from surefoot.contact.files.foreign import SHRINKS, SMALL, condensed, from_foreign, turned
from surefoot.contact.problem.problem import ContactProblem


def _h5py() -> Any:
    with needs("h5py", "files"):
        import h5py
    return h5py


def read(path: Path) -> ContactProblem:
    """Return the contact problem of an FCLIB file; its solution, if any, becomes `reference`."""
    h5py = _h5py()
    try:
        with h5py.File(path, "r") as file:
            W, q, mu, dimension, reference = _read(file)
    except ProblemError as error:
        raise ProblemError(f"{path.name}: {error}") from error.__cause__
    # whatever h5py says of a broken file, in one line
    except (OSError, LookupError, ValueError, TypeError, RuntimeError, ArithmeticError) as error:
        reason = str(error).strip("'\"").partition("\n")[0]
        raise ProblemError(f"{path.name} is no FCLIB file: {reason}") from error
    return from_foreign(W, q, mu, dimension, path.name, reference)


def _read(file: Any) -> tuple[Any, FloatArray, FloatArray, int, FloatArray | None]:
    """Return W, q, mu, the dimension and the solution, if there is one."""
    kind = next((k for k in ("fclib_local", "fclib_global") if k in file), None)
    if any("rolling" in str(key) for key in file):
        raise ProblemError("rolling friction is not supported")
    if kind is None:
        raise ProblemError("holds no fclib_local or fclib_global problem")
    group = _open(file, kind)
    dimension = _whole(group, "spacedim")
    if dimension not in (2, 3):
        raise ProblemError(f"the dimension must be 2 or 3, got {dimension}")
    mu = _vector(group, "vectors/mu")
    if kind == "fclib_local":
        if "V" in group:
            raise ProblemError("local problems with equality constraints are not read")
        q = _vector(group, "vectors/q")
        W = _matrix(group, "W", q.size, q.size)
    else:
        W, q = _condense(group)
    reference = _vector(file, "solution/r") if "solution/r" in file else None
    if reference is not None:
        fits = reference.size == q.size and q.size % dimension == 0
        reference = reference.reshape(-1, dimension) if fits else None
    return W, q, mu, dimension, reference


def _open(group: Any, name: str) -> Any:
    """Return what is in a group under a name; no link leads out of the file."""
    for part in name.split("/"):
        if isinstance(group.get(part, getlink=True), _h5py().ExternalLink):
            raise ProblemError(f"{part!r} is a link to another file")
        group = group[part]
    return group


def _numbers(group: Any, name: str, kinds: str) -> Any:
    """Return an array of numbers, flat, whose size and kind were looked at before it was read."""
    found = _open(group, name)
    if not isinstance(found, _h5py().Dataset) or found.dtype.kind not in kinds:
        raise ProblemError(f"{name} must be an array of {'numbers' if 'f' in kinds else 'whole numbers'}")
    if found.nbytes > SHRINKS * found.id.get_storage_size() + SMALL:
        raise ProblemError(f"{name} claims {found.size} entries, more than the file can hold")
    return np.ravel(found[()])


def _vector(group: Any, name: str) -> FloatArray:
    return np.asarray(_numbers(group, name, "iuf"), dtype=np.float64)


def _indices(group: Any, name: str) -> IntArray:
    return np.asarray(_numbers(group, name, "iu"), dtype=np.int64)


def _whole(group: Any, name: str) -> int:
    found = _indices(group, name)
    if found.size != 1:
        raise ProblemError(f"{name} must be one whole number, got {found.size}")
    return int(found[0])


def _matrix(group: Any, name: str, rows: int, columns: int) -> Any:
    """Return a sparse matrix that CSparse wrote, of the shape that the vectors beside it ask for.

    SciPy does not look at indices: one that is out of range loses an entry, or ends the interpreter.
    """
    matrix = _open(group, name)
    shape, kind = (_whole(matrix, "m"), _whole(matrix, "n")), _whole(matrix, "nz")
    if shape != (rows, columns):
        raise ProblemError(f"{name} must be {rows}x{columns} for the vectors beside it, got {shape}")
    p, i, x = _indices(matrix, "p"), _indices(matrix, "i"), _vector(matrix, "x")
    if kind not in (-1, -2):
        if not 0 <= kind <= min(p.size, i.size, x.size):
            raise ProblemError(f"{name} says {kind} entries and holds {min(p.size, i.size, x.size)}")
        triplets = x[:kind], (i[:kind], p[:kind])
        _check_range(name, i[:kind], rows)
        _check_range(name, p[:kind], columns)
        return sp.csr_matrix(triplets, shape=shape)
    major, minor = (columns, rows) if kind == -1 else (rows, columns)
    if p.size != major + 1 or p[0] != 0 or (np.diff(p) < 0).any() or p[-1] > min(i.size, x.size):
        raise ProblemError(f"{name}'s p must rise from 0 to the number of entries, in {major + 1} numbers")
    if x[p[-1] :].any():
        raise ProblemError(f"{name} holds {x.size} entries, of which p counts {p[-1]}")
    _check_range(name, i[: p[-1]], minor)
    made = sp.csc_matrix if kind == -1 else sp.csr_matrix
    return made((x[: p[-1]], i[: p[-1]], p), shape=shape).tocsr()


def _check_range(name: str, index: IntArray, size: int) -> None:
    wrong = (index < 0) | (index >= size)
    if wrong.any():
        raise ProblemError(f"{name} has an entry at {index[wrong][0]}, outside of 0 to {size - 1}")


def _condense(group: Any) -> tuple[FloatArray, FloatArray]:
    """Return the contact matrix and free velocity of a global problem, see `condensed`."""
    f, w = _vector(group, "vectors/f"), _vector(group, "vectors/w")
    M, H = _matrix(group, "M", f.size, f.size), _matrix(group, "H", f.size, w.size)
    if "G" not in group:
        return condensed(M, H, f, w)
    b = _vector(group, "vectors/b")
    return condensed(M, H, f, w, _matrix(group, "G", f.size, b.size), b)


def write(problem: ContactProblem, path: Path, forces: FloatArray | None) -> None:
    """Write a local FCLIB problem, and (n, 3) forces [N s] that solve it if given."""
    h5py = _h5py()
    n = problem.contacts
    back = np.argsort(turned(n))
    W = sp.csr_matrix(problem.G)[back][:, back].tocsr()
    with h5py.File(path, "x") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([3], dtype=np.int32)
        matrix = group.create_group("W")
        for name, value in (("m", 3 * n), ("n", 3 * n), ("nz", -2), ("nzmax", W.nnz)):
            matrix[name] = np.array([value], dtype=np.int32)
        # compressed rows, which nz = -2 says above
        matrix["p"], matrix["i"], matrix["x"] = W.indptr.astype(np.int32), W.indices.astype(np.int32), W.data
        group["vectors/q"], group["vectors/mu"] = problem.g[back], problem.mu
        group["info/title"] = np.bytes_("contact problem")
        group["info/description"] = np.bytes_("written by surefoot")
        group["info/math_info"] = np.bytes_("; ".join(problem.notes) or "none")
        given = problem.reference if forces is None else forces
        if given is not None:
            file["solution/r"] = given.ravel()[back]
            file["solution/u"] = problem.velocity(given).ravel()[back]
            file["solution/v"], file["solution/l"] = np.zeros(0), np.zeros(0)
