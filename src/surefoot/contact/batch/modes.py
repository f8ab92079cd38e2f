"""The gradient of solved contact problems, batched, in a framework's arrays (`xp`, a `Framework`).

The active system of `surefoot.contact.derivative.active_system`, with three places for the unknowns of every
contact, used or not, so that every problem of a batch has the same shape::

    λ' = C y + j,    u' = G λ' + b,    R u' + W y = t    →    A y = t - R (b + G j),   A = R G C + W

Unused places have a one on the diagonal and nothing else. Where redundant contacts make A singular its
pseudo-inverse stands for the inverse: single forces then have the derivatives of least norm.

Source: implicit function theorem; P. Alart, A. Curnier, CMAME 92, 1991 (the modes).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.contact.batch.answers import INVALID, KINK, OFF, OPEN, SLIDE, STICK, Forces
from surefoot.contact.batch.certificate import Scales, judge, velocities_of

RANK = 1e-12
"""Singular values below this share of the largest are zero, in double precision; 1e-5 in single."""
UNLOADED = 1e-9
"""A sliding contact holds its velocity's direction by its load: below this ratio it does not."""


class Active(NamedTuple):
    """The modes of a batch: codes (..., n), and what they make of the active system.

    Attributes
    ----------
    codes, kinks
        (..., n), see `Forces`.
    columns, rows
        (..., n, 3, 3): unknown c moves the force along columns[..., c]; its equation is rows[..., c, :] . u'.
    weight, used
        (..., n, 3): the diagonal W, and which places are used.
    slope
        (..., n, 3) how the force moves with mu.
    target
        (..., n, 3) how the right-hand side moves with mu.
    """

    codes: Any
    kinks: Any
    columns: Any
    rows: Any
    weight: Any
    used: Any
    slope: Any
    target: Any


def rank_tolerance(xp: Any, dtype: Any) -> float:
    """Return `RANK` for a dtype."""
    return RANK if float(xp.finfo(dtype).eps) < 1e-12 else 1e-5


def _stack(xp: Any, rows: list[list[Any]]) -> Any:
    """Return (..., r, c) of r rows of c arrays each."""
    return xp.stack([xp.stack(row, -1) for row in rows], -2)


def active(
    xp: Any, forces: Any, velocities: Any, mu: Any, weight: Any, speed: Any, on: Any, convex: bool
) -> Active:
    """Return the modes at forces and velocities (..., n, 3), from the piece of the natural map they are on.

    `weight` and `speed` (..., n) are w_k and s_k of `contact.problem.scales`.
    """
    x, y, z = (forces[..., a] for a in range(3))
    p, q, r = (velocities[..., a] for a in range(3))
    one, zero = xp.ones_like(z), xp.zeros_like(z)
    w = xp.where(weight > 0.0, weight, one)
    slip = xp.hypot(p, q)
    # w times the natural map's point λ - u / w: velocities, so that no division by a small w
    lifted = w * z - (r - mu * slip if convex else r)
    closed = (lifted > 0.0) & on
    radius = w * mu * xp.clip(z, 0.0)
    across, along = w * x - p, w * y - q
    size = xp.hypot(across, along)
    stick = closed & (size <= radius) & (radius > 0.0)
    slide = closed & ~stick
    safe = xp.where(size > 0.0, size, one)
    ex, ey = xp.where(size > 0.0, across / safe, one), along / safe
    ratio = xp.where(size > 0.0, radius / safe, zero)
    codes = xp.where(~on, OFF, xp.where(stick, STICK, xp.where(slide, SLIDE, OPEN)))
    # kinks: near the bound of the normal force, or near the rim of the disc
    rim = xp.where(closed, abs(size - radius), xp.full_like(size, xp.inf))
    near = xp.minimum(abs(lifted), xp.where(mu > 0.0, rim, xp.full_like(size, xp.inf)))
    kinks = on & (near <= KINK * speed)
    # masks as numbers: every contact has three places, and a mode decides which of them say something
    s, t = stick * one, slide * one
    flat = t * (1.0 if convex else 0.0)
    columns = _stack(xp, [[s, -t * ey, t * mu * ex], [zero, s + t * ex, t * mu * ey], [zero, zero, s + t]])
    rows = _stack(
        xp,
        [
            [s, zero, zero],
            [-t * ratio * ey, s + t * ratio * ex, zero],
            [flat * mu * ex, flat * mu * ey, s + t],
        ],
    )
    used = xp.stack([s, s + t, s + t], -1)
    diagonal = xp.stack([zero, t * (1.0 - ratio) * w, zero], -1)
    slope = xp.stack([t * z * ex, t * z * ey, zero], -1)
    target = xp.stack([zero, zero, -flat * (p * ex + q * ey)], -1)
    return Active(codes, kinks, columns, rows, diagonal, used > 0.0, slope, target)


