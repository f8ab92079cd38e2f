"""Batches of contact problems in a framework's own arrays: solved, certified and differentiated.

Newton's method on the central path (`batch.path`), followed to its end or, with `smoothing`, to a point on
it; where a fast descent fails, slower ones follow. Gradients are those of the active system, or of the path's
point (`contact.batch.modes`). `xp` is a `Framework`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.base.errors import ProblemError
from surefoot.contact.batch.answers import ALMOST, INVALID, SOLVED, STALLED, Forces, check_law
from surefoot.contact.batch.certificate import lawful, scales
from surefoot.contact.batch.frameworks import Framework
from surefoot.contact.batch.modes import active, certified, finite, gradients, snapped
from surefoot.contact.batch.path import ScaledBatch, jacobian, misses, path_gradients, path_of, velocity
from surefoot.contact.solvers.solver import ALMOST_FACTOR

FACTORS, JUMPS, LIMITS, SHARES = (0.05, 0.3, 0.6), (1e-3, 0.0, 0.0), (12, 40, 100), (1e-3, 1e-3, 1e-2)
"""Descents, tried one after another: the factor of sqrt(κ) in a step, the κ from which the next step goes to
the end, at most so many steps, and the proximal term in units of sqrt(κ)."""
LENGTHS = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Lengths tried in a step's line search."""
ARMIJO = 0.1
"""Share of the promised fall of ||F|| that a length has to keep."""
ENOUGH = 1e-12, 2e-6
"""Error of the scaled equations at which a problem is left, in double and in single precision."""
PROXIMAL = 1e-9, 3e-6
"""The least proximal term: redundant contacts leave the path's end singular."""
TOLERANCE = 1e-8, 1e-4
"""Velocity error that counts as solved, in double and in single precision."""


class BatchRequest(NamedTuple):
    """What is asked of a batch: the law, the smoothing [W], the tolerance, and whether the CPU solves it."""

    convex: bool
    smoothing: float
    tol: float
    on_host: bool


class Descent(NamedTuple):
    """Where a batch is on its way down: y and the best y (..., 3n), κ, the best's error, stage and steps."""

    y: Any
    kappa: Any
    best: Any
    error: Any
    stage: Any
    count: Any


def single_precision(xp: Framework, array: Any) -> bool:
    """Return whether an array is of single precision."""
    return float(xp.finfo(array.dtype).eps) > 1e-12


def request(
    xp: Framework, like: Any, law: str, smoothing: float, tol: float | None, on_host: bool
) -> BatchRequest:
    """Return what is asked of arrays of a precision, with its tolerance where none is named.

    Raises
    ------
    ProblemError
        If there is no such law, or the smoothing is negative or not finite.
    """
    if not 0.0 <= float(smoothing) < float("inf"):
        raise ProblemError(f"smoothing must be >= 0 and finite, got {smoothing}")
    wanted = TOLERANCE[single_precision(xp, like)] if tol is None else float(tol)
    return BatchRequest(check_law(law), float(smoothing), wanted, on_host and smoothing == 0.0)


def answer(xp: Framework, asked: BatchRequest, G: Any, g: Any, mu: Any, on: Any) -> tuple[Forces, Any]:
    """Return the answer of a batch, any entries, and the path's y (..., 3n), g where there is no path.

    G is (..., 3n, 3n), g (..., 3n), mu and on (..., n).
    """
    G, g, mu, good = lawful(xp, G, g, mu)
    s = scales(xp, G, g, on)
    if asked.on_host:
        forces = xp.ask_host(asked.convex, asked.tol, G, g, mu, on)
        return certified(xp, G, g, mu, on, s, forces, good, asked.convex, asked.tol), g
    path = path_of(xp, G, g, mu, on, s, asked.convex)
    y, error = descend(xp, path, asked.smoothing / path.unit)
    forces = xp.reshape(path.turn * y, (*on.shape, 3))
    forces = xp.where(on[..., None], forces, 0.0)
    if asked.smoothing == 0.0:
        forces = snapped(xp, G, g, mu, on, s, forces, asked.convex)
    kept = good & xp.isfinite(forces).all(-1).all(-1)  # the path of what is no problem is that of zeros
    forces = xp.where(kept[..., None, None], forces, 0.0)
    out = certified(xp, G, g, mu, on, s, forces, good, asked.convex, asked.tol)
    if asked.smoothing > 0.0:
        # a point on the path is judged by the path's own equations
        near = xp.where(error <= ALMOST_FACTOR * asked.tol, ALMOST, STALLED)
        status = xp.where(good, xp.where(error <= asked.tol, SOLVED, near), INVALID)
        out = out._replace(status=xp.integers(status), residual=xp.where(good, error, xp.inf))
    return out, y


