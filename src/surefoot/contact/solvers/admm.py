"""Proximal ADMM: a linear solve and a projection in turn, with an adaptive penalty.

With z in K a copy of the forces and y the multiplier of x = z, each iteration solves (G + (rho + eta) I) x
= rho z - y + eta x_old - g - s, projects z = P_K(x + y / rho), and moves y. The shift s = θ Γ(u) follows the
last estimate u = -y of the velocities; s = 0 for the convex law. Contacts of any kind, under any law; they
are scaled by the size of their blocks first, which leaves cones as they are. The penalty is balanced between
the primal and dual residuals and the inverse is formed anew only when it changes much.

Source: J. Carpentier, Q. Le Lidec, L. Montaut, "From compliant to rigid contact simulation: a unified and
efficient approach", RSS 2024; S. Boyd et al., "Distributed optimization and statistical learning via ADMM",
2011; A. Tasora et al., "Solving variational inequalities and cone complementarity problems in nonsmooth
dynamics using ADMM", IJNME 122, 2021. That Γ of a wider set enters as a point's does: Acary and Bourrier 2021
(rolling).

Limits: linear convergence, a dense (m, m) inverse or sparse factors; for shifted laws a heuristic, as all of
its kind.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel, working_time
from surefoot.base.numerics.elimination import invert_shifted
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.contact.solvers.admm_penalty import PenaltyFloor, next_penalty
from surefoot.contact.solvers.nsgs import refresh_dense
from surefoot.contact.solvers.reduced_structure import find_structure
from surefoot.contact.solvers.reduced_system import (
    Factors,
    ReducedSystem,
    Rows,
    apply_rows,
    gather_rows,
    solve_factors,
)
from surefoot.contact.solvers.scaled import ScaledContacts
from surefoot.contact.solvers.set_kernels import Packing, add_shift, natural_sets, project_sets
from surefoot.contact.solvers.solver import Answer, SolverSettings, register, start_forces

MAX_ITERATIONS = 20_000
CHECK_EVERY, CHECK_MANY, LARGE = 20, 50, 40
"""Iterations between two looks at residual and penalty for few contacts and for many; and what is few."""
ENTRY = 4e-10
"""Seconds per entry of G that an iteration takes."""
ADAPTING_FEW, ADAPTING = 0.5, 0.8
"""Share of the iterations in which the penalty may change, on few contacts and on many: mass ratios find
theirs late."""
SPARSE_BELOW = 0.2
"""Share of stored blocks under which many contacts are factorised as a sparse matrix."""
LARGEST, FIRST, PROXIMAL = 3.0, 0.1, 1e-9
"""About the largest eigenvalue of G over its mean; the first penalty and the proximal term over that."""
RELAXATION = 1.6
FINISH_FROM, FINISH_GROWTH = 2, 1.5
"""Looks after which something else may try to finish, and by how much later each time."""

Memory = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""x, z, y, the inverse of G + (rho + eta) I, and the state: rho, the rho that is inverted (zero for none),
eta, and the iterations after which rho stays."""


@inline_kernel
def _right_side(
    offset: IntArray, group: IntArray, table: FloatArray, g: FloatArray, rho: float, eta: float,
    x: FloatArray, z: FloatArray, y: FloatArray, b: FloatArray,
) -> None:  # fmt: skip
    """Fill b = rho z - y + eta x - g - θ Γ(-y)."""
    # stationarity of the augmented Lagrangian: G x + g + s + y + rho (x - z) + eta (x - x_old) = 0
    for i in range(g.size):
        b[i] = rho * z[i] - y[i] + eta * x[i] - g[i]
    # at the solution -y = u + Γ(u), and Γ reads only tangential rows, which are those of u: s
    # lags by an iteration, which makes the program convex in between and the whole a
    # fixed-point heuristic for Coulomb's law
    add_shift(offset, group, table, y, -1.0, b)


