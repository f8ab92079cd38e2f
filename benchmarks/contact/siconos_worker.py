"""Run Siconos on contact problems, in the system's Python.

A program of its own, because Siconos comes as a Debian package for the system's interpreter; it needs NumPy,
SciPy and Siconos and nothing of Surefoot. Arguments: the .npz file with G_k, g_k, mu_k (contacts as tangent,
tangent, normal) and tol_METHOD_k (tolerances, loosest first), and the output .npz.
"""

from __future__ import annotations

import importlib
import sys
import time
from typing import Any

import numpy as np

METHODS = {
    "nsgs": ("NSGS", "fc3d_nsgs"),
    "newton": ("NSN_AC", "fc3d_nonsmooth_Newton_AlartCurnier"),
    "admm": ("ADMM", "fc3d_admm"),
}
LARGE = 40
"""Contacts above which the matrix is sparse, and iterations are fewer."""
ITERATIONS = {"nsgs": (20_000, 2000), "newton": (300, 300), "admm": (20_000, 3000)}
BUDGET = 4.0
"""Seconds that one method may spend on one problem before tighter tolerances are left out."""


def run(numerics: Any, method: str, G: Any, g: Any, mu: Any, tol: float) -> tuple[Any, float, float]:
    """Return the reactions and the seconds of one cold solve, without and with setting up."""
    code, function = METHODS[method]
    start = time.perf_counter()
    problem = numerics.FrictionContactProblem(3, mu.size, G, g, mu)
    built = time.perf_counter() - start
    options = numerics.SolverOptions(getattr(numerics, "SICONOS_FRICTION_3D_" + code))
    options.dparam[numerics.SICONOS_DPARAM_TOL] = tol
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = ITERATIONS[method][mu.size > LARGE]
    reaction, velocity = np.zeros(g.size), np.zeros(g.size)
    start = time.perf_counter()
    getattr(numerics, function)(problem, reaction, velocity, options)
    seconds = time.perf_counter() - start
    return reaction, seconds, built + seconds


def stored(G: Any, large: bool) -> Any:
    """Return a matrix as Siconos takes it without a copy: dense, or compressed columns of 64 bits."""
    if not large:
        return np.asfortranarray(G.toarray())
    sparse = G.tocsc()
    sparse.indptr, sparse.indices = sparse.indptr.astype(np.int64), sparse.indices.astype(np.int64)
    return sparse


def main(source: str, target: str) -> None:
    """Solve every problem by every method at every tolerance, five times each where it is quick."""
    numerics, scipy = importlib.import_module("siconos.numerics"), importlib.import_module("scipy.sparse")
    with np.load(source) as file:
        data = dict(file)
    out: dict[str, Any] = {}
    for k in range(int(data["count"])):
        g, mu = data[f"g_{k}"], data[f"mu_{k}"]
        G = scipy.csc_matrix((data[f"data_{k}"], data[f"rows_{k}"], data[f"starts_{k}"]), (g.size, g.size))
        n = mu.size
        turned = (3 * np.arange(n)[:, None] + [1, 2, 0]).ravel()
        back = np.argsort(turned)
        M, q = stored(G[back][:, back], n > LARGE), g[back]
        for method in METHODS:
            spent = 0.0
            for j, tol in enumerate(data.get(f"tol_{method}_{k}", ())):
                if spent > BUDGET:
                    break
                reaction, seconds, fresh = run(numerics, method, M, q, mu, float(tol))
                spent += seconds
                if seconds < 0.1:
                    again = [run(numerics, method, M, q, mu, float(tol))[1:] for _ in range(4)]
                    seconds, fresh = np.median([(seconds, fresh), *again], axis=0)
                out[f"{method}_{k}_{j}"] = np.concatenate([reaction[turned], [seconds, fresh]])
    np.savez(target, **out)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
