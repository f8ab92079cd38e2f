"""Primal-dual interior point on the product of second-order cones and normal bounds.

Mehrotra's predictor-corrector with Nesterov-Todd scaling. For the convex law this is the textbook method
for min 1/2 xᵀHx + cᵀx over cones. For Coulomb's law the linear term carries the De Saxcé shift mu ||u_t||,
smoothed with the barrier and linearised along, which makes the reduced matrix non-symmetric.

Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", SIOPT 2, 1992;
L. Vandenberghe, "The CVXOPT linear and quadratic cone program solvers", 2010 (scaling and corrector);
V. Acary, P. Armand, H. M. Nguyen, "High-accuracy computation of rolling friction contact problems", 2022
(interior point with the shift).

Limits: a factorisation per iteration, sparse where many contacts have few neighbours; no warm start; for
Coulomb's law without a proof.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg

from surefoot.arrays import FloatArray, IntArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import working_time
from surefoot.solvers.newton_sparse import BlockNewton
from surefoot.solvers.scaled import scaling
from surefoot.solvers.solver import Answer, BestPoint, SolverSettings, register
from surefoot.solvers.stopping import measure_of, velocity_error

MAX_ITERATIONS, PATIENCE = 100, 15
LARGE, SPARSE_BELOW = 40, 0.4
"""Contacts above which, and share of stored blocks below which, matrices are sparse."""
REGULAR = 1e-15
"""The share of the reduced matrix's largest diagonal entry that is added to its diagonal."""
PIVOT = 0.01
"""Share of its column that a diagonal entry must reach to serve as pivot of a sparse factorisation."""
POLISH = 1e-3
"""Velocity error below which Newton steps on the contact laws take out what the barrier leaves.

The barrier leaves about the root of its gap in contacts that are only just active."""


@dataclass(frozen=True)
class _Program:
    """The problem in scaled unknowns: cones s = A y + b, first a block of 3 per cone, then single rows."""

    H: Any
    """Dense, or sparse in compressed rows as A is then."""
    c: FloatArray
    A: Any
    b: FloatArray
    cones: int
    columns: IntArray
    scale: FloatArray
    mu: FloatArray
    tangents: IntArray
    normals: IntArray


def _program(problem: ContactProblem) -> _Program:
    """Leave out what is zero, scale contacts to blocks of trace 3, and set up the cones."""
    on = problem.normal_max > 0.0
    held = np.zeros(problem.contacts, dtype=bool) if problem.bilateral is None else problem.bilateral
    rough = on & ~held & (problem.mu > 0.0)
    keep = np.repeat(on, 3)
    keep[0::3] &= rough | held
    keep[1::3] &= rough | held
    columns = np.flatnonzero(keep)
    D = scaling(problem)
    scale = D[columns]
    sparse = problem.contacts > LARGE and problem.blocks.density < SPARSE_BELOW
    if sparse:
        b = problem.blocks
        whole = sp.bsr_matrix((b.values, b.columns, b.starts), shape=problem.G.shape).tocsr()
        H = sp.diags(scale) @ whole[columns][:, columns] @ sp.diags(scale)
        H = H.tocsr()
    else:
        H = scale[:, None] * problem.G[np.ix_(columns, columns)] * scale[None, :]
    place = np.full(keep.size, -1)
    place[columns] = np.arange(columns.size)
    k = np.flatnonzero(rough)
    m = k.size
    blocks = np.zeros((3 * m, columns.size))
    blocks[3 * np.arange(m), place[3 * k + 2]] = problem.mu[k]
    blocks[3 * np.arange(m) + 1, place[3 * k]] = 1.0
    blocks[3 * np.arange(m) + 2, place[3 * k + 1]] = 1.0
    rows, ends = [blocks], [np.zeros(3 * m)]
    lower = on & ~held & (~rough | (problem.normal_min > 0.0))
    for which, sign, bound in (
        (lower, 1.0, problem.normal_min),
        (on & np.isfinite(problem.normal_max), -1.0, problem.normal_max),
    ):
        i = np.flatnonzero(which)
        row = np.zeros((i.size, columns.size))
        row[np.arange(i.size), place[3 * i + 2]] = sign
        rows.append(row)
        ends.append(-sign * bound[i] / D[3 * i + 2])
    A = np.vstack(rows)
    return _Program(
        H, scale * problem.g[columns], sp.csr_matrix(A) if sparse else A, np.concatenate(ends), m, columns,
        scale, problem.mu[k], place[np.column_stack([3 * k, 3 * k + 1])], place[3 * k + 2],
    )  # fmt: skip


