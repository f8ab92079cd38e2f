"""Siconos on the same problems, in the system's Python, where its Debian package is installed."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from benchmarks.problems.judge import DECADES, finer, judge
from surefoot.base.arrays import FloatArray
from surefoot.contact.problem import ContactProblem

SYSTEM_PYTHON = "/usr/bin/python3"
METHODS = ("nsgs", "newton", "admm")
TIMEOUT = 3600.0
"""Of one process [s]."""


class SiconosRun(NamedTuple):
    """Forces of one method at one tolerance; `solve` and `fresh` are seconds without and with set-up."""

    forces: FloatArray
    solve: float
    fresh: float


def siconos_installed() -> bool:
    """Tell whether the system's Python has Siconos, and SciPy for its sparse matrices."""
    if not Path(SYSTEM_PYTHON).exists():
        return False
    command = [SYSTEM_PYTHON, "-c", "import siconos.numerics, scipy.sparse"]
    return subprocess.run(command, capture_output=True, check=False, env=_surroundings()).returncode == 0


def _surroundings() -> dict[str, str]:
    """Return the environment of the system's Python, with packages unpacked to $SUREFOOT_SICONOS."""
    out = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    out.pop("PYTHONPATH", None)
    if root := os.environ.get("SUREFOOT_SICONOS"):
        libraries = f"{root}/usr/lib/x86_64-linux-gnu"
        out["PYTHONPATH"] = f"{root}/usr/lib/python3/dist-packages"
        out["LD_LIBRARY_PATH"] = f"{libraries}:{libraries}/openblas-pthread:{libraries}/hdf5/serial"
    return out


def siconos_best(
    problems: Sequence[ContactProblem], tol: float
) -> dict[str, list[tuple[SiconosRun | None, float]]]:
    """Return, by method ("siconos nsgs", ...) and problem, the loosest run that satisfies our judge.

    With it its residual; None, and the least residual of all runs, where no run is accurate enough. Runs in
    a process of its own on one core: first by decades, then between the two decades that matter.
    """
    every = {(m, k): [tol * 10.0**d for d in DECADES] for m in METHODS for k in range(len(problems))}
    rough = run_siconos(problems, every)
    wanted = {}
    for key, runs in rough.items():
        good = [j for j, r in enumerate(runs) if judge(problems[key[1]], r.forces) <= tol]
        if good and good[0] > 0:
            wanted[key] = [tol * 10.0**d for d in finer(DECADES[good[0]])]
    fine = run_siconos(problems, wanted) if wanted else {}
    table: dict[str, list[tuple[SiconosRun | None, float]]] = {}
    for method in METHODS:
        rows: list[tuple[SiconosRun | None, float]] = []
        for k, problem in enumerate(problems):
            runs = fine.get((method, k), []) + rough.get((method, k), [])
            gaps = [judge(problem, r.forces) for r in runs]
            first = next((j for j, gap in enumerate(gaps) if gap <= tol), None)
            rows.append(
                (None, min(gaps, default=float("inf"))) if first is None else (runs[first], gaps[first])
            )
        table[f"siconos {method}"] = rows
    return table


def run_siconos(
    problems: Sequence[ContactProblem], wanted: Mapping[tuple[str, int], Sequence[float]]
) -> dict[tuple[str, int], list[SiconosRun]]:
    """Run methods on problems at tolerances, loosest first; a method out of time skips its last ones."""
    arrays: dict[str, Any] = {"count": np.array(len(problems))}
    for k, p in enumerate(problems):
        G = sp.csc_matrix(p.operator)
        arrays |= {f"data_{k}": G.data, f"rows_{k}": G.indices, f"starts_{k}": G.indptr}
        arrays |= {f"g_{k}": p.g, f"mu_{k}": p.mu}
    for (method, k), tolerances in wanted.items():
        arrays[f"tol_{method}_{k}"] = np.array(tolerances)
    worker = Path(__file__).with_name("siconos_worker.py")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "problems.npz", Path(folder) / "found.npz"
        np.savez(source, **arrays)
        command = [SYSTEM_PYTHON, str(worker), str(source), str(target)]
        subprocess.run(command, check=True, capture_output=True, timeout=TIMEOUT, env=_surroundings())
        with np.load(target) as data:
            found = {name: data[name] for name in data.files}
    return {
        (method, k): [
            SiconosRun(found[key][:-2].reshape(-1, 3), float(found[key][-2]), float(found[key][-1]))
            for j in range(len(tolerances))
            if (key := f"{method}_{k}_{j}") in found
        ]
        for (method, k), tolerances in wanted.items()
    }
