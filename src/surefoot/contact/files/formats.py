"""Contact problems in files: FCLIB HDF5, Siconos text and Surefoot's own .npz.

Foreign files order a contact (normal, tangent, tangent) and are turned to (tangent, tangent, normal). What a
file says that a `ContactProblem` cannot is changed on reading and told in `problem.notes`:

- a matrix that is not quite symmetric is replaced by its symmetric part (up to `LARGEST_ASYMMETRY`, beyond
  that it is refused): the solvers, and the residuals that they are judged by, see that part;
- a planar problem (normal, tangent) becomes the three-dimensional one whose second tangent is coupled to
  nothing and has no free velocity: no force, no velocity, the same answer in the plane.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError, unknown_name, writing
from surefoot.base.text_files import path_of
from surefoot.contact.files import fclib, siconos_text
from surefoot.contact.files.foreign import SHRINKS, SMALL
from surefoot.contact.problem.lcp import LCP
from surefoot.contact.problem.problem import ContactProblem

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
    path = path_of(path)
    kind = _kind(path)
    if not path.is_file():
        raise ProblemError(f"no such file: {path}")
    if kind == "fclib":
        return fclib.read(path)
    if kind == "siconos":
        return siconos_text.read(path)
    return _read_npz(path)


def write_problem(problem: ContactProblem, path: str | Path, forces: ArrayLike | None = None) -> Path:
    """Write a problem, and (n, 3) forces [N or N s] that solve it if given, to a new file; return its path.

    FCLIB and Siconos files hold Coulomb's law on exact cones without normal bounds or bilateral contacts;
    .npz holds everything.

    Raises
    ------
    ProblemError
        If the file exists, its ending is unknown, or the format cannot hold the problem.
    WriteError
        If it cannot be written.
    """
    path = path_of(path)
    kind = _kind(path)
    if problem.general:
        raise ProblemError("no file format holds contacts of any kind, or laws of one's own")
    if path.exists():
        raise ProblemError(f"{path} exists; nothing is overwritten")
    solution = None if forces is None else finite_array("forces", forces, (problem.contacts, 3))
    bounded = problem.bounded or problem.bilateral is not None or (problem.normal_max == 0.0).any()
    if kind != "npz" and (problem.law != "coulomb" or problem.facets is not None or bounded):
        raise ProblemError(
            f"a {path.suffix} file holds Coulomb's law on exact cones, without normal bounds or bilateral "
            "contacts; use .npz"
        )
    with writing(path):
        if kind == "npz":
            _write_npz(problem, path, solution)
        elif kind == "fclib":
            fclib.write(problem, path, solution)
        else:
            siconos_text.write(problem, path)
    return path


def read_lcp(path: str | Path) -> LCP:
    """Return the linear complementarity problem in a Siconos text file.

    Raises
    ------
    ProblemError
        If there is no such file or it holds no LCP.
    """
    path = path_of(path)
    if not path.is_file():
        raise ProblemError(f"no such file: {path}")
    return siconos_text.read_lcp(path)


def holds_lcp(path: str | Path) -> bool:
    """Tell whether a file is a Siconos text file of a linear complementarity problem."""
    path = path_of(path)
    return path.suffix == ".dat" and path.is_file() and siconos_text.holds_lcp(path)


BROKEN = (
    ValueError, OSError, EOFError, AttributeError, KeyError, RuntimeError, TypeError, SyntaxError,
    MemoryError, NotImplementedError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What NumPy and `zipfile` raise for a broken archive."""
NUMBERS = "iuf"
NPZ = (
    *((name, NUMBERS, None) for name in ("G", "g", "mu", "normal_min", "normal_max", "reference")),
    ("law", "U", 0), ("facets", "iu", 0), ("fit", "U", 0), ("bilateral", "b", None), ("notes", "U", None),
)  # fmt: skip
"""Names in a .npz file, the kinds of their entries (NumPy's letters), and 0 where there is one of them."""


def _check_sizes(path: Path) -> None:
    """Refuse an archive whose arrays claim more than it holds, before memory is asked for."""
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    with zipfile.ZipFile(path) as archive:
        for entry in archive.infolist():
            with archive.open(entry) as stream:
                shape, _, kind = read[np.lib.format.read_magic(stream)](stream)
            held = min(entry.file_size, SHRINKS * entry.compress_size + SMALL)
            if math.prod(shape) * kind.itemsize > held:
                raise ProblemError(f"{path}: {entry.filename} claims {shape}, more than the file can hold")


def _kind(path: Path) -> str:
    if path.suffix not in KINDS:
        raise ProblemError(unknown_name("kind of file", path.suffix or path.name, KINDS))
    return KINDS[path.suffix]


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
    from surefoot.base.npz_files import check_archive

    check_archive(path, path)
    try:
        _check_sizes(path)
        with np.load(path, allow_pickle=False) as data:
            found = {name: data[name] for name in data.files}
    except BROKEN as error:
        raise ProblemError(f"{path} is no .npz file of numbers") from error
    missing = {"G", "g", "mu"} - set(found)
    if missing:
        raise ProblemError(f"{path} has no {', '.join(sorted(missing))}")
    for name, kinds, shape in NPZ:
        array = found.get(name)
        if array is not None and (array.dtype.kind not in kinds or (shape == 0 and array.ndim > 0)):
            raise ProblemError(
                f"{path}: {name} is {array.dtype} of shape {array.shape}, not what a problem has"
            )
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
