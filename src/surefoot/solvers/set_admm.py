"""Proximal ADMM for contacts of any kind: a linear solve and a projection in turn.

The method of `admm`, with the projections of `set_kernels`: z a copy of the forces in K, y the multiplier of
x = z, each iteration solves (G + (rho + eta) I) x = rho z - y + eta x_old - g - θ Γ(-y), projects z = P_K(x +
y / rho), and moves y. Contacts are scaled by the size of their blocks, within them by their lengths.

Source: J. Carpentier, Q. Le Lidec, L. Montaut, "From compliant to rigid contact simulation: a unified and
efficient approach", RSS 2024; S. Boyd et al., "Distributed optimization and statistical learning via ADMM",
2011. That Γ of a wider set enters as a point's does: Acary and Bourrier 2021 (rolling).

Limits: linear convergence, a dense inverse; for shifted laws a heuristic, as all of its kind.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.problem import ContactProblem
from surefoot.kernels import kernel
from surefoot.solvers.admm import RELAXATION, Iterations, Splitting, run_admm
from surefoot.solvers.set_kernels import natural_sets, pack, project_sets, shift_sets
from surefoot.solvers.solver import Answer, SolverSettings, register


@kernel
def _iterate(
    inverse: FloatArray, g: FloatArray, offset: IntArray, group: IntArray, table: FloatArray, rho: float,
    eta: float, x: FloatArray, z: FloatArray, y: FloatArray, count: int,
) -> tuple[float, float]:  # fmt: skip
    """Run `count` iterations in place; return the primal and dual residuals of the last one."""
    b, point = np.empty(g.size), np.empty(g.size)
    primal = dual = 0.0
    for _ in range(count):
        for i in range(g.size):
            b[i] = -y[i]  # the last estimate of the velocities
        shift_sets(offset, group, table, b, point)
        for i in range(g.size):
            b[i] = rho * z[i] + eta * x[i] - g[i] - point[i] - 2.0 * y[i]  # point is -y + θ Γ(-y)
            x[i] = 0.0
        for j in range(g.size):
            factor = b[j]
            for i in range(g.size):
                x[i] += inverse[j, i] * factor
        for i in range(g.size):
            b[i] = RELAXATION * x[i] + (1.0 - RELAXATION) * z[i]
            y[i] += rho * b[i]
            b[i] = y[i] / rho
        project_sets(offset, group, table, b, point)
        primal = dual = 0.0
        for i in range(g.size):
            dual = max(dual, rho * abs(point[i] - z[i]))
            y[i] -= rho * point[i]
            z[i] = point[i]
            primal = max(primal, abs(x[i] - z[i]))
    return primal, dual


class Sets(Splitting):
    """Contacts of any kind, with what measures an answer.

    Attributes
    ----------
    packed
        What `set_kernels.pack` returns.
    step, weight
        (n,); see `natural_sets`, as for `point` and `gap` (m,).
    """

    span, start = 1.0, 0.3
    check_every, finish_from, finish_growth = 20, 40, 1.6

    def __init__(self, problem: ContactProblem, warm_start: FloatArray | None = None) -> None:
        contacts, scales = problem.contact_set, problem.scales
        counts = np.diff(contacts.offsets)
        size = scales[2] / np.maximum(counts, 1)
        top = float(size.max(initial=0.0))
        size = np.where(size > 1e-12 * top, size, top if top > 0.0 else 1.0)
        unit = 1.0 / np.sqrt(size)
        self.packed = pack(contacts, problem.law, unit)
        w, s = scales[0], scales[1]
        w = np.where(w > 0.0, w, np.where(s > 0.0, s, 1.0))
        self.step = 1.0 / (w * unit * unit)
        self.weight = np.where(s > 0.0, w * unit / np.where(s > 0.0, s, 1.0), 0.0)
        # the length of a row times the scale of its contact gives every block the trace of its rows
        super().__init__(problem, contacts.lengths * np.repeat(unit, counts), warm_start)
        self.point, self.gap = np.empty(self.g.size), np.empty(self.g.size)

    def shifted(self, u: FloatArray) -> FloatArray:
        """Return u + θ Γ(u) of scaled velocities (m,)."""
        out = np.empty(u.size)
        shift_sets(*self.packed, u, out)
        return out

    def measure(self, z: FloatArray) -> tuple[FloatArray, float]:
        """Return the velocities of scaled (m,) forces, and the velocity error; fills `point` and `gap`."""
        u = self.G @ z + self.g
        return u, float(natural_sets(*self.packed, self.step, self.weight, z, u, self.point, self.gap))

    def error(self, z: FloatArray) -> float:
        """Return the velocity error of scaled forces (m,)."""
        return self.measure(z)[1]

    def iterations(self, rho: float) -> Iterations:
        """Return what runs iterations with the inverse of G + (rho + eta) I."""
        inverse = np.asarray(np.linalg.inv(self.G + (rho + self.eta) * np.eye(self.g.size)))
        return lambda n: _iterate(
            inverse, self.g, *self.packed, rho, self.eta, self.x, self.z, self.y, n
        )  # fmt: skip


@register("set_admm", laws=None, polyhedral=True, bilateral=True, general=True)
def solve_set_admm(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve contacts of any kind, under any law, by ADMM from a warm start (n, d) or (m,)."""
    return run_admm(Sets(problem, warm_start), settings)