@inline_kernel
def _update(
    offset: IntArray, group: IntArray, table: FloatArray, rho: float, x: FloatArray, z: FloatArray,
    y: FloatArray, b: FloatArray, point: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Project z = P_K(x + y / rho) with x over-relaxed and move y; return the primal and dual residuals."""
    primal = dual = 0.0
    share = 1.0 / rho
    # over-relaxation: x is pushed 1.6 times as far from z (Boyd et al. 2011, section 3.4.3: 1.5 to 1.8)
    for i in range(x.size):
        b[i] = RELAXATION * x[i] + (1.0 - RELAXATION) * z[i]
        point[i] = b[i] + y[i] * share
    project_sets(offset, group, table, point, point)
    for i in range(x.size):
        # rho (z_new - z_old) is what x's stationarity lacks at the new z: the dual
        # residual, Boyd et al. 2011, section 3.3
        dual = max(dual, rho * abs(point[i] - z[i]))
        y[i] += rho * (b[i] - point[i])
        z[i] = point[i]
        primal = max(primal, abs(x[i] - point[i]))
    return primal, dual


@kernel
def iterate(
    inverse: FloatArray, packed: Packing, g: FloatArray, rho: float, eta: float, x: FloatArray, z: FloatArray,
    y: FloatArray, count: int,
) -> tuple[float, float]:  # fmt: skip
    """Run `count` iterations in place; return the primal and dual residuals of the last one.

    The inverse (m, m) is that of G + (rho + eta) I; g, x, z and y are (m,), all in scaled variables.
    """
    b, point = np.empty(g.size), np.empty(g.size)
    offset, group, table = packed
    primal = dual = 0.0
    for _ in range(count):
        _right_side(offset, group, table, g, rho, eta, x, z, y, b)
        for i in range(g.size):
            x[i] = 0.0
        for j in range(g.size):  # not BLAS: its threads cost more than they bring, and row by row is as fast
            factor = b[j]
            for i in range(g.size):
                x[i] += inverse[j, i] * factor
        primal, dual = _update(offset, group, table, rho, x, z, y, b, point)
    return primal, dual


@kernel
def _iterate_bodies(
    factors: Factors, rows: Rows, packed: Packing, g: FloatArray, rho: float, eta: float, x: FloatArray,
    z: FloatArray, y: FloatArray, count: int,
) -> tuple[float, float]:  # fmt: skip
    """Run `count` iterations in place as `iterate` does, with the factors of I + Yᵀ Y / (rho + eta).

    By Woodbury (G + s I)⁻¹ b = (b - Y (I + Yᵀ Y / s)⁻¹ Yᵀ b / s) / s, G = Y Yᵀ; g, x, z and y are (m,).
    """
    b, point, v = np.empty(g.size), np.empty(g.size), np.empty(rows.size)
    offset, group, table = packed
    share = 1.0 / (rho + eta)
    primal = dual = 0.0
    for _ in range(count):
        _right_side(offset, group, table, g, rho, eta, x, z, y, b)
        gather_rows(rows, b.reshape(-1, 3), v)
        solve_factors(factors, v)
        apply_rows(rows, v, x)
        for i in range(g.size):
            x[i] = share * (b[i] - share * x[i])
        primal, dual = _update(offset, group, table, rho, x, z, y, b, point)
    return primal, dual


@kernel
def _half_step(
    packed: Packing, g: FloatArray, rho: float, eta: float, x: FloatArray, z: FloatArray, y: FloatArray,
    b: FloatArray, point: FloatArray, projecting: bool,
) -> tuple[float, float]:  # fmt: skip
    """Do what lies on one side of the linear solve: fill b, or project and move y."""
    offset, group, table = packed
    if projecting:
        return _update(offset, group, table, rho, x, z, y, b, point)
    _right_side(offset, group, table, g, rho, eta, x, z, y, b)
    return 0.0, 0.0


@kernel
def _run_dense(
    G: FloatArray, g: FloatArray, packed: Packing, step: FloatArray, weight: FloatArray, memory: Memory,
    tol: float, limit: int, best: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Iterate to the tolerance or the limit; return the iterations and the least velocity error, of `best`.

    G (m, m), g (m,) and the forces `best` (m,) that are filled are scaled; step and weight (n,) are those of
    `natural_sets`.
    """
    x, z, y, inverse, state = memory
    m = g.size
    # eta was set to PROXIMAL times it: the state need not hold both
    largest = state[2] / PROXIMAL
    velocities, point, gap = np.empty(m), np.empty(m), np.empty(m)
    done, least = 0, np.inf
    while done < limit:
        rho = state[0]
        if state[1] == 0.0:
            # (G + (rho + eta) I) x = rho z + eta x - g - y - θ Γ: inverted once for each penalty
            invert_shifted(G, rho + state[2], inverse)
            state[1] = rho
        now = min(CHECK_EVERY, limit - done)
        primal, dual = iterate(inverse, packed, g, rho, state[2], x, z, y, now)
        done += now
        refresh_dense(G, g, z, velocities)  # at the copy, which is admissible; x is not
        error = natural_sets(packed[0], packed[1], packed[2], step, weight, z, velocities, point, gap)
        # ADMM is not monotone, least of all with a shift: the best copy is the answer
        if error < least:
            least = error
            for i in range(m):
                best[i] = z[i]
        if error <= tol:
            break
        state[3] -= now
        # the penalty moves only while changes are left: else it need not converge
        if state[3] > 0.0:
            state[0] = next_penalty(rho, state[1], primal, dual, z, y, largest)
            if state[0] != state[1]:
                state[1] = 0.0
    return done, least


Iterations = Callable[[int], tuple[float, float]]
"""Runs that many iterations with one penalty; returns the primal and dual residuals of the last one."""
Finish = Callable[[FloatArray], tuple[FloatArray, float]]
"""Takes scaled (m,) forces, leaves them be, and returns others, not scaled, with their velocity error."""


class Splitting:
    """Where the iteration on a problem is.

    Attributes
    ----------
    scaled
        The problem.
    x, z, y
        (m,) see the module; z from the warm start, and y from its velocities.
    bodies
        The matrix of known bodies' velocities, where it is sparse; else None.
    rho, eta, largest
        The first penalty, the proximal term, and about the largest eigenvalue of G.
    """

    def __init__(self, scaled: ScaledContacts, warm_start: FloatArray | None) -> None:
        self.scaled, problem = scaled, scaled.problem
        # the mean of G's diagonal stands for its spectrum; blocks have one trace in scaled variables
        own = scaled.D * problem.operator.diagonal() * scaled.D
        self.largest = max(float(own.sum()) / scaled.g.size * LARGEST, 1e-300)
        self.eta, self.rho = PROXIMAL * self.largest, FIRST * self.largest
        self.z = start_forces(problem, warm_start) / scaled.D
        self.x, self.y = self.z.copy(), np.zeros(self.z.size)
        self.factor, self.bodies = None, None
        self._many = problem.contacts > LARGE and not problem.general
        if self._many and problem.factor is not None:
            # G + s I is inverted by (Yᵀ Y + s I): Woodbury, as large as the bodies' velocities are many
            self.factor = (sp.diags(scaled.D) @ problem.factor).tocsr()
            structure = find_structure(self.factor)
            if structure.sparse:
                self.bodies = ReducedSystem(self.factor, np.ones(problem.shape), structure)
        if warm_start is not None:
            # y = -(u + Γ(u)) at a solution: from the warm forces' own velocities
            dense, normals = self.factor is None and self.sparse is None, scaled.normals
            u = scaled.G @ self.z + scaled.g if dense else scaled.velocities(self.z)
            self.y -= u
            if problem.law.shift > 0.0:  # none of them into the ground
                self.y[normals] = -np.maximum(u[normals], 0.0)
                add_shift(*scaled.packed, -u, -1.0, self.y)

    @cached_property
    def sparse(self) -> Any:
        """What SuperLU factorises once a multiple of I is added: Yᵀ Y, or G; None where G is dense."""
        if self.factor is not None:
            return (self.factor.T @ self.factor).tocsc()
        problem, D = self.scaled.problem, sp.diags(self.scaled.D)
        if not self._many or problem.blocks.density >= SPARSE_BELOW:
            return None
        return (D @ sp.csc_matrix(problem.operator) @ D).tocsc()

    def iterations(self, rho: float) -> Iterations:
        """Return what runs iterations with the inverse of G + (rho + eta) I, or with its sparse factors."""
        shift, s = rho + self.eta, self.scaled
        if self.bodies is not None:
            weights = np.broadcast_to(np.eye(3) / shift, (s.problem.contacts, 3, 3))
            factors = self.bodies.factorise(np.ascontiguousarray(weights))
            if factors is not None:
                program = factors, self.bodies.rows, s.packed, s.g, rho, self.eta
                return lambda n: _iterate_bodies(*program, self.x, self.z, self.y, n)
        if self.sparse is None:
            inverse = _inverse(s.G, shift)
            return lambda n: iterate(inverse, s.packed, s.g, rho, self.eta, self.x, self.z, self.y, n)
        matrix = (self.sparse + shift * sp.identity(self.sparse.shape[0], format="csc")).tocsc()
        # positive definite: the diagonal serves as pivot, and the ordering may look at G alone
        factor = scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        solve, Y = factor.solve, self.factor
        if Y is not None:
            Z = Y.T.tocsr()
            return lambda n: self._iterate_sparse(lambda b: (b - Y @ factor.solve(Z @ b)) / shift, rho, n)
        return lambda n: self._iterate_sparse(solve, rho, n)

    def _iterate_sparse(
        self, solve: Callable[[FloatArray], FloatArray], rho: float, count: int
    ) -> tuple[float, float]:
        """Run `count` iterations with what solves the linear system; see `iterate`."""
        b, point = np.empty(self.z.size), np.empty(self.z.size)
        half = self.scaled.packed, self.scaled.g, rho, self.eta, self.x, self.z, self.y, b, point
        primal = dual = 0.0
        for _ in range(count):
            _half_step(*half, False)
            self.x[:] = solve(b)
            primal, dual = _half_step(*half, True)
        return primal, dual


@register("admm", laws=None, polyhedral=True, bilateral=True, general=True)
def solve_admm(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve contacts of any kind, under any law, by ADMM from a warm start (n, 3), (n, d) or (m,)."""
    scaled = ScaledContacts(problem)
    size, tol = scaled.g.size, settings.tol
    if size > 3 * LARGE:
        return run_admm(scaled, settings, warm_start)
    s, limit = Splitting(scaled, warm_start), limit_of(settings)
    end = working_time() + settings.max_time
    # state[1] = 0: no inverse yet. After state[3] iterations the penalty stays,
    # without which ADMM need not converge
    memory = s.x, s.z, s.y, np.empty((size, size)), np.array([s.rho, 0.0, s.eta, ADAPTING_FEW * limit])
    chunk = limit
    if settings.max_time < math.inf:  # the clock is read four times or more
        chunk = max(CHECK_EVERY, int(0.25 * settings.max_time / (ENTRY * size * (size + 30))))
    program = scaled.G, scaled.g, scaled.packed, scaled.step, scaled.weight, memory
    best, least, done, found = s.z.copy(), math.inf, 0, np.empty(size)
    stop = Status.MAX_ITERATIONS
    while done < limit and least > tol:
        if done > 0 and working_time() > end:
            stop = Status.MAX_TIME
            break
        used, error = _run_dense(*program, tol, min(chunk, limit - done), found)
        done += used
        if error < least:
            best, least = found.copy(), error
    return Answer((best * scaled.D).reshape(problem.shape), done, stop)


def run_admm(
    scaled: ScaledContacts,
    settings: SolverSettings,
    warm_start: FloatArray | None,
    finish: Finish | None = None,
) -> Answer:
    """Run ADMM from (rows,) forces, any unit; after a while, then ever less often, `finish` may try."""
    s, limit = Splitting(scaled, warm_start), limit_of(settings)
    end = working_time() + settings.max_time
    every = CHECK_MANY if scaled.problem.contacts > LARGE else CHECK_EVERY
    shape, rho, used = scaled.problem.shape, s.rho, 0.0
    best, least, done, next_finish = s.z * scaled.D, scaled.measure(s.z)[1], 0, FINISH_FROM * every
    floor = PenaltyFloor(s.largest)
    while done < limit and least > settings.tol:
        if working_time() > end:
            return Answer(best.reshape(shape), done, Status.MAX_TIME)
        if rho != used:
            run, used = s.iterations(rho), rho
        now = min(every, limit - done)
        primal, dual = run(now)
        done += now
        found, error = s.z * scaled.D, scaled.measure(s.z)[1]
        floor.look(error, rho, now)
        if finish is not None and done >= next_finish and error > settings.tol:
            next_finish = int(FINISH_GROWTH * next_finish)
            tried, better = finish(s.z)
            if better < error:
                found, error = tried, better
        if error < least:
            best, least = found, error
        # a penalty that changed for ever would void the proof of
        # convergence (Boyd et al. 2011, section 3.4.1)
        if done < ADAPTING * limit:
            rho = next_penalty(rho, used, primal, dual, s.z, s.y, s.largest)
        # the floor may move later, too, but only where nothing has converged for long
        rho = max(rho, floor.least)
    return Answer(best.reshape(shape), done)


def limit_of(settings: SolverSettings) -> int:
    """Return the iterations that ADMM may take."""
    return MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations


def _inverse(G: FloatArray, shift: float) -> FloatArray:
    """Return the inverse of G + shift I."""
    A = G + shift * np.eye(G.shape[0])
    factor, info = scipy.linalg.lapack.dpotrf(A, lower=True)
    # not definite: rounding left G an eigenvalue below minus the shift
    if info != 0:
        return np.asarray(np.linalg.inv(A))
    inverse, _ = scipy.linalg.lapack.dpotri(factor, lower=True)
    return np.ascontiguousarray(np.tril(inverse) + np.tril(inverse, -1).T)
