"""Newton's equations on the central path of a batch, in a framework's arrays (`xp`, a `Framework`).

In the unknowns y = (λ_t / mu, λ_n) and their slacks s = (mu u_t, u_n + mu ||u_t||) the friction cone is the
second-order cone, mu or not, and the laws are  y ∈ K,  s ∈ K,  y ∘ s = κ e  with κ = 0 (De Saxcé; the convex
law leaves mu ||u_t|| out). With the smoothed projection p_κ onto K that is one equation,

    F(y) = y - p_κ(y - s(y)) = 0,    p_κ(z) = (z + sqrt(z ∘ z + 4 κ e)) / 2

which has a regular Jacobian for every κ > 0. Contacts are scaled to blocks of G with trace 3, and the problem
to a free velocity of 1.

Source: M. Fukushima, Z.-Q. Luo, P. Tseng, "Smoothing functions for second-order-cone complementarity
problems", SIOPT 12(2), 2002; V. Acary et al., Optim. Methods Softw. 39(3), 2024 (the path for Coulomb's law).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.contact.batch.certificate import Scales, blocks_of, diagonal_of
from surefoot.contact.batch.modes import spread


class ScaledBatch(NamedTuple):
    """A batch in scaled unknowns.

    Attributes
    ----------
    G, g
        (..., 3n, 3n) and (..., 3n), zero at contacts that are off.
    on
        (..., n).
    turn
        (..., 3n) forces per y.
    unit
        (...,) the square of the free velocity that became 1; κ is divided by it.
    tilt
        (..., n) mu in units of velocity s, for the rounding of mu ||u_t||.
    scales
        Those of the problem as it was given.
    convex
        Whether the convex law.
    """

    G: Any
    g: Any
    on: Any
    turn: Any
    unit: Any
    tilt: Any
    scales: Scales
    convex: bool


def path_of(xp: Any, G: Any, g: Any, mu: Any, on: Any, s: Scales, convex: bool) -> ScaledBatch:
    """Return the scaled problem; mu and on are (..., n)."""
    flat = g.shape
    one = xp.ones_like(mu)
    T = xp.reshape(xp.stack([mu, mu, one], -1), flat)
    keep = xp.reshape(xp.stack([on, on, on], -1), flat)
    blocks = diagonal_of(xp, blocks_of(xp, G))
    # of the block in the unknowns y, where mu has gone from the cone into G
    trace = (mu**2 * (blocks[..., 0, 0] + blocks[..., 1, 1]) + blocks[..., 2, 2]) / 3.0
    D = 1.0 / xp.sqrt(xp.where(on & (trace > 0.0), trace, one))
    wide = xp.reshape(xp.stack([D, D, D], -1), flat)
    side = xp.where(keep, T * wide, 0.0)
    free = side * g
    top = xp.amax(abs(free), -1)
    top = xp.where(top > 0.0, top, 1.0)
    scaled = side[..., :, None] * G * side[..., None, :]
    # takes ||u_t|| to the slack's units, in which the largest free velocity is 1
    tilt = mu * D / top[..., None]
    return ScaledBatch(
        scaled, free / top[..., None], on, T * wide * top[..., None], top * top, tilt, s, convex
    )


def velocity(path: ScaledBatch, y: Any) -> Any:
    """Return the scaled velocities G y + g (..., 3n)."""
    return (path.G @ y[..., None])[..., 0] + path.g


def by_contact(xp: Any, flat: Any) -> Any:
    """Return (..., 3n) as (..., n, 3)."""
    return xp.reshape(flat, (*flat.shape[:-1], flat.shape[-1] // 3, 3))


def slacks(xp: Any, path: ScaledBatch, velocities: Any, kappa: Any) -> tuple[Any, Any, Any]:
    """Return s (..., n, 3), the slopes (..., n, 2) of the shift in u_t, and in its rounding (..., n)."""
    u = by_contact(xp, velocities)
    if path.convex:
        none = xp.zeros_like(u[..., :2])
        return u, none, none[..., 0]
    round_ = rounding(xp, path, kappa)
    x, z = u[..., 0], u[..., 1]
    speed = xp.sqrt(x * x + z * z + round_)
    # at rest with nothing to round by the shift has a kink: of its subgradients zero
    safe = xp.where(speed > 0.0, speed, xp.ones_like(speed))
    slope = xp.stack([x / safe, z / safe], -1)
    return xp.stack([x, z, u[..., 2] + speed], -1), slope, round_ / safe


def rounding(xp: Any, path: ScaledBatch, kappa: Any) -> Any:
    """Return what is added to mu² ||u_t||² under the root, in scaled units; ε as in `derivative_path`."""
    w, s = path.scales.weight, path.scales.speed
    power = (kappa * path.unit)[..., None] * w
    least = xp.where(s > 0.0, power / xp.where(s > 0.0, s, xp.ones_like(s)), xp.sqrt(power))
    return path.tilt**2 * xp.minimum(power, least * least)


def smoothed(xp: Any, z: Any, kappa: Any) -> tuple[Any, Any]:
    """Return p_κ(z) and its Jacobian, (..., n, 3) and (..., n, 3, 3), normal last.

    The tangential part is a multiple of z's, so nothing is divided by its length but the direction.
    """
    x, y, height = z[..., 0], z[..., 1], z[..., 2]
    radius = xp.sqrt(x * x + y * y)
    safe = xp.where(radius > 0.0, radius, xp.ones_like(radius))
    ex, ey = xp.where(radius > 0.0, x / safe, xp.ones_like(x)), y / safe
    # the cone's spectral values; p_κ acts on each by itself (Fukushima, Luo and Tseng 2002)
    high, low = height + radius, height - radius
    q, r = xp.sqrt(high * high + 4.0 * kappa), xp.sqrt(low * low + 4.0 * kappa)

    def part(value: Any, root: Any) -> Any:  # (value + root) / 2 without cancelling
        other = xp.where(value > 0.0, xp.ones_like(root), root - value)
        other = xp.where(other > 0.0, other, xp.ones_like(root))
        return xp.where(value > 0.0, 0.5 * (value + root), 2.0 * kappa / other)

    def slope(value: Any, root: Any) -> Any:
        return xp.where(root > 0.0, 0.5 * (1.0 + value / xp.where(root > 0.0, root, 1.0)), 0.0)

    a, b = slope(high, q), slope(low, r)
    # (p(high) - p(low)) / (2 radius), with the roots' difference rationalised
    across = slope(2.0 * height, q + r)
    mean, skew = 0.5 * (a + b), 0.5 * (a - b)
    value = xp.stack([across * x, across * y, 0.5 * (part(high, q) + part(low, r))], -1)
    turned = mean - across
    J = [
        [across + turned * ex * ex, turned * ex * ey, skew * ex],
        [turned * ex * ey, across + turned * ey * ey, skew * ey],
        [skew * ex, skew * ey, mean],
    ]
    return value, xp.stack([xp.stack(row, -1) for row in J], -2)


def misses(xp: Any, path: ScaledBatch, y: Any, velocities: Any, kappa: Any) -> Any:
    """Return F (..., 3n) at y and its `velocity`, y itself at contacts that are off."""
    point = by_contact(xp, y)
    s, _, _ = slacks(xp, path, velocities, kappa)
    p, _ = smoothed(xp, point - s, kappa[..., None])
    return xp.reshape(xp.where(path.on[..., None], point - p, point), y.shape)


def jacobian(xp: Any, path: ScaledBatch, y: Any, velocities: Any, kappa: Any) -> tuple[Any, Any]:
    """Return the Jacobian of F by y (..., 3n, 3n), 1 - J + J S G, and J, that of p_κ by contact."""
    s, tilt, _ = slacks(xp, path, velocities, kappa)
    _, J = smoothed(xp, by_contact(xp, y) - s, kappa[..., None])
    # contacts that are off keep F = y: their unknowns are solved to zero
    J = xp.where(path.on[..., None, None], J, 0.0)
    inner = xp.eye(3, J) - J
    return spread(xp, inner) + spread(xp, J @ _shift(xp, tilt)) @ path.G, J


def _shift(xp: Any, tilt: Any) -> Any:
    """Return ds/du (..., n, 3, 3)."""
    one, zero = xp.ones_like(tilt[..., 0]), xp.zeros_like(tilt[..., 0])
    rows = [[one, zero, zero], [zero, one, zero], [tilt[..., 0], tilt[..., 1], one]]
    return xp.stack([xp.stack(row, -1) for row in rows], -2)


def path_gradients(
    xp: Any,
    path: ScaledBatch,
    y: Any,
    kappa: Any,
    G: Any,
    g: Any,
    mu: Any,
    point: tuple[Any, Any],
    weights: tuple[Any, Any],
) -> tuple[Any, Any, Any]:
    """Return the gradients in G, g, mu of weights (..., n, 3) on the path's forces and velocities."""
    flat, shape = path.g.shape, weights[0].shape
    forces, velocities = point
    f, u = (xp.reshape(v, flat) for v in weights)
    p = f + (G @ u[..., None])[..., 0]
    at = velocity(path, y)
    M, J = jacobian(xp, path, y, at, kappa)
    # the adjoint of F(y) = 0: Mᵀ v = (dλ/dy)ᵀ p, then through p_κ to the slacks
    v = xp.solve(xp.swapaxes(M, -1, -2), (path.turn * p)[..., None])
    h = (xp.swapaxes(J, -1, -2) @ xp.reshape(v, (*shape, 1)))[..., 0]
    _, tilt, bend = slacks(xp, path, at, kappa)
    lean = xp.stack(
        [h[..., 0] + h[..., 2] * tilt[..., 0], h[..., 1] + h[..., 2] * tilt[..., 1], h[..., 2]], -1
    )
    safe = xp.where(mu > 0.0, mu, xp.ones_like(mu))
    per_mu = xp.reshape(path.turn, shape) / path.unit[..., None, None]  # s needs T D / top
    back = -xp.reshape(per_mu * lean, flat)  # on u, as g
    bare = per_mu[..., 2:] * lean[..., :2]  # without T
    # ε moves with w and s, hence with G and g; `contact.derivative.central_path` holds it
    bent = -0.5 * h[..., 2] * bend
    on_G, on_g = _of_rounding(xp, path, kappa, G, g, bent)
    b = u + back
    jump = xp.reshape(p + (G @ back[..., None])[..., 0], shape)
    plain = xp.reshape(path.turn, shape)[..., 2:] * xp.reshape(y, shape)[..., :2]  # λ_t / mu
    rate = (jump[..., :2] * plain - bare * velocities[..., :2]).sum(-1) - h[..., 2] * bend / safe
    x = xp.reshape(forces, flat)
    outer = b[..., :, None] * x[..., None, :]
    return 0.5 * (outer + xp.swapaxes(outer, -1, -2)) + on_G, b + on_g, xp.where(path.on, rate, 0.0)