class _Scaling:
    """Nesterov-Todd scaling of (s, z): W z = W⁻¹ s."""

    def __init__(self, s: FloatArray, z: FloatArray, cones: int) -> None:
        self.m = m = cones
        a, b = s[: 3 * m].reshape(-1, 3), z[: 3 * m].reshape(-1, 3)
        ds, dz = np.sqrt(_minkowski(a)), np.sqrt(_minkowski(b))
        p, q = a / ds[:, None], b / dz[:, None]
        gamma = np.sqrt(0.5 * (1.0 + (p * q).sum(axis=1)))
        w = (p + q * [1.0, -1.0, -1.0]) / (2.0 * gamma[:, None])
        beta = np.sqrt(ds / dz)
        V = np.empty((m, 3, 3))
        V[:, 0, :], V[:, 1:, 0] = w, w[:, 1:]
        V[:, 1:, 1:] = np.eye(2) + w[:, 1:, None] * w[:, None, 1:] / (1.0 + w[:, :1, None])
        sign = np.array([1.0, -1.0, -1.0])
        self.W = beta[:, None, None] * V
        self.Wi = V * (sign[:, None] * sign[None, :]) / beta[:, None, None]
        self.d = np.sqrt(s[3 * m :] / z[3 * m :])

    def apply(self, v: FloatArray, inverse: bool = False) -> FloatArray:
        """Return W v or W⁻¹ v, for a vector or the columns of a matrix."""
        m, d = self.m, self.d.reshape(-1, *[1] * (v.ndim - 1))
        blocks, tail = v[: 3 * m].reshape(m, 3, *v.shape[1:]), v[3 * m :]
        head = np.einsum("kij,kj...->ki...", self.Wi if inverse else self.W, blocks)
        return np.concatenate([head.reshape(3 * m, *v.shape[1:]), tail / d if inverse else tail * d])


def _minkowski(v: FloatArray) -> FloatArray:
    """Return v_0² - |v_1|² of rows, as a product that keeps its digits."""
    t = np.hypot(v[:, 1], v[:, 2])
    return np.maximum((v[:, 0] - t) * (v[:, 0] + t), 1e-300)


def _product(u: FloatArray, v: FloatArray, m: int) -> FloatArray:
    """Return the Jordan product u ∘ v."""
    a, b = u[: 3 * m].reshape(-1, 3), v[: 3 * m].reshape(-1, 3)
    head = np.empty_like(a)
    head[:, 0] = (a * b).sum(axis=1)
    head[:, 1:] = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:]
    return np.concatenate([head.ravel(), u[3 * m :] * v[3 * m :]])


def _divide(u: FloatArray, v: FloatArray, m: int) -> FloatArray:
    """Return w with u ∘ w = v."""
    a, b = u[: 3 * m].reshape(-1, 3), v[: 3 * m].reshape(-1, 3)
    det = _minkowski(a)
    head = np.empty_like(a)
    cross = (a[:, 1:] * b[:, 1:]).sum(axis=1)
    head[:, 0] = (a[:, 0] * b[:, 0] - cross) / det
    head[:, 1:] = (b[:, 1:] - head[:, :1] * a[:, 1:]) / a[:, :1]
    return np.concatenate([head.ravel(), v[3 * m :] / u[3 * m :]])


def _longest(s: FloatArray, ds: FloatArray, m: int) -> float:
    """Return the longest step in [0, 1] along ds that stays inside the cones."""
    longest = 1.0
    a, b = s[: 3 * m].reshape(-1, 3), ds[: 3 * m].reshape(-1, 3)
    if m:
        root = np.sqrt(_minkowski(a))
        p = a / root[:, None]
        along = p[:, 0] * b[:, 0] - (p[:, 1:] * b[:, 1:]).sum(axis=1)
        factor = (along + b[:, 0]) / (p[:, 0] + 1.0)
        rest = b[:, 1:] - factor[:, None] * p[:, 1:]
        reach = (np.hypot(rest[:, 0], rest[:, 1]) - along) / root
        longest = min(longest, 1.0 / max(float(reach.max()), 1e-300))
    t, dt = s[3 * m :], ds[3 * m :]
    down = dt < 0.0
    if down.any():
        longest = min(longest, float((-t[down] / dt[down]).min()))
    return longest


