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

Limits: linear convergence, a dense (3n, 3n) inverse or sparse factors; for Coulomb's law a heuristic, as all
of its kind.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import inline_kernel, kernel, working_time
from surefoot.numerics.elimination import invert_shifted
from surefoot.solvers.pyramid import project_any, shift_any
from surefoot.solvers.solver import Answer, SolverSettings, register, start_forces
from surefoot.solvers.stopping import measure_of, velocity_error

MAX_ITERATIONS = 20_000
CHECK_EVERY, LARGE = 20, 40
"""Iterations between two looks at residual and penalty for few contacts; and what is few."""
ENTRY = 4e-10
"""Seconds per entry of G that an iteration takes."""
ADAPTING = 0.8
"""Share of the iterations on many contacts in which the penalty may change: mass ratios find theirs late."""
SPARSE_BELOW = 0.2
"""Share of stored blocks under which many contacts are factorised as a sparse matrix."""
PROXIMAL = 1e-9
RELAXATION = 1.6
BALANCE = 3.0
"""The penalty changes when one residual exceeds the other by this factor."""


Laws = tuple[FloatArray, FloatArray, FloatArray, bool, int, bool]
"""mu, bounds below and above, whether Coulomb's law, facets, whether they are inside the cone."""
Program = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""G and g scaled by D, D itself (3n,), and the measure of `stopping` (n, 2)."""
Memory = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""x, z, y, the inverse of G + (rho + eta) I, and the state: rho, the rho that is inverted (zero for none),
eta, and the iterations after which rho stays."""


@inline_kernel
def _right_side(
    g: FloatArray, mu: FloatArray, low: FloatArray, coulomb: bool, facets: int, inner: bool, rho: float,
    eta: float, x: FloatArray, z: FloatArray, y: FloatArray, b: FloatArray,
) -> None:  # fmt: skip
    """Fill b = rho z - y + eta x - g - s."""
    for k in range(mu.size):
        i = 3 * k
        for a in range(3):
            b[i + a] = rho * z[i + a] - y[i + a] + eta * x[i + a] - g[i + a]
        if coulomb and low[k] > -np.inf:
            b[i + 2] -= shift_any(-y[i], -y[i + 1], mu[k], facets, inner)


