"""Derivatives of an exact step: the laws' active equations, differentiated at their solution.

At a solution each block keeps equations: what holds does not move, what slides has its friction against its
velocity, what is open has no impulse. With the dynamics they give velocities and impulses as functions of
the state, by the implicit function theorem. How inertia, forces, rows and gaps change with it is taken from
central differences of MuJoCo's own evaluation, which has no derivative of them; no step is solved twice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact import CONE_ROWS, DRY_ROW, HELD_ROW
from surefoot.worlds.mujoco.stepper.instant import Evaluation, Instant

DIFFERENCE = 1e-6
"""Step of the central differences of MuJoCo's evaluation [m, rad, m/s]: errors of 1e-10."""
NEAR = 1e-7
"""Share of the largest impulse, and of the largest speed, below which one is none [-]: a kink's width."""
CLOSED = 1e-9
"""Gap up to which a contact is closed [m, rad], and around zero the width of a kink."""
RANK = 1e-11
"""Singular values over the largest below which rows are redundant [-]."""


@dataclass(frozen=True)
class MujocoDerivative:
    """Derivatives of the state after a step.

    States are (nv,) positions (in the tangent space, as MuJoCo's mj_differentiatePos has them), (nv,)
    velocities and (na,) activations, behind each other; as of ``mujoco.mjd_transitionFD``.

    Attributes
    ----------
    A, B
        (2 nv + na, 2 nv + na) by the state before, (2 nv + na, nu) by the controls.
    friction
        (2 nv + na,) by a common factor of all friction coefficients of contacts.
    kinks
        Blocks between two modes: there the derivative is one-sided, that of bodies which stay in contact, and
        of contacts which stick where they might slide.
    """

    A: FloatArray
    B: FloatArray
    friction: FloatArray
    kinks: int


@dataclass
class _Solution:
    """A step's velocities (nv,), impulses and modes of its rows (m,), and the push of its positions."""

    v: FloatArray
    x: FloatArray
    still: BoolArray
    closed: BoolArray
    sliding: list[int]
    kinks: int
    push: FloatArray
    pushed: list[int]
    pressed: FloatArray


def differentiate(evaluation: Evaluation) -> MujocoDerivative:
    """Return the derivatives of a step; see `MujocoStepper.derivative`."""
    base = evaluation.at()
    found = _solve(evaluation, base)
    system, columns = _active_matrix(base, found), []
    inverse = np.asarray(np.linalg.pinv(system, rcond=RANK), dtype=np.float64)
    for part, size in enumerate(evaluation.sizes):
        for i in range(size):
            columns.append(_column(evaluation, base, found, inverse, part, i))
    rate = np.zeros(len(system))
    for k in found.sliding:
        at, dim = base.table[k, 2], base.table[k, 1]
        rate[len(found.v) + at + 1 : len(found.v) + at + dim] = -found.x[at + 1 : at + dim]
    # a factor of all coefficients changes no row and no force, only how far friction goes
    columns.append(_after(evaluation, [base, base], found, -inverse @ rate, (-1, 0), (1.0, -1.0)))
    out, n = np.array(columns).T, len(columns[0])
    nu = evaluation.sizes[3]
    return MujocoDerivative(out[:, :n], out[:, n : n + nu], out[:, -1], found.kinks)


def _column(
    evaluation: Evaluation, base: Instant, found: _Solution, inverse: FloatArray, part: int, i: int
) -> FloatArray:
    """Return the derivative by one entry of positions, velocities, activations or controls."""
    instants, signs = [], []
    for sign in (1.0, -1.0):
        now = evaluation.at(part, i, sign * DIFFERENCE)
        same = np.array_equal(now.keys, base.keys) and np.array_equal(now.table, base.table)
        instants.append(now if same else base)
        signs.append(sign if same else 0.0)
    if signs[0] == signs[1]:
        raise ProblemError("contacts come and go on both sides of this state: its step has no derivative")
    width = DIFFERENCE * (signs[0] - signs[1])
    both = [_residual(now, found, evaluation.start_velocity(part, i, sign * DIFFERENCE))
            for now, sign in zip(instants, signs, strict=True)]  # fmt: skip
    moved = -inverse @ ((both[0] - both[1]) / width)
    return _after(evaluation, instants, found, moved, (part, i), (signs[0], signs[1]))


def _solve(evaluation: Evaluation, base: Instant) -> _Solution:
    """Return the step's solution, and what each row does."""
    x, push = evaluation.impulses(base)
    v = evaluation.start_velocity() + np.linalg.solve(base.M, base.impulse + base.J.T @ x)
    u = base.J @ v + base.b
    small_x = NEAR * max(np.abs(x).max(initial=0.0), 1e-12)
    small_u = NEAR * max(np.abs(base.J @ evaluation.start_velocity()).max(initial=0.0), 1e-3)
    still, sliding, kinks = np.zeros(len(x), bool), [], 0
    for k, (kind, dim, at, _) in enumerate(base.table):
        mu, limit = base.numbers[k, :2]
        if kind == HELD_ROW:
            still[at] = True
        elif kind == DRY_ROW:
            still[at] = abs(x[at]) < limit * (1.0 - NEAR)
            kinks += bool(not still[at] and abs(u[at]) < small_u)
        elif x[at] <= small_x:
            kinks += bool(u[at] < small_u)
        else:
            still[at] = True
            kinks += bool(abs(base.gap[at]) < CLOSED)
            speed, friction = (np.linalg.norm(part[at + 1 : at + dim]) for part in (u, x))
            if kind == CONE_ROWS and speed > small_u:
                sliding.append(k)
            elif kind == CONE_ROWS:
                still[at + 1 : at + dim] = True
                kinks += bool(friction > mu * x[at] * (1.0 - NEAR))
    found = _Solution(v, x, still, base.gap <= CLOSED, sliding, kinks, push, [], np.zeros(0))
    _find_pushed(evaluation, base, found)
    return found


