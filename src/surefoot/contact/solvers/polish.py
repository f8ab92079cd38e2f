"""The end of a solve: ADMM with one penalty from forces near an answer, its iterates mixed.

Near an answer the modes of most contacts are right, and an iteration is nearly linear in z + y / rho, of
which it is a fixed point: z is its projection. Every few iterations the last such points are mixed
(`mixing`), which takes hundreds of iterations where ADMM alone takes thousands. Where mixing leads away, it
begins anew from the last point that was not mixed.

Limits: forces that are not near an answer may stay where they are.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import working_time
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solvers.admm import Splitting, limit_of
from surefoot.contact.solvers.mixing import Mixing
from surefoot.contact.solvers.scaled import ScaledContacts
from surefoot.contact.solvers.set_kernels import project_sets
from surefoot.contact.solvers.solver import Answer, SolverSettings, start_forces

PENALTIES, NEAR = (3e-2, 1e-2, 3e-3), 1e-6
"""Over the largest eigenvalue of G, tried one after the other; the error below which those after the first
are."""
EVERY, IDLE = 10, 60
"""Iterations between two looks at the error, and how many looks in turn may not halve it."""
DEPTH, AWAY = 10, 2.0
"""Differences of iterates that are mixed, and the growth of their change from which mixing led away."""


def polish(problem: ContactProblem, settings: SolverSettings, forces: FloatArray) -> Answer:
    """Iterate from forces (n, 3) near an answer, with one penalty at a time, until they come no nearer."""
    scaled = ScaledContacts(problem)
    limit, end = limit_of(settings), working_time() + settings.max_time
    best, least, done = start_forces(problem, forces) / scaled.D, math.inf, 0
    for penalty in PENALTIES:
        s = Splitting(scaled, (best * scaled.D).reshape(problem.shape))
        least, looks = scaled.measure(best)[1], 0
        aim, mixed = 0.5 * least, _Mixed(s, penalty * s.largest)
        while done < limit and least > settings.tol and looks < IDLE and working_time() < end:
            now = min(EVERY, limit - done)
            mixed.iterate(now)
            done += now
            error = scaled.measure(s.z)[1]
            if error < least:
                best, least = s.z.copy(), error
            looks += 1
            if least < aim:
                aim, looks = 0.5 * least, 0
        if least <= settings.tol or least > NEAR or done >= limit:
            break
    return Answer((best * scaled.D).reshape(problem.shape), done)


class _Mixed:
    """ADMM with one penalty, as the fixed point of z + y / rho, mixed after every few iterations."""

    def __init__(self, s: Splitting, rho: float) -> None:
        self._s, self._rho, self._run = s, rho, s.iterations(rho)
        self._mixing, self._point = Mixing(DEPTH), s.z + s.y / rho
        self._safe, self._change = self._point, math.inf

    def iterate(self, count: int) -> None:
        """Run so many iterations and mix; where that led away before, go back and mix anew."""
        s = self._s
        self._run(count)
        found = s.z + s.y / self._rho
        change = float(np.linalg.norm(found - self._point))
        if change > AWAY * self._change and len(self._mixing) > 0:
            self._mixing.forget()
            self._go_to(self._safe)
            return
        self._safe, self._change = found, change
        self._go_to(self._mixing.next(self._point, found))

    def _go_to(self, point: FloatArray) -> None:
        """Set z, its projection, and y to a point (m,)."""
        s, self._point = self._s, point
        project_sets(*s.scaled.packed, point, s.z)
        s.x[:] = s.z
        s.y[:] = self._rho * (point - s.z)
