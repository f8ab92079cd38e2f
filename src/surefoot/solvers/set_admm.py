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

import time
from collections.abc import Callable

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import kernel
from surefoot.solvers.admm import next_penalty
from surefoot.solvers.set_kernels import natural_sets, pack, project_sets, shift_sets
from surefoot.solvers.solver import Answer, Settings, register

MAX_ITERATIONS, CHECK_EVERY = 20_000, 20
PROXIMAL, RELAXATION = 1e-9, 1.6
ADAPTING = 0.8
"""Share of the iterations in which the penalty may change."""
FINISH_FROM, FINISH_GROWTH = 40, 1.6
"""Iterations after which something else may try to finish, and by how much more each time."""


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


class Scaled:
    """A problem in scaled variables: λ = D λ', with what measures an answer.

    Attributes
    ----------
    D
        (m,); the length of a row times the scale of its contact, which gives every block the trace of its
        rows.
    packed
        What `set_kernels.pack` returns.
    step, weight
        (n,); see `natural_sets`.
    """

    def __init__(self, problem: ContactProblem) -> None:
        contacts, scales = problem.contact_set, problem.scales
        counts = np.diff(contacts.offsets)
        size = scales[2] / np.maximum(counts, 1)
        top = float(size.max(initial=0.0))
        size = np.where(size > 1e-12 * top, size, top if top > 0.0 else 1.0)
        unit = 1.0 / np.sqrt(size)
        self.D = contacts.lengths * np.repeat(unit, counts)
        self.G, self.g = self.D[:, None] * problem.G * self.D[None, :], self.D * problem.g
        self.packed = pack(contacts, problem.law, unit)
        w, s = scales[0], scales[1]
        w = np.where(w > 0.0, w, np.where(s > 0.0, s, 1.0))
        self.step = 1.0 / (w * unit * unit)
        self.weight = np.where(s > 0.0, w * unit / np.where(s > 0.0, s, 1.0), 0.0)
        self.point, self.gap = np.empty(self.g.size), np.empty(self.g.size)

    def error(self, forces: FloatArray) -> tuple[FloatArray, float]:
        """Return the velocities of scaled (m,) forces, and the velocity error; fills `point` and `gap`."""
        u = self.G @ forces + self.g
        return u, float(natural_sets(*self.packed, self.step, self.weight, forces, u, self.point, self.gap))


Finish = Callable[[Scaled, FloatArray], tuple[FloatArray, float]]


@register("set_admm", laws=None, polyhedral=True, bilateral=True, general=True)
def solve_set_admm(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve contacts of any kind, under any law, by ADMM from a warm start (n, d) or (m,)."""
    return run_set_admm(problem, settings, warm_start, None)


def run_set_admm(
    problem: ContactProblem, settings: Settings, warm_start: FloatArray | None, finish: Finish | None
) -> Answer:
    """Run ADMM; after `FINISH_FROM` iterations, then ever less often, `finish` may try from where it is.

    `finish` takes scaled (m,) forces, returns others with their error, and leaves the iteration be.
    """
    end = time.perf_counter() + settings.max_time
    limit = MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations
    s = Scaled(problem)
    z = s.D * 0.0 if warm_start is None else warm_start.ravel() / s.D
    x, y = z.copy(), np.zeros(z.size)
    if warm_start is not None:
        shifted = np.empty(z.size)
        shift_sets(*s.packed, s.G @ z + s.g, shifted)
        y = -shifted
    largest = max(float(np.trace(s.G)) / z.size, 1e-300)
    rho, used, eta = 0.3 * largest, 0.0, PROXIMAL * largest
    best, least = z.copy(), s.error(z)[1]
    done, next_finish = 0, FINISH_FROM
    inverse: FloatArray = s.G
    while done < limit and least > settings.tol:
        if time.perf_counter() > end:
            return Answer(best * s.D, done, Status.MAX_TIME)
        if rho != used:
            inverse, used = np.asarray(np.linalg.inv(s.G + (rho + eta) * np.eye(z.size))), rho
        now = min(CHECK_EVERY, limit - done)
        primal, dual = _iterate(inverse, s.g, *s.packed, rho, eta, x, z, y, now)
        done += now
        found, error = z.copy(), s.error(z)[1]
        if finish is not None and done >= next_finish and error > settings.tol:
            next_finish = int(FINISH_GROWTH * next_finish)
            tried, better = finish(s, z.copy())
            if better < error:
                found, error = tried, better
        if error < least:
            best, least = found, error
        if done < ADAPTING * limit:
            rho = next_penalty(rho, rho, primal, dual, z, y, largest)
    return Answer(best * s.D, done)
