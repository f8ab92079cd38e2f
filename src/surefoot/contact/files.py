"""Contact problems in files: FCLIB HDF5, Siconos text and Surefoot's own .npz.

Foreign files order a contact (normal, tangent, tangent) and are turned to (tangent, tangent, normal). What a
file says that a `ContactProblem` cannot is changed on reading and told in `problem.notes`:

- a matrix that is not quite symmetric is replaced by its symmetric part (up to `LARGEST_ASYMMETRY`, beyond
  that it is refused): the solvers, and the residuals that they are judged by, see that part;
- a planar problem (normal, tangent) becomes the three-dimensional one whose second tangent is coupled to
  nothing and has no free velocity: no force, no velocity, the same answer in the plane.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, IntArray, finite_array
from surefoot.contact.lcp import LCP
from surefoot.contact.problem import ContactProblem
from surefoot.errors import ProblemError, unknown_name

LARGEST_ASYMMETRY = 0.2
"""Largest |G - Gᵀ| over largest |G| that is read."""
NOTED_ASYMMETRY = 1e-12
KINDS = {".hdf5": "fclib", ".h5": "fclib", ".dat": "siconos", ".npz": "npz"}


def read_problem(path: str | Path) -> ContactProblem:
    """Return the contact problem in a file: .hdf5 or .h5 (FCLIB), .dat (Siconos) or .npz.

    Raises
    ------
    ProblemError
        If there is no such file, its ending is unknown, or what it holds is no contact problem.
    MissingExtra
        If HDF5 is asked for without h5py.
    """
    path = Path(path)
    kind = _kind(path)
    if not path.is_file():
        raise ProblemError(f"no such file: {path}")
    if kind == "fclib":
        from surefoot.contact import fclib

        return fclib.read(path)
    if kind == "siconos":
        from surefoot.contact import siconos_text

        return siconos_text.read(path)
    return _read_npz(path)


def write_problem(problem: ContactProblem, path: str | Path, forces: ArrayLike | None = None) -> Path:
    """Write a contact problem, and forces that solve it if given, to a new file; return its path.

    FCLIB and Siconos files hold Coulomb's law on exact cones without normal bounds or bilateral contacts;
    .npz holds everything.

    Raises
    ------
    ProblemError
        If the file exists, its ending is unknown, or the format cannot hold the problem.
    """
    path = Path(path)
    kind = _kind(path)
    if problem.general:
        raise ProblemError("no file format holds contacts of any kind, or laws of one's own")
    if path.exists():
        raise ProblemError(f"{path} exists; nothing is overwritten")
    solution = None if forces is None else finite_array("forces", forces, (problem.contacts, 3))
    if kind == "npz":
        _write_npz(problem, path, solution)
        return path
    if problem.law != "coulomb" or problem.facets is not None or _extras(problem):
        raise ProblemError(
            f"a {path.suffix} file holds Coulomb's law on exact cones, without normal bounds or bilateral "
            "contacts; use .npz"
        )
    if kind == "fclib":
        from surefoot.contact import fclib

        fclib.write(problem, path, solution)
    else:
        from surefoot.contact import siconos_text

        siconos_text.write(problem, path)
    return path


def read_lcp(path: str | Path) -> LCP:
    """Return the linear complementarity problem in a Siconos text file.

    Raises
    ------
    ProblemError
        If there is no such file or it holds no LCP.
    """
    from surefoot.contact import siconos_text

    path = Path(path)
    if not path.is_file():
        raise ProblemError(f"no such file: {path}")
    return siconos_text.read_lcp(path)


def holds_lcp(path: str | Path) -> bool:
    """Tell whether a file is a Siconos text file of a linear complementarity problem."""
    from surefoot.contact import siconos_text

    path = Path(path)
    return path.suffix == ".dat" and path.is_file() and siconos_text.holds_lcp(path)


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
    notes: tuple[str, ...] = (),
) -> ContactProblem:
    """Return the contact problem of a matrix and vectors in (normal, tangent, tangent) order."""
    if dimension not in (2, 3):
        raise ProblemError(f"{name}: the dimension must be 2 or 3, got {dimension}")
    count = q.size // dimension
    if q.size != dimension * count or mu.size != count or matrix.shape != (q.size, q.size):
        raise ProblemError(
            f"{name}: sizes disagree: matrix {matrix.shape}, q {q.size}, mu {mu.size}, dimension {dimension}"
        )
    told = list(notes)
    order = turned(count, dimension)
    matrix = sp.csr_matrix(matrix)[order][:, order]
    q = q[order]
    if dimension == 2:
        matrix, q = _in_space(matrix, q)
        told.append("planar: given a second tangent that is coupled to nothing")
        reference = (
            None
            if reference is None
            else np.column_stack([reference[:, 1], 0 * reference[:, 0], reference[:, 0]])
        )
    elif reference is not None:
        reference = reference[:, [1, 2, 0]]
    largest = float(abs(matrix).max()) if matrix.nnz else 0.0
    off = float(abs(matrix - matrix.T).max()) / largest if largest > 0.0 else 0.0
    if off > LARGEST_ASYMMETRY:
        raise ProblemError(f"{name}: the matrix is not symmetric (by {off:.0%} of its largest entry)")
    if off > NOTED_ASYMMETRY:
        told.append(
            f"not symmetric as published ({off:.1e} of the largest entry): its symmetric part is used"
        )
    matrix = 0.5 * (matrix + matrix.T)
    sparse = matrix.nnz < 0.3 * q.size**2 and count > 40
    problem = ContactProblem(matrix.tocsr() if sparse else matrix.toarray(), q, mu)
    problem.notes, problem.reference = tuple(told), reference
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
    right = np.column_stack([H.toarray(), f])
    if G is not None and b is not None:
        M = sp.bmat([[M, -G], [G.T, None]], format="csc")
        rest = np.zeros((G.shape[1], right.shape[1]))
        rest[:, -1] = -b
        right = np.vstack([right, rest])
    try:
        solved = scipy.sparse.linalg.splu(M).solve(right)[:size]
    except RuntimeError as error:
        raise ProblemError("the mass matrix of a global problem is singular") from error
    return np.asarray(H.T @ solved[:, :-1]), np.asarray(H.T @ solved[:, -1] + w)


def _in_space(matrix: Any, q: FloatArray) -> tuple[Any, FloatArray]:
    """Return a planar (tangent, normal) problem with an idle second tangent."""
    count = q.size // 2
    place = (3 * np.arange(count)[:, None] + [0, 2]).ravel()
    entries = sp.coo_matrix(matrix)
    idle = 3 * np.arange(count) + 1
    size = matrix.diagonal().reshape(-1, 2).mean(axis=1)
    rows = np.concatenate([place[entries.row], idle])
    columns = np.concatenate([place[entries.col], idle])
    full = sp.csr_matrix(
        (np.concatenate([entries.data, size]), (rows, columns)), shape=(3 * count, 3 * count)
    )
    g = np.zeros(3 * count)
    g[place] = q
    return full, g


def _kind(path: Path) -> str:
    if path.suffix not in KINDS:
        raise ProblemError(unknown_name("kind of file", path.suffix or path.name, KINDS))
    return KINDS[path.suffix]


def _extras(problem: ContactProblem) -> bool:
    return problem.bounded or problem.bilateral is not None or bool((problem.normal_max == 0.0).any())


def _write_npz(problem: ContactProblem, path: Path, forces: FloatArray | None) -> None:
    held = np.zeros(problem.contacts, dtype=bool) if problem.bilateral is None else problem.bilateral
    given = problem.reference if forces is None else forces
    with path.open("xb") as file:
        np.savez_compressed(
            file,
            G=problem.G,
            g=problem.g,
            mu=problem.mu,
            normal_min=np.where(held, 0.0, problem.normal_min),
            normal_max=problem.normal_max,
            law=np.array(problem.law),
            facets=np.array(problem.facets or 0),
            fit=np.array(problem.fit),
            bilateral=held,
            notes=np.array(problem.notes, dtype=np.str_),
            reference=np.zeros((0, 3)) if given is None else given,
        )


def _read_npz(path: Path) -> ContactProblem:
    try:
        with np.load(path, allow_pickle=False) as data:
            found = {name: data[name] for name in data.files}
    except (ValueError, OSError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise ProblemError(f"{path} is no .npz file of numbers") from error
    missing = {"G", "g", "mu"} - set(found)
    if missing:
        raise ProblemError(f"{path} has no {', '.join(sorted(missing))}")
    facets = int(found.get("facets", 0))
    problem = ContactProblem(
        found["G"],
        found["g"],
        found["mu"],
        found.get("normal_min", 0.0),
        found.get("normal_max", np.inf),
        str(found.get("law", "coulomb")),
        facets or None,
        str(found.get("fit", "inner")),  # type: ignore[arg-type]
        bilateral=found.get("bilateral"),
    )
    problem.notes = tuple(str(n) for n in found.get("notes", ()))
    reference = found.get("reference", np.zeros((0, 3)))
    problem.reference = reference if reference.shape == (problem.contacts, 3) and problem.contacts else None
    return problem
