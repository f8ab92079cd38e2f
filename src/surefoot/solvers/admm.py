"""Proximal ADMM: a linear solve and a projection in turn, with an adaptive penalty.

With z in K a copy of the forces and y the multiplier of x = z, each iteration solves (G + (rho + eta) I) x
= rho z - y + eta x_old - g - s, projects z = P_K(x + y / rho), and moves y. For Coulomb's law s = (0, 0, mu
||u_t||) follows the last estimate u_t = -y_t; s = 0 for the convex law. Contacts are scaled by the size of
their blocks first, which leaves cones as they are. The penalty is balanced between the primal and dual
residuals and the inverse is formed anew only when it changes much.

Source: J. Carpentier, Q. Le Lidec, L. Montaut, "From compliant to rigid contact simulation: a unified and
efficient approach", RSS 2024; S. Boyd et al., "Distributed optimization and statistical learning via ADMM",
2011; A. Tasora et al., "Solving variational inequalities and cone complementarity problems in nonsmooth
dynamics using ADMM", IJNME 122, 2021.

Limits: linear convergence, a dense (3n, 3n) inverse; for Coulomb's law a heuristic, as all of its kind.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
import scipy.linalg

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import kernel
from surefoot.solvers.natural_map import relative_gap
from surefoot.solvers.pyramid import project_any, shift_any
from surefoot.solvers.solver import Answer, Settings, register, start_forces

MAX_ITERATIONS = 20_000
CHECK_EVERY, CHECK_EVERY_LARGE, LARGE = 20, 50, 40
"""Iterations between two looks at the residual and the penalty, and above how many contacts they are more."""
FINISH_FROM, FINISH_GROWTH = 100, 1.5
"""Iterations after which something else may try to finish, and by how much more each time."""
PROXIMAL = 1e-9
RELAXATION = 1.6
BALANCE = 3.0
"""The penalty changes when one residual exceeds the other by this factor."""


@kernel
def _iterate(
    inverse: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, coulomb: bool,
    facets: int, inner: bool, rho: float, eta: float, x: FloatArray, z: FloatArray, y: FloatArray, count: int,
) -> tuple[float, float]:  # fmt: skip
    """Run `count` iterations in place; return the primal and dual residuals of the last one."""
    n = mu.size
    b = np.empty(3 * n)
    primal = dual = 0.0
    for _ in range(count):
        for k in range(n):
            i = 3 * k
            for a in range(3):
                b[i + a] = rho * z[i + a] - y[i + a] + eta * x[i + a] - g[i + a]
            if coulomb and low[k] > -np.inf:
                b[i + 2] -= shift_any(-y[i], -y[i + 1], mu[k], facets, inner)
        x[:] = 0.0
        for j in range(3 * n):  # not BLAS: its threads cost more than they bring, and row by row is as fast
            factor = b[j]
            for i in range(3 * n):
                x[i] += inverse[j, i] * factor
        primal = dual = 0.0
        for k in range(n):
            i = 3 * k
            r0 = RELAXATION * x[i] + (1.0 - RELAXATION) * z[i]
            r1 = RELAXATION * x[i + 1] + (1.0 - RELAXATION) * z[i + 1]
            r2 = RELAXATION * x[i + 2] + (1.0 - RELAXATION) * z[i + 2]
            p, q, r = project_any(
                r0 + y[i] / rho,
                r1 + y[i + 1] / rho,
                r2 + y[i + 2] / rho,
                mu[k],
                low[k],
                high[k],
                facets,
                inner,
            )
            dual = max(dual, rho * abs(p - z[i]), rho * abs(q - z[i + 1]), rho * abs(r - z[i + 2]))
            y[i] += rho * (r0 - p)
            y[i + 1] += rho * (r1 - q)
            y[i + 2] += rho * (r2 - r)
            z[i], z[i + 1], z[i + 2] = p, q, r
            primal = max(primal, abs(x[i] - p), abs(x[i + 1] - q), abs(x[i + 2] - r))
    return primal, dual


@kernel
def gap_any(
    forces: FloatArray, velocities: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray,
    step: float, coulomb: bool, facets: int, inner: bool,
) -> tuple[float, float]:  # fmt: skip
    """Return ||λ - P_K(λ - step (u + Γ(u)))|| and ||λ||, on cones or pyramids."""
    gap = size = 0.0
    for k in range(mu.size):
        i = 3 * k
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        p, q, r = velocities[i], velocities[i + 1], velocities[i + 2]
        if coulomb and low[k] > -np.inf:
            r += shift_any(p, q, mu[k], facets, inner)
        a, b, c = project_any(x - step * p, y - step * q, z - step * r, mu[k], low[k], high[k], facets, inner)
        gap += (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
        size += x * x + y * y + z * z
    return math.sqrt(gap), math.sqrt(size)


def _scaling(problem: ContactProblem) -> FloatArray:
    """Return the (3n,) factors, equal within a contact, that give every block of G the trace 3."""
    trace = np.diagonal(problem.G).reshape(-1, 3).sum(axis=1) / 3.0
    top = trace.max(initial=0.0)
    trace = np.where(trace > 1e-12 * top, trace, top if top > 0.0 else 1.0)
    return np.repeat(1.0 / np.sqrt(trace), 3)


@register("admm", polyhedral=True, bilateral=True)
def solve_admm(problem: ContactProblem, settings: Settings, warm_start: FloatArray | None) -> Answer:
    """Solve either law, on cones or pyramids, by ADMM."""
    return run_admm(problem, settings, warm_start, None)


def run_admm(
    problem: ContactProblem,
    settings: Settings,
    warm_start: FloatArray | None,
    finish: Callable[[FloatArray], tuple[FloatArray, float]] | None,
) -> Answer:
    """Run ADMM; after `FINISH_FROM` iterations, and then ever less often, `finish` may try.

    `finish` takes flat forces and returns others with their relative gap; it does not disturb the iteration.
    """
    D = _scaling(problem)
    G = D[:, None] * problem.G * D[None, :]
    g = D * problem.g
    low, high = problem.normal_min / D[2::3], problem.normal_max / D[2::3]
    coulomb, facets, inner = problem.law == "coulomb", problem.facets or 0, problem.fit == "inner"
    size = g.size
    largest = max(float(np.trace(G)) / size * 3.0, 1e-300)
    eta = PROXIMAL * largest
    rho = 0.1 * largest
    z = start_forces(problem, warm_start) / D
    x, y = z.copy(), np.zeros(size)
    if warm_start is not None:
        u = (G @ z + g).reshape(-1, 3)
        if coulomb:
            u[:, 2] = np.maximum(u[:, 2], 0.0) + np.where(
                low > -np.inf, problem.mu * np.hypot(u[:, 0], u[:, 1]), 0.0
            )
        y = -u.ravel()
    limit = MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations
    end = time.perf_counter() + settings.max_time
    step = 1.0 / problem.norm if problem.norm > 0.0 else 1.0
    free = step * float(np.linalg.norm(problem.g))
    best, best_gap = z * D, math.inf
    done, inverse, used, next_finish = 0, None, rho, FINISH_FROM
    laws = problem.mu, low, high, coulomb, facets, inner
    while done < limit:
        if inverse is None:
            inverse, used = _inverse(G, rho + eta), rho
        now = min(CHECK_EVERY_LARGE if problem.contacts > LARGE else CHECK_EVERY, limit - done)
        primal, dual = _iterate(inverse, g, *laws, rho, eta, x, z, y, now)
        done += now
        forces = z * D
        gap, norm = gap_any(
            forces, problem.velocity(forces.reshape(-1, 3)).ravel(), problem.mu, problem.normal_min,
            problem.normal_max, step, coulomb, facets, inner,
        )  # fmt: skip
        relative = float(relative_gap(gap, norm, free))
        if finish is not None and done >= next_finish and relative > settings.tol:
            next_finish = int(FINISH_GROWTH * next_finish)
            forces, relative = finish(forces)
        if relative < best_gap:
            best, best_gap = forces, relative
        if relative <= settings.tol:
            break
        if time.perf_counter() > end:
            return Answer(best.reshape(-1, 3), done, Status.MAX_TIME)
        ratio = (primal / max(np.abs(z).max(), 1e-300)) / max(dual / max(np.abs(y).max(), 1e-300), 1e-300)
        if (ratio > BALANCE or ratio < 1.0 / BALANCE) and done < 0.5 * limit:
            rho = min(max(rho * min(max(math.sqrt(ratio), 0.1), 10.0), 1e-8 * largest), 1e6 * largest)
            if rho > 1.5 * used or rho < used / 1.5:
                inverse = None
            else:
                rho = used
    return Answer(best.reshape(-1, 3), done)


def _inverse(G: FloatArray, shift: float) -> FloatArray:
    """Return the inverse of G + shift I."""
    A = G + shift * np.eye(G.shape[0])
    factor, info = scipy.linalg.lapack.dpotrf(A, lower=True)
    if info != 0:
        return np.asarray(np.linalg.inv(A))
    inverse, _ = scipy.linalg.lapack.dpotri(factor, lower=True)
    return np.ascontiguousarray(np.tril(inverse) + np.tril(inverse, -1).T)
