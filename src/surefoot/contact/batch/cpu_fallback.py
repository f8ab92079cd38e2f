"""CPU fallback of the JAX and PyTorch batches: through NumPy, in double precision."""

from __future__ import annotations

import contextlib

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.batch.solving import solve_batch


def solve_on_host(
    convex: bool, tol: float, G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray
) -> FloatArray:
    """Return the (..., n, 3) forces of lawful problems G (..., 3n, 3n), g (..., 3n), mu and on (..., n)."""
    lead, size = g.shape[:-1], g.shape[-1]
    n = size // 3
    law = "convex" if convex else "coulomb"
    count = int(np.prod(lead, dtype=int))
    matrices = np.ascontiguousarray(np.broadcast_to(G, (*lead, size, size)), dtype=np.float64)
    matrices, free = matrices.reshape(count, size, size), np.asarray(g, dtype=np.float64).reshape(count, size)
    frictions = np.broadcast_to(mu, (*lead, n)).astype(np.float64).reshape(count, n)
    there = np.broadcast_to(on, (*lead, n)).astype(np.bool_).reshape(count, n)
    most, rows = np.where(there, np.inf, 0.0), np.repeat(there, 3, axis=1)
    matrices = np.where(rows[:, :, None] & rows[:, None, :], matrices, 0.0)  # what is off is not read

    def ask(part: slice) -> FloatArray:
        given = matrices[part], free[part], frictions[part], 0.0, most[part]
        return solve_batch(*given, law, tol=tol).forces

    try:
        return ask(slice(None)).reshape(*lead, n, 3)
    except ProblemError:  # some G is visibly indefinite: its forces are zero, and the certificate says so
        out = np.zeros((count, n, 3))
        for i in range(count):
            with contextlib.suppress(ProblemError):
                out[i] = ask(slice(i, i + 1))[0]
        return out.reshape(*lead, n, 3)