def _of_rounding(xp: Any, path: ScaledBatch, kappa: Any, G: Any, g: Any, weights: Any) -> tuple[Any, Any]:
    """Return the gradients in G and g of weights (..., n) on log ε², which depends on w_k and s_k."""
    w, s = path.scales.weight, path.scales.speed
    fast = (s > 0.0) & ((kappa * path.unit)[..., None] * w < s * s)  # ε = κ w / s, else its root
    safe = xp.where(w > 0.0, w, xp.ones_like(w))
    per_w = xp.where(fast, 2.0, 1.0) * weights / safe
    blocks = diagonal_of(xp, blocks_of(xp, G))
    # dw/dG = a aᵀ, the block's largest eigenvector
    axis = xp.linalg.eigh(blocks)[1][..., -1]
    on_G = spread(xp, per_w[..., None, None] * axis[..., :, None] * axis[..., None, :])
    free = xp.reshape(g, (*w.shape, 3))
    size = xp.sqrt((free * free).sum(-1))
    same = (abs(size[..., None, :] - s[..., :, None]) <= 1e-12 * s[..., :, None]) & path.on[..., None, :]
    # s_k is a maximum: its gradient goes to whose speed it is, in equal shares on a tie
    share = xp.where(same, 1.0, 0.0 * s[..., None])  # whose velocity s_k is
    share = share / xp.clip(share.sum(-1), 1.0)[..., None]
    per_s = (xp.where(fast, -2.0, 0.0) * weights)[..., :, None] * share
    square = xp.where(size > 0.0, size * size, xp.ones_like(size))
    on_g = (per_s.sum(-2) / square)[..., None] * free
    return on_G, xp.reshape(on_g, g.shape)