@inline_kernel
def _update(
    mu: FloatArray, low: FloatArray, high: FloatArray, facets: int, inner: bool, rho: float, x: FloatArray,
    z: FloatArray, y: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Project z = P_K(x + y / rho) with x over-relaxed and move y; return the primal and dual residuals."""
    primal = dual = 0.0
    share = 1.0 / rho
    for k in range(mu.size):
        i = 3 * k
        r0 = RELAXATION * x[i] + (1.0 - RELAXATION) * z[i]
        r1 = RELAXATION * x[i + 1] + (1.0 - RELAXATION) * z[i + 1]
        r2 = RELAXATION * x[i + 2] + (1.0 - RELAXATION) * z[i + 2]
        p, q, r = project_any(
            r0 + y[i] * share, r1 + y[i + 1] * share, r2 + y[i + 2] * share, mu[k], low[k], high[k], facets,
            inner,
        )  # fmt: skip
        dual = max(dual, rho * abs(p - z[i]), rho * abs(q - z[i + 1]), rho * abs(r - z[i + 2]))
        y[i] += rho * (r0 - p)
        y[i + 1] += rho * (r1 - q)
        y[i + 2] += rho * (r2 - r)
        z[i], z[i + 1], z[i + 2] = p, q, r
        primal = max(primal, abs(x[i] - p), abs(x[i + 1] - q), abs(x[i + 2] - r))
    return primal, dual


@kernel
def _iterate(
    inverse: FloatArray, g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, coulomb: bool,
    facets: int, inner: bool, rho: float, eta: float, x: FloatArray, z: FloatArray, y: FloatArray, count: int,
) -> tuple[float, float]:  # fmt: skip
    """Run `count` iterations in place; return the primal and dual residuals of the last one."""
    b = np.empty(g.size)
    primal = dual = 0.0
    for _ in range(count):
        _right_side(g, mu, low, coulomb, facets, inner, rho, eta, x, z, y, b)
        for i in range(g.size):
            x[i] = 0.0
        for j in range(g.size):  # not BLAS: its threads cost more than they bring, and row by row is as fast
            factor = b[j]
            for i in range(g.size):
                x[i] += inverse[j, i] * factor
        primal, dual = _update(mu, low, high, facets, inner, rho, x, z, y)
    return primal, dual


@kernel
def _half_step(
    g: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, coulomb: bool, facets: int, inner: bool,
    rho: float, eta: float, x: FloatArray, z: FloatArray, y: FloatArray, b: FloatArray, projecting: bool,
) -> tuple[float, float]:  # fmt: skip
    """Do what lies on one side of the linear solve: fill b, or project and move y."""
    if projecting:
        return _update(mu, low, high, facets, inner, rho, x, z, y)
    _right_side(g, mu, low, coulomb, facets, inner, rho, eta, x, z, y, b)
    return 0.0, 0.0


@inline_kernel
def next_penalty(
    rho: float, used: float, primal: float, dual: float, z: FloatArray, y: FloatArray, largest: float
) -> float:
    """Return the penalty that balances the residuals of z, y (m,), or the one in use if that is near enough.

    rho sqrt((primal / max |z|) / (dual / max |y|)): Boyd et al. 2011, section 3.4.1, in relative residuals.
    `largest` is about the largest eigenvalue of G, which bounds it from both sides.
    """
    most_z = most_y = 1e-300
    for i in range(z.size):
        most_z, most_y = max(most_z, abs(z[i])), max(most_y, abs(y[i]))
    ratio = (primal / most_z) / max(dual / most_y, 1e-300)
    if 1.0 / BALANCE <= ratio <= BALANCE:
        return rho
    rho = min(max(rho * min(max(math.sqrt(ratio), 0.1), 10.0), 1e-8 * largest), 1e6 * largest)
    return rho if rho > 1.5 * used or rho < used / 1.5 else used


@kernel
def _run_dense(
    scaled: Program, laws: Laws, memory: Memory, tol: float, limit: int, best: FloatArray
) -> tuple[int, float]:
    """Iterate to the tolerance or the limit; return the iterations and the least velocity error, of `best`.

    `best` (3n,) is filled with forces in their own units; the rest is scaled by D.
    """
    G, g, D, measure = scaled
    mu, low, high, coulomb, facets, inner = laws
    x, z, y, inverse, state = memory
    m, n = g.size, mu.size
    largest = state[2] / PROXIMAL
    forces, velocities = np.empty(m), np.empty(m)
    own_low, own_high = np.empty(n), np.empty(n)
    for k in range(n):
        own_low[k], own_high[k] = low[k] * D[3 * k + 2], high[k] * D[3 * k + 2]
    done, least = 0, np.inf
    while done < limit:
        rho = state[0]
        if state[1] == 0.0:
            # (G + (rho + eta) I) x = rho z + eta x - g - y - θ Γ: inverted once for each penalty
            invert_shifted(G, rho + state[2], inverse)
            state[1] = rho
        now = min(CHECK_EVERY, limit - done)
        primal, dual = _iterate(
            inverse, g, mu, low, high, coulomb, facets, inner, rho, state[2], x, z, y, now
        )  # fmt: skip
        done += now
        for i in range(m):  # u = G z + g at the copy, which is admissible; x is not
            velocities[i] = g[i]
        for i in range(m):
            for j in range(m):
                velocities[j] += G[i, j] * z[i]
        for i in range(m):
            forces[i] = z[i] * D[i]
            velocities[i] /= D[i]
        relative = velocity_error(
            forces, velocities, mu, own_low, own_high, measure, not coulomb, facets, inner
        )
        if relative < least:
            least = relative
            for i in range(m):
                best[i] = forces[i]
        if relative <= tol:
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


class Splitting(ABC):
    """A problem in scaled variables λ = D λ', and where its iteration is.

    Attributes
    ----------
    D, G, g
        (m,) the scale of each row, and the problem in the scaled variables.
    x, z, y
        (m,) see `admm`; z from the warm start, and y from its velocities.
    rho, eta, largest
        The first penalty, the proximal term, and about the largest eigenvalue of G.
    span, start
        `largest` over the mean eigenvalue, and the first penalty over `largest`.
    check_every, finish_from, finish_growth
        Iterations between two looks at the error; those after which something else may try to finish, and by
        how much more each time.
    """

    span: float
    start: float
    check_every: int
    finish_from: int
    finish_growth: float

    def __init__(self, problem: ContactProblem, D: FloatArray, warm_start: FloatArray | None) -> None:
        self.problem, self.D = problem, D
        self.G, self.g = D[:, None] * problem.G * D[None, :], D * problem.g
        self.largest = max(float(np.trace(self.G)) / self.g.size * self.span, 1e-300)
        self.eta, self.rho = PROXIMAL * self.largest, self.start * self.largest
        self.z = start_forces(problem, warm_start) / D
        self.x, self.y = self.z.copy(), np.zeros(self.g.size)
        if warm_start is not None:
            self.y = -self.shifted(self.G @ self.z + self.g)

    @abstractmethod
    def shifted(self, u: FloatArray) -> FloatArray:
        """Return scaled velocities (m,) with the law's shift."""

    @abstractmethod
    def iterations(self, rho: float) -> Iterations:
        """Return what runs iterations with a penalty."""

    @abstractmethod
    def error(self, z: FloatArray) -> float:
        """Return the velocity error of scaled forces (m,)."""


def scaling(problem: ContactProblem) -> FloatArray:
    """Return the (3n,) factors, equal within a contact, that give every block of G the trace 3."""
    trace = np.diagonal(problem.G).reshape(-1, 3).sum(axis=1) / 3.0
    top = trace.max(initial=0.0)
    trace = np.where(trace > 1e-12 * top, trace, top if top > 0.0 else 1.0)
    return np.repeat(1.0 / np.sqrt(trace), 3)


class Cones(Splitting):
    """Contacts of three rows on cones or pyramids: compiled for few of them, with sparse factors for many."""

    span, start = 3.0, 0.1
    check_every, finish_from, finish_growth = 50, 100, 1.5

    def __init__(self, problem: ContactProblem, warm_start: FloatArray | None) -> None:
        D = scaling(problem)
        low, high = problem.normal_min / D[2::3], problem.normal_max / D[2::3]
        self.coulomb, facets, inner = problem.law.shift > 0.0, problem.facets or 0, problem.fit == "inner"
        self.laws = problem.mu, low, high, self.coulomb, facets, inner
        self.measure = measure_of(problem)
        self.own = (
            problem.mu,
            problem.normal_min,
            problem.normal_max,
            self.measure,
            not self.coulomb,
            facets,
            inner,
        )
        super().__init__(problem, D, warm_start)
        self.sparse: Any = None
        if problem.contacts > LARGE and problem.blocks.density < SPARSE_BELOW:
            self.sparse = sp.csc_matrix(self.G)

    def shifted(self, u: FloatArray) -> FloatArray:
        """Return scaled velocities (m,) with Coulomb's shift, none of them into the ground."""
        if self.coulomb:
            t, n = np.hypot(u[0::3], u[1::3]), u[2::3]
            slip = np.where(self.laws[1] > -np.inf, self.problem.mu * t, 0.0)
            u[2::3] = np.maximum(n, 0.0) + slip
        return u

    def error(self, z: FloatArray) -> float:
        """Return the velocity error of scaled forces (m,)."""
        forces = z * self.D
        velocities = self.problem.velocity(forces.reshape(-1, 3)).ravel()
        return float(velocity_error(forces, velocities, *self.own))

    def iterations(self, rho: float) -> Iterations:
        """Return what runs iterations with the inverse of G + (rho + eta) I, or with its sparse factors."""
        shift = rho + self.eta
        if self.sparse is None:
            inverse = _inverse(self.G, shift)
            return lambda n: _iterate(inverse, self.g, *self.laws, rho, self.eta, self.x, self.z, self.y, n)
        matrix = (self.sparse + shift * sp.identity(self.g.size, format="csc")).tocsc()
        # positive definite: the diagonal serves as pivot, and the ordering may look at G alone
        factor = scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        return lambda n: self._iterate_sparse(factor, rho, n)

    def _iterate_sparse(self, factor: Any, rho: float, count: int) -> tuple[float, float]:
        """Run `count` iterations with a sparse factorisation; see `_iterate`."""
        half = self.g, *self.laws, rho, self.eta, self.x, self.z, self.y, np.empty(self.g.size)
        primal = dual = 0.0
        for _ in range(count):
            _half_step(*half, False)
            self.x[:] = factor.solve(half[-1])
            primal, dual = _half_step(*half, True)
        return primal, dual


@register("admm", polyhedral=True, bilateral=True)
def solve_admm(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve either law, on cones or pyramids, from a (n, 3) warm start by ADMM."""
    s = Cones(problem, warm_start)
    if problem.contacts > LARGE:
        return run_admm(s, settings)
    size, tol = s.g.size, settings.tol
    limit = MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations
    end = working_time() + settings.max_time
    inverse, state = np.empty((size, size)), np.array([s.rho, 0.0, s.eta, 0.5 * limit])
    chunk = limit
    if settings.max_time < math.inf:  # the clock is read four times or more
        chunk = max(CHECK_EVERY, int(0.25 * settings.max_time / (ENTRY * size * (size + 30))))
    program, memory = (s.G, s.g, s.D, s.measure), (s.x, s.z, s.y, inverse, state)
    best, least, done, found = s.z * s.D, math.inf, 0, np.empty(size)
    while done < limit and least > tol:
        if done > 0 and working_time() > end:
            return Answer(best.reshape(-1, 3), done, Status.MAX_TIME)
        used, gap = _run_dense(program, s.laws, memory, tol, min(chunk, limit - done), found)
        done += used
        if gap < least:
            best, least = found.copy(), gap
    return Answer(best.reshape(-1, 3), done)


def run_admm(s: Splitting, settings: SolverSettings, finish: Finish | None = None) -> Answer:
    """Run ADMM; after `finish_from` iterations, then ever less often, `finish` may try from where it is."""
    end = working_time() + settings.max_time
    limit = MAX_ITERATIONS if settings.max_iterations is None else settings.max_iterations
    shape, rho, used = s.problem.shape, s.rho, 0.0
    best, least, done, next_finish = s.z * s.D, s.error(s.z), 0, s.finish_from
    while done < limit and least > settings.tol:
        if working_time() > end:
            return Answer(best.reshape(shape), done, Status.MAX_TIME)
        if rho != used:
            iterate, used = s.iterations(rho), rho
        now = min(s.check_every, limit - done)
        primal, dual = iterate(now)
        done += now
        found, error = s.z * s.D, s.error(s.z)
        if finish is not None and done >= next_finish and error > settings.tol:
            next_finish = int(s.finish_growth * next_finish)
            tried, better = finish(s.z)
            if better < error:
                found, error = tried, better
        if error < least:
            best, least = found, error
        if done < ADAPTING * limit:
            rho = next_penalty(rho, used, primal, dual, s.z, s.y, s.largest)
    return Answer(best.reshape(shape), done)


def _inverse(G: FloatArray, shift: float) -> FloatArray:
    """Return the inverse of G + shift I."""
    A = G + shift * np.eye(G.shape[0])
    factor, info = scipy.linalg.lapack.dpotrf(A, lower=True)
    if info != 0:
        return np.asarray(np.linalg.inv(A))
    inverse, _ = scipy.linalg.lapack.dpotri(factor, lower=True)
    return np.ascontiguousarray(np.tril(inverse) + np.tril(inverse, -1).T)
