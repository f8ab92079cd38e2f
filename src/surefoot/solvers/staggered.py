"""Staggered: Coulomb's law as a fixed point of convex problems.

With the De Saxcé shift s = mu ||u_t|| frozen, the contact laws are those of a convex program; solving it
gives the next s. Each convex program is solved by Gauss-Seidel with Newton steps, warm-started, and only as
accurately as the outer iteration deserves.

Source: V. Acary, F. Cadoux, C. Lemaréchal, J. Malick, "A formulation of the linear discrete Coulomb
friction problem via convex optimization", ZAMM 91(2), 2011 (existence by this fixed point); F. Cadoux, PhD
thesis, 2009.

Limits: linear convergence, and none where mu and the coupling of normal and tangential motion are large (the
step in s is then shortened, which helps and proves nothing). For the convex law s = 0 and one pass is enough.
"""

from __future__ import annotations

import math
import time

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.solvers.compiled import attempt
from surefoot.solvers.on_blocks import alternate
from surefoot.solvers.solver import Answer, Search, SolverSettings, register, start_forces
from surefoot.solvers.stopping import measure_of, velocity_error

MAX_ITERATIONS, PATIENCE = 500, 60
INNER = 4000
"""Most sweeps and Newton steps for one convex problem on blocks: the next one starts where it ends."""


@register("staggered", bilateral=True)
def solve_staggered(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve either law by a sequence of convex problems from a (n, 3) start; iterations count them."""
    forces = start_forces(problem, warm_start)
    search = Search(settings, MAX_ITERATIONS, forces.copy(), math.inf, PATIENCE)
    coulomb = problem.law.shift > 0.0
    laws = problem.mu, problem.normal_min, problem.normal_max, measure_of(problem), not coulomb
    held = problem.normal_min == -np.inf
    convex = problem.replace(law="convex")
    shift = _shift(problem, forces, held) if coulomb else np.zeros(problem.contacts)
    relax, last = 1.0, math.inf
    while search.done < search.limit:
        convex.g[:] = problem.g
        convex.g[2::3] += shift
        tol = 0.1 * max(settings.tol, min(1e-3, 0.1 * last)) if coulomb else settings.tol
        _solve_convex(convex, SolverSettings(tol, INNER, max(search.end - time.perf_counter(), 0.0)), forces)
        velocities = problem.velocity(forces.reshape(-1, 3)).ravel()
        relative = float(velocity_error(forces, velocities, *laws))
        if search.over(forces, relative) or not coulomb:
            break
        if relative > 0.9 * last:
            relax = max(0.7 * relax, 0.1)
        last = relative
        shift = (1.0 - relax) * shift + relax * _shift(problem, forces, held)
    return Answer(search.best.reshape(-1, 3), search.done, search.stop)


def _solve_convex(problem: ContactProblem, settings: SolverSettings, forces: FloatArray) -> None:
    """Solve one of the convex problems as well as sweeps and Newton steps can, from flat forces, in place."""
    found = attempt(problem, settings.tol, settings.max_iterations, settings.max_time, forces.reshape(-1, 3))
    if found is not None:
        forces[:] = found[0][: problem.contacts].ravel()
        if found[2]:
            return
    alternate(problem, settings, forces)


def _shift(problem: ContactProblem, forces: FloatArray, held: FloatArray) -> FloatArray:
    """Return mu ||u_t|| of every contact, zero for bilateral ones."""
    u = problem.velocity(forces.reshape(-1, 3))
    return np.where(held, 0.0, problem.mu * np.hypot(u[:, 0], u[:, 1]))