@register("interior_point", bilateral=True)
def solve_interior_point(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer:
    """Solve either law on exact cones by a primal-dual interior-point method; a (n, 3) start is unused."""
    p = _program(problem)
    if p.columns.size == 0:  # every contact is off
        return Answer(np.zeros((problem.contacts, 3)), 0)
    coulomb, m = problem.law.shift > 0.0, p.cones
    laws = problem.mu, problem.normal_min, problem.normal_max, measure_of(problem), not coulomb
    unit = np.ones(p.b.size)
    unit[: 3 * m].reshape(-1, 3)[:, 1:] = 0.0
    y = np.zeros(p.c.size)
    y[p.normals] = 1.0
    start = max(float(np.abs(p.c).max(initial=0.0)), 1e-12)
    s, z, y = start * unit, start * unit, start * y
    degree = m + p.b.size - 3 * m
    search = BestPoint(settings, MAX_ITERATIONS, np.zeros(3 * problem.contacts), math.inf, PATIENCE)
    while search.done < search.limit:
        with np.errstate(all="ignore"):  # past the last digit of the barrier: found out below
            y, s, z = _advance(p, y, s, z, unit, degree, coulomb)
        if not np.isfinite(y).all():
            search.done, search.stop = search.done + 1, Status.STALLED
            break
        forces = np.zeros(3 * problem.contacts)
        forces[p.columns] = p.scale * y
        velocities = problem.velocity(forces.reshape(-1, 3)).ravel()
        if search.over(forces, float(velocity_error(forces, velocities, *laws))):
            break
    best, done = search.best, search.done
    if settings.tol < search.error < POLISH and working_time() < search.end:
        done += BlockNewton(problem, settings.tol, search.end).run(best, 20, 0.1)[0]
    return Answer(best.reshape(-1, 3), done, search.stop)


def _advance(
    p: _Program, y: FloatArray, s: FloatArray, z: FloatArray, unit: FloatArray, degree: int, coulomb: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Take one predictor-corrector step."""
    m = p.cones
    gap = float(s @ z) / max(degree, 1)
    shift, tilt = np.zeros(p.c.size), np.zeros((m, 2))
    if coulomb and m:
        slide = p.H @ y + p.c
        t = slide[p.tangents]
        length = np.sqrt((t * t).sum(axis=1) + 1e-2 * gap)
        shift[p.normals] = p.mu * length
        tilt = p.mu[:, None] * t / length[:, None]
    dual = p.H @ y + p.c + shift - p.A.T @ z
    primal = p.A @ y + p.b - s
    W = _Scaling(s, z, m)
    solve = _factorised(p, W, tilt)

    def product(v: FloatArray) -> FloatArray:
        out = p.H @ v
        out[p.normals] += (tilt * out[p.tangents]).sum(axis=1)
        return np.asarray(out)

    middle = W.apply(z)

    def direction(target: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        rest = _divide(middle, target, m) - W.apply(primal, inverse=True)
        dy = solve(p.A.T @ W.apply(rest, inverse=True) - dual)
        dz = W.apply(rest - W.apply(p.A @ dy, inverse=True), inverse=True)
        for _ in range(2):  # refine: W⁻¹ is huge on the active cones
            more = solve(p.A.T @ dz - product(dy) - dual)
            dy = dy + more
            dz = dz - W.apply(W.apply(p.A @ more, inverse=True), inverse=True)
        return dy, p.A @ dy + primal, dz

    square = _product(middle, middle, m)
    dy, ds, dz = direction(-square)
    length = min(_longest(s, ds, m), _longest(z, dz, m))
    sigma = (1.0 - length) ** 3
    cross = _product(W.apply(ds, inverse=True), W.apply(dz), m)
    dy, ds, dz = direction(sigma * gap * unit - square - cross)
    length = min(1.0, 0.99 * min(_longest(s, ds, m), _longest(z, dz, m)) if degree else 1.0)
    return y + length * dy, s + length * ds, z + length * dz


def _factorised(p: _Program, W: _Scaling, tilt: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Return what solves with the reduced matrix K = H + (rows of normals tilted by tangents') + Aᵀ W⁻² A."""
    if sp.issparse(p.H):
        return _factorised_sparse(p, W, tilt)
    K = p.H.copy()
    K[p.normals] += tilt[:, :1] * p.H[p.tangents[:, 0]] + tilt[:, 1:] * p.H[p.tangents[:, 1]]
    WA = W.apply(p.A, inverse=True)
    K += WA.T @ WA
    K[np.diag_indices_from(K)] += REGULAR * float(np.abs(np.diagonal(K)).max(initial=0.0))
    lu, pivots, _ = scipy.linalg.lapack.dgetrf(K)  # singular gives infinities, which end the solve
    return lambda b: np.asarray(scipy.linalg.lapack.dgetrs(lu, pivots, b)[0])


def _factorised_sparse(p: _Program, W: _Scaling, tilt: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """Do the same for many contacts: W is block diagonal, so K has hardly more entries than H."""
    m, size = p.cones, p.c.size
    squares = np.einsum("kij,kjl->kil", W.Wi, W.Wi)
    parts: list[Any] = [sp.bsr_matrix((squares, np.arange(m), np.arange(m + 1)), shape=(3 * m, 3 * m))]
    parts.append(sp.diags(W.d**-2.0))
    middle: Any = sp.block_diag([part for part in parts if part.shape[0]], format="csr")
    lean: Any = sp.csr_matrix(
        (tilt.ravel(), (np.repeat(p.normals, 2), p.tangents.ravel())), shape=(size, size)
    )
    K: Any = p.H + lean @ p.H + p.A.T @ middle @ p.A
    K = K + REGULAR * float(np.abs(K.diagonal()).max(initial=0.0)) * sp.identity(size)
    try:
        factor = scipy.sparse.linalg.splu(
            K.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=PIVOT, options={"SymmetricMode": True}
        )
    except (RuntimeError, ValueError):  # singular, or not finite: ends the solve as above
        return lambda b: np.full(b.size, np.nan)
    return lambda b: np.asarray(factor.solve(b))
