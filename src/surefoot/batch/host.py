"""Batches for the frameworks' roads over the CPU: NumPy in and out, in double precision."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.batch.answers import Forces
from surefoot.batch.certificate import lawful, scales
from surefoot.batch.modes import active, certified, finite, gradients
from surefoot.batch.solving import solve_batch
from surefoot.errors import ProblemError


def solve_on_host(
    G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool, tol: float
) -> FloatArray:
    """Return the (..., n, 3) forces of lawful problems G (..., 3n, 3n), g (..., 3n), mu and on (..., n)."""
    lead, size = g.shape[:-1], g.shape[-1]
    n = size // 3
    law = "convex" if convex else "coulomb"
    count = int(np.prod(lead, dtype=int))
    matrices = np.ascontiguousarray(np.broadcast_to(G, (*lead, size, size)), dtype=np.float64)
    matrices, free = matrices.reshape(count, size, size), np.asarray(g, dtype=np.float64).reshape(count, size)
    frictions = np.broadcast_to(mu, (*lead, n)).astype(np.float64).reshape(count, n)
    there = np.ascontiguousarray(np.broadcast_to(on, (*lead, n))).reshape(count, n)

    def ask(part: slice) -> FloatArray:
        given = matrices[part], free[part], frictions[part]
        return solve_batch(*given, law=law, mask=there[part], tol=tol).forces

    try:
        return ask(slice(None)).reshape(*lead, n, 3)
    except ProblemError:  # some G is visibly indefinite: its forces are zero, and the certificate says so
        out = np.zeros((count, n, 3))
        for i in range(count):
            with contextlib.suppress(ProblemError):
                out[i] = ask(slice(i, i + 1))[0]
        return out.reshape(*lead, n, 3)


def answer(G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool, tol: float) -> Forces:
    """Return the answer of double-precision problems, any entries: shapes as for `solve_on_host`."""
    with np.errstate(all="ignore"):  # what overflows shows in the status
        G, g, mu, good = lawful(np, G, g, mu)
        forces = solve_on_host(G, g, mu, on, convex, tol)
        return certified(np, G, g, mu, on, scales(np, G, g, on), forces, good, convex, tol)


def answer_gradients(
    G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool,
    point: tuple[FloatArray, FloatArray], weights: tuple[FloatArray, FloatArray],
) -> tuple[Any, ...]:  # fmt: skip
    """Return the gradients in G, g and mu of weights on the forces and velocities of an answer.

    Shapes as for `solve_on_host`; the point and the weights are forces and velocities, (..., n, 3) each.
    """
    with np.errstate(all="ignore"):
        G, g, mu, good = lawful(np, G, g, mu)
        s = scales(np, G, g, on)
        modes = active(np, *point, mu, s.weight, s.speed, on, convex)
        return finite(np, gradients(np, G, point[0], modes, weights), good)