def matrix(xp: Any, G: Any, a: Active) -> tuple[Any, Any, Any]:
    """Return A and the block-diagonal C and R, all (..., 3n, 3n); unused places have a diagonal like G's."""
    C, R = spread(xp, a.columns), spread(xp, a.rows)
    size = G.shape[-1]
    flat = (*G.shape[:-2], size)
    level = xp.einsum("...ii->...", G)[..., None] / size
    level = xp.where(level > 0.0, level, xp.ones_like(level))
    used = xp.reshape(a.used, flat)
    diagonal = xp.where(used, xp.reshape(a.weight, flat), level + xp.zeros_like(C[..., 0]))
    return R @ G @ C + diagonal[..., None] * xp.eye(size, G), C, R


def spread(xp: Any, blocks: Any) -> Any:
    """Return the (..., 3n, 3n) block-diagonal matrix of (..., n, 3, 3) blocks."""
    n = blocks.shape[-3]
    eye = xp.eye(n, blocks)
    wide = xp.swapaxes(blocks[..., None, :, :] * eye[:, :, None, None], -3, -2)
    return xp.reshape(wide, (*blocks.shape[:-3], 3 * n, 3 * n))


def gradients(xp: Any, G: Any, forces: Any, a: Active, cotangents: tuple[Any, Any]) -> tuple[Any, Any, Any]:
    """Return the gradients with respect to G, g, mu (one per contact) of weights on forces and velocities.

    As `ContactDerivative.vjp`; the weights and forces are (..., n, 3).
    """
    A, C, R = matrix(xp, G, a)
    flat = (*G.shape[:-2], G.shape[-1])
    f, u, x, slope, target = (
        xp.reshape(v, flat)[..., None] for v in (*cotangents, forces, a.slope, a.target)
    )
    # a matrix that overflowed has no singular values: NaN, which `finite` makes zero
    lost = ~xp.isfinite(A).all(-1).all(-1)
    left, values, right = xp.linalg.svd(xp.where(lost[..., None, None], 0.0, A))
    values = xp.where(lost[..., None], xp.nan, values)
    # the pseudo-inverse: redundant contacts' singular values are rounding
    keep = values > rank_tolerance(xp, G.dtype) * values[..., :1]
    inverse = xp.where(keep, 1.0 / xp.where(keep, values, 1.0), 0.0 * values)
    size = (R * R).sum(-1)[..., None]
    held = size > UNLOADED**2
    lift = xp.where(held, R / xp.where(held, size, xp.ones_like(size)), 0.0)
    p = f + G @ u
    q = left @ (inverse[..., None] * (right @ (xp.swapaxes(C, -1, -2) @ p)))
    # as `vjp_within`: what the singular A does not reach is left to the velocities
    over = xp.swapaxes(left, -1, -2) @ (lift @ u)
    q = q + left @ xp.where(keep[..., None], xp.zeros_like(over), over)  # velocities of what A cannot reach
    back = xp.swapaxes(R, -1, -2) @ q
    b, jump = u - back, p - G @ back
    mu = xp.reshape((slope * jump + target * q)[..., 0], forces.shape).sum(-1)
    outer = b * xp.swapaxes(x, -1, -2)
    return 0.5 * (outer + xp.swapaxes(outer, -1, -2)), b[..., 0], mu


def finite(xp: Any, found: tuple[Any, ...], good: Any) -> tuple[Any, ...]:
    """Return gradients with zeros at problems that are none, or where one is not finite."""
    whole = good
    for part in found:
        whole = whole & xp.isfinite(xp.reshape(part, (*good.shape, -1))).all(-1)
    return tuple(xp.where(xp.reshape(whole, good.shape + (1,) * (p.ndim - good.ndim)), p, 0.0) for p in found)


def certified(
    xp: Any, G: Any, g: Any, mu: Any, on: Any, s: Scales, forces: Any, good: Any, convex: bool, tol: float
) -> Forces:
    """Return forces (..., n, 3) with their velocities, status, residual and modes."""
    velocities = velocities_of(xp, G, g, forces)
    status, error = judge(xp, G, forces, velocities, mu, s, on, convex, tol)
    modes = active(xp, forces, velocities, mu, s.weight, s.speed, on, convex)
    status = xp.integers(xp.where(good, status, INVALID))
    error = xp.where(good, error, xp.full_like(error, xp.inf))
    return Forces(forces, velocities, status, error, xp.integers(modes.codes), modes.kinks)


def snapped(xp: Any, G: Any, g: Any, mu: Any, on: Any, s: Scales, forces: Any, convex: bool) -> Any:
    """Return forces without what an iteration leaves: zero where open, on the rim where they slide."""
    modes = active(xp, forces, velocities_of(xp, G, g, forces), mu, s.weight, s.speed, on, convex)
    normal = xp.clip(forces[..., 2], 0.0)
    size = xp.hypot(forces[..., 0], forces[..., 1])
    share = mu * normal / xp.where(size > 0.0, size, xp.ones_like(size))
    # an iteration ends near the face: the mode it is in says which face, and the force is put onto it
    rim = xp.stack([forces[..., 0] * share, forces[..., 1] * share, normal], -1)
    codes = modes.codes[..., None]
    return xp.where(codes == STICK, forces, xp.where(codes == SLIDE, rim, 0.0))
