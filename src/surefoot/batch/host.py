"""Batches for the frameworks' roads over the CPU: NumPy in and out, in double precision."""

from __future__ import annotations

from typing import Any

import numpy as np

import surefoot
from surefoot.arrays import BoolArray, FloatArray
from surefoot.batch.answers import Forces
from surefoot.batch.certificate import lawful, scales
from surefoot.batch.modes import active, certified, finite, gradients
from surefoot.contact.problem import COMPILED_CONTACTS, Law
from surefoot.errors import ProblemError
from surefoot.solvers.contact_solver import ContactSolver


def solve_on_host(
    G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool, tol: float
) -> FloatArray:
    """Return the (..., n, 3) forces of lawful problems G (..., 3n, 3n), g (..., 3n), mu and on (..., n)."""
    lead, size = g.shape[:-1], g.shape[-1]
    n = size // 3
    law: Law = "convex" if convex else "coulomb"
    count = int(np.prod(lead, dtype=int))
    matrices = np.ascontiguousarray(np.broadcast_to(G, (*lead, size, size)), dtype=np.float64)
    matrices, free = matrices.reshape(count, size, size), np.asarray(g, dtype=np.float64).reshape(count, size)
    frictions = np.broadcast_to(mu, (*lead, n)).astype(np.float64).reshape(count, n)
    most = np.where(np.broadcast_to(on, (*lead, n)).reshape(count, n), np.inf, 0.0)
    many = getattr(surefoot, "solve_batch", None)
    if many is not None and n <= COMPILED_CONTACTS:
        mask = np.broadcast_to(on, (*lead, n)).reshape(count, n)
        return np.asarray(many(matrices, free, frictions, law=law, mask=mask, tol=tol).forces).reshape(
            *lead, n, 3
        )
    out = np.zeros((count, n, 3))
    for i in range(count):
        try:
            out[i] = (
                ContactSolver(n, frictions[i], law, 0.0, most[i], tol=tol).solve(matrices[i], free[i]).forces
            )
        except ProblemError:  # visibly indefinite: the certificate says what zero forces are worth
            continue
    return out.reshape(*lead, n, 3)


def answer(G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool, tol: float) -> Forces:
    """Return the answer of double-precision problems, any entries."""
    with np.errstate(all="ignore"):  # what overflows shows in the status
        G, g, mu, good = lawful(np, G, g, mu)
        forces = solve_on_host(G, g, mu, on, convex, tol)
        return certified(np, G, g, mu, on, scales(np, G, g, on), forces, good, convex, tol)


def answer_gradients(
    G: FloatArray, g: FloatArray, mu: FloatArray, on: BoolArray, convex: bool,
    point: tuple[FloatArray, FloatArray], weights: tuple[FloatArray, FloatArray],
) -> tuple[Any, ...]:  # fmt: skip
    """Return the gradients in G, g and mu of weights on the forces and velocities of an answer."""
    with np.errstate(all="ignore"):
        G, g, mu, good = lawful(np, G, g, mu)
        s = scales(np, G, g, on)
        modes = active(np, *point, mu, s.weight, s.speed, on, convex)
        return finite(np, gradients(np, G, point[0], modes, weights), good)