def pull_back(
    xp: Framework,
    asked: BatchRequest,
    given: tuple[Any, ...],
    point: tuple[Any, ...],
    weights: tuple[Any, Any],
) -> tuple[Any, ...]:
    """Return the gradients in G, g and mu of weights on the forces and velocities of an answer.

    `given` is what `answer` was given, the point its forces, velocities (..., n, 3) and y.
    """
    G, g, mu, on = given
    G, g, mu, good = lawful(xp, G, g, mu)
    s = scales(xp, G, g, on)
    forces, velocities, y = point
    if asked.smoothing > 0.0:
        path = path_of(xp, G, g, mu, on, s, asked.convex)
        kappa = asked.smoothing / path.unit
        found = path_gradients(xp, path, y, kappa, G, g, mu, (forces, velocities), weights)
    else:
        modes = active(xp, forces, velocities, mu, s.weight, s.speed, on, asked.convex)
        found = gradients(xp, G, forces, modes, weights)
    return finite(xp, found, good)


def descend(xp: Framework, path: ScaledBatch, target: Any) -> tuple[Any, Any]:
    """Follow the path down to κ = target (...,); return the best y (..., 3n) and its error (...,)."""
    single = single_precision(xp, path.g)
    enough, least = ENOUGH[single], PROXIMAL[single]
    # κ never quite zero: there F's Jacobian may be singular at a kink
    floor = xp.clip(target, enough**2)
    none = xp.zeros_like(path.tilt)
    start = xp.reshape(xp.stack([none, none, none + 1.0], -1), path.g.shape)

    def unfinished(at: Descent) -> Any:
        return ((at.error > enough) & (at.stage < len(FACTORS))).any()

    def step(at: Descent) -> Descent:
        # problems that are done stay where they are: a batch runs until its last one is
        busy = (at.error > enough) & (at.stage < len(FACTORS))
        root = xp.sqrt(at.kappa)
        proximal = xp.clip(_of_stage(xp, at.stage, SHARES, root) * root, least)
        # a proximal term that goes with sqrt(κ), the scale of u and λ at a kink
        move, t, reached = _newton_step(xp, path, at.y, at.kappa, proximal)
        y = xp.where(busy[..., None], at.y + t[..., None] * move, at.y)
        # once near the path at this κ, the next one: faster after a whole step, at once from a small κ
        factor, jump = (_of_stage(xp, at.stage, table, root) for table in (FACTORS, JUMPS))
        lower = at.kappa * xp.where(t == 1.0, factor * factor, factor)
        lower = xp.where(lower < jump, floor, xp.maximum(lower, floor))
        kappa = xp.where(busy & (reached <= root), lower, at.kappa)
        now = _size(xp, misses(xp, path, y, velocity(path, y), target))
        better = busy & (now < at.error)
        best, error = xp.where(better[..., None], y, at.best), xp.where(better, now, at.error)
        # out of steps: the next, slower descent, from the start
        count = at.count + 1
        fresh = busy & (error > enough) & (count >= _of_stage(xp, at.stage, LIMITS, at.count))
        y = xp.where(fresh[..., None], start, y)
        kappa = xp.where(fresh, xp.clip(target, 1.0), kappa)
        return Descent(
            y, kappa, best, error, xp.where(fresh, at.stage + 1, at.stage), xp.where(fresh, 0, count)
        )

    whole = xp.integers(xp.zeros_like(target))
    error = _size(xp, misses(xp, path, start, velocity(path, start), target))
    found = xp.loop(unfinished, step, Descent(start, xp.clip(target, 1.0), start, error, whole, whole))
    return found.best, found.error


def _newton_step(xp: Framework, path: ScaledBatch, y: Any, kappa: Any, proximal: Any) -> tuple[Any, Any, Any]:
    """Return the Newton step (..., 3n) from y, the length that a line search gives it, and ||F|| there."""
    u = velocity(path, y)
    F = misses(xp, path, y, u, kappa)
    M, _ = jacobian(xp, path, y, u, kappa)
    M = M + proximal[..., None, None] * xp.eye(y.shape[-1], M)
    move = -xp.solve(M, F[..., None])[..., 0]
    # a singular matrix gives no numbers: that problem stands still, and the next descent may have it
    move = xp.where(xp.isfinite(move).all(-1)[..., None], move, 0.0)
    # u is linear in y: all lengths are tried with two products
    turn, before = velocity(path, move) - path.g, _size(xp, F)
    lengths = xp.stack([xp.full_like(before, t) for t in LENGTHS])
    t = lengths[..., None]
    after = _size(xp, misses(xp, path, y + t * move, u + t * turn, kappa))
    # the longest that keeps enough of the promised fall, or else the best of them
    fine = after <= (1.0 - ARMIJO * lengths) * before
    pick = xp.where(fine.any(0), xp.argmax(xp.integers(fine), 0), xp.argmin(after, 0))
    length, reached = lengths[0], after[0]
    for k in range(1, len(LENGTHS)):
        length, reached = (xp.where(pick == k, v[k], w) for v, w in ((lengths, length), (after, reached)))
    return move, length, reached


def _size(xp: Framework, F: Any) -> Any:
    return xp.sqrt((F * F).sum(-1))


def _of_stage(xp: Framework, stage: Any, table: tuple[float, ...], like: Any) -> Any:
    """Return a table's entry for every problem's stage, its last after the end, in an array like another."""
    out = xp.full_like(like, table[-1])
    for k, value in enumerate(table[:-1]):
        out = xp.where(stage == k, value, out)
    return out