def _find_pushed(evaluation: Evaluation, base: Instant, found: _Solution) -> None:
    """Find the rows that the push of positions keeps, and the impulses that do so."""
    left = base.J @ found.push + _violations(evaluation, base, found, found.v)
    near = CLOSED / evaluation.h
    for kind, _, at, _ in base.table:
        if kind != DRY_ROW and abs(left[at]) < near and (found.push.any() or found.still[at]):
            found.pushed.append(int(at))
    rows = base.J[found.pushed]
    if len(rows):
        pressed = np.linalg.lstsq(rows.T, base.M @ found.push, rcond=RANK)[0]
        found.pressed = np.asarray(pressed, dtype=np.float64)


def _violations(evaluation: Evaluation, now: Instant, found: _Solution, v: FloatArray) -> FloatArray:
    """Return what the push has to undo, row by row (m,) [m/s]."""
    out, u = now.gap.copy(), now.J @ v
    for kind, _, at, _ in now.table:
        if kind not in (HELD_ROW, DRY_ROW) and not found.still[at]:
            out[at] += evaluation.h * max(u[at], 0.0)
        undone = kind == HELD_ROW or found.closed[at]
        out[at] *= (evaluation.share if undone else 1.0) / evaluation.h
    return out


def _active_matrix(base: Instant, found: _Solution) -> FloatArray:
    """Return the derivative (nv + m, nv + m) of `_residual` by velocities and impulses."""
    n, m = len(found.v), len(found.x)
    out = np.zeros((n + m, n + m))
    out[:n, :n], out[:n, n:] = base.M, -base.J.T
    for i in range(m):
        if found.still[i]:
            out[n + i, :n] = base.J[i]
        else:
            out[n + i, n + i] = 1.0
    for k in found.sliding:
        at, dim, mu = base.table[k, 2], base.table[k, 1], base.numbers[k, 0]
        rows = slice(at + 1, at + dim)
        u = base.J[rows] @ found.v + base.b[rows]
        speed = np.linalg.norm(u)
        e = u / speed
        out[n + at + 1 : n + at + dim, n + at] = mu * e
        turn = mu * found.x[at] / speed * (np.eye(dim - 1) - np.outer(e, e))
        out[n + at + 1 : n + at + dim, :n] = turn @ base.J[rows]
    return out


def _residual(now: Instant, found: _Solution, start: FloatArray) -> FloatArray:
    """Return the dynamics' and the modes' equations (nv + m,) at an instant, for the solution as it is."""
    n, b = len(found.v), now.b.copy()
    for kind, _, at, _ in now.table:
        if kind not in (HELD_ROW, DRY_ROW) and found.closed[at]:
            b[at] -= max(now.gap[at], 0.0) / now.h
    u = now.J @ found.v + b
    out = np.zeros(n + len(u))
    out[:n] = now.M @ (found.v - start) - now.impulse - now.J.T @ found.x
    out[n:] = np.where(found.still, u, found.x)
    for k in found.sliding:
        at, dim, mu = now.table[k, 2], now.table[k, 1], now.numbers[k, 0]
        slip = u[at + 1 : at + dim]
        out[n + at + 1 : n + at + dim] += mu * found.x[at] * slip / np.linalg.norm(slip)
    return out


def _after(
    evaluation: Evaluation, instants: list[Instant], found: _Solution, moved: FloatArray,
    entry: tuple[int, int], signs: tuple[float, float],
) -> FloatArray:  # fmt: skip
    """Return the derivative of the state after the step, where velocities and impulses move as `moved`."""
    n, width = len(found.v), DIFFERENCE * (signs[0] - signs[1])
    dv, rows = moved[:n], found.pushed
    speeds = [found.v + sign * DIFFERENCE * dv for sign in signs]
    push = np.zeros(n)
    if rows:
        both = [
            np.concatenate([
                now.M @ found.push - now.J[rows].T @ found.pressed,
                (now.J @ found.push + _violations(evaluation, now, found, v))[rows],
            ])
            for now, v in zip(instants, speeds, strict=True)
        ]  # fmt: skip
        J = instants[0].J[rows]
        system = np.block([[instants[0].M, -J.T], [J, np.zeros((len(rows), len(rows)))]])
        push = -(np.linalg.pinv(system, rcond=RANK) @ (both[0] - both[1]))[:n] / width
    places = [
        evaluation.place_after(*entry, sign * DIFFERENCE, v, found.push + sign * DIFFERENCE * push)
        for sign, v in zip(signs, speeds, strict=True)
    ]
    acts = (instants[0].act - instants[1].act) / width
    return np.concatenate([evaluation.between(*places) / width, dv, acts])
