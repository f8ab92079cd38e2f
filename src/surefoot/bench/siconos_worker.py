"""Run Siconos on contact problems, in the system's Python.

A program of its own, because Siconos comes as a Debian package for the system's interpreter; it needs NumPy
and Siconos and nothing of Surefoot. Arguments: the .npz file with G_k, g_k, mu_k (contacts as tangent,
tangent, normal), the output .npz, and the tolerances to try, loosest first.
"""

from __future__ import annotations

import importlib
import sys
import time
from typing import Any

import numpy as np

METHODS = (("nsgs", "NSGS", "fc3d_nsgs"), ("newton", "NSN_AC", "fc3d_nonsmooth_Newton_AlartCurnier"))
ITERATIONS, ITERATIONS_LARGE, LARGE = 20_000, 2000, 40
"""Sweeps of its Gauss-Seidel, fewer above so many contacts."""
NEWTON_CONTACTS = 150
"""Its Newton method factorises dense matrices: left out above so many contacts."""
BUDGET = 2.0
"""Seconds that one method may spend on one problem before tighter tolerances are left out."""


def run(
    numerics: Any, method: tuple[str, str, str], problem: Any, size: int, tol: float
) -> tuple[Any, float]:
    """Return the reactions and the wall time of one cold solve [s]."""
    options = numerics.SolverOptions(getattr(numerics, "SICONOS_FRICTION_3D_" + method[1]))
    options.dparam[numerics.SICONOS_DPARAM_TOL] = tol
    sweeps = ITERATIONS if size <= 3 * LARGE else ITERATIONS_LARGE
    options.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = sweeps if method[0] == "nsgs" else 300
    reaction, velocity = np.zeros(size), np.zeros(size)
    start = time.perf_counter()
    getattr(numerics, method[2])(problem, reaction, velocity, options)
    return reaction, time.perf_counter() - start


def main(source: str, target: str, tolerances: list[float]) -> None:
    """Solve every problem by every method at every tolerance, three times each where it is quick."""
    numerics = importlib.import_module("siconos.numerics")
    with np.load(source) as file:
        data = dict(file)
    out: dict[str, Any] = {}
    for k in range(int(data["count"])):
        G, g, mu = data[f"G_{k}"], data[f"g_{k}"], data[f"mu_{k}"]
        n = mu.size
        turned = (3 * np.arange(n)[:, None] + [1, 2, 0]).ravel()
        back = np.argsort(turned)
        problem = numerics.FrictionContactProblem(3, n, G[np.ix_(back, back)], g[back], mu)
        for method in METHODS:
            spent = 0.0
            if method[0] == "newton" and n > NEWTON_CONTACTS:
                continue
            for j, tol in enumerate(tolerances):
                if spent > BUDGET:
                    break
                reaction, seconds = run(numerics, method, problem, 3 * n, tol)
                if seconds < 0.1:
                    again = [run(numerics, method, problem, 3 * n, tol)[1] for _ in range(4)]
                    seconds = float(np.median([seconds, *again]))
                spent += seconds
                out[f"{method[0]}_{k}_{j}"] = np.append(reaction[turned], seconds)
    np.savez(target, **out)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], [float(t) for t in sys.argv[3:]])
