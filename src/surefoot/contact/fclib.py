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

from surefoot.arrays import FloatArray
from surefoot.contact.foreign import condensed, from_foreign, turned
from surefoot.contact.problem import ContactProblem
from surefoot.errors import MissingExtra, ProblemError


def _h5py() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise MissingExtra("h5py", "files") from error
    return h5py


def read(path: Path) -> ContactProblem:
    """Return the contact problem of an FCLIB file; its solution, if any, becomes `reference`."""
    h5py = _h5py()
    try:
        with h5py.File(path, "r") as file:
            kind = next((k for k in ("fclib_local", "fclib_global") if k in file), None)
            if any("rolling" in str(key) for key in file):
                raise ProblemError(f"{path.name}: rolling friction is not supported")
            if kind is None:
                raise ProblemError(f"{path.name} holds no fclib_local or fclib_global problem")
            group = file[kind]
            dimension = int(np.ravel(group["spacedim"][()])[0])
            mu = np.ravel(group["vectors/mu"][()])
            if kind == "fclib_local":
                if "V" in group:
                    raise ProblemError(f"{path.name}: local problems with equality constraints are not read")
                W, q = _matrix(group["W"]), np.ravel(group["vectors/q"][()])
            else:
                W, q = _condense(group)
            reference = np.ravel(file["solution/r"][()]) if "solution/r" in file else None
    except ProblemError:
        raise
    except (OSError, KeyError, ValueError, IndexError, TypeError) as error:
        raise ProblemError(f"{path.name} is no FCLIB file: {error}") from error
    if reference is not None:
        reference = reference.reshape(-1, dimension) if reference.size == q.size else None
    return from_foreign(W, q, mu, dimension, path.name, reference)


def _matrix(group: Any) -> Any:
    """Return a sparse matrix that CSparse wrote."""
    rows, columns, kind = (int(np.ravel(group[name][()])[0]) for name in ("m", "n", "nz"))
    p, i, x = (np.ravel(group[name][()]) for name in ("p", "i", "x"))
    if kind == -1:
        return sp.csc_matrix((x, i, p), shape=(rows, columns)).tocsr()
    if kind == -2:
        return sp.csr_matrix((x, i, p), shape=(rows, columns))
    return sp.csr_matrix((x[:kind], (i[:kind], p[:kind])), shape=(rows, columns))


def _condense(group: Any) -> tuple[FloatArray, FloatArray]:
    """Return the contact matrix and free velocity of a global problem, see `condensed`."""
    G, b = (_matrix(group["G"]), np.ravel(group["vectors/b"][()])) if "G" in group else (None, None)
    f, w = np.ravel(group["vectors/f"][()]), np.ravel(group["vectors/w"][()])
    return condensed(_matrix(group["M"]), _matrix(group["H"]), f, w, G, b)


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
