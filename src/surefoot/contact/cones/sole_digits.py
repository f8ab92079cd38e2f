"""The least normal force of a wrench in twice a double's digits, where rounding stops `sole_bounds.need`.

A velocity that no corner resists by more than a newton follows the logarithmic barrier of the corners' cones;
the barrier's gradient is the corners' forces, 2 k / t above the velocity's bound (S. Boyd, L. Vandenberghe,
"Convex Optimization", section 11.6). Damped Newton steps on a self-concordant barrier cannot stall, and its
systems, of condition 1e26 at the end, are solved with 32 digits.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.twofold import Twofold, minus, over, plus, times
from surefoot.contact.cones.sole_kernels import RADIUS, normalise, proofs_of
from surefoot.contact.cones.sole_program import LX, LY, QX, QY, lacking

FINAL = 1e-13
"""Gap at which the path ends [-], as a share of the wrench: rounding of the wrench's own numbers."""
FASTER = 200.0
"""Growth of the barrier's weight from one centre to the next [-]: a quarter less time than with 20."""
CENTRED = 1e-14
"""Newton decrement squared at which one more step finds the centre [-]: it squares it, to 1e-28."""
FULL = 0.05
"""Newton decrement squared below which full steps converge quadratically [-]."""
MOST_STEPS = 200
"""Newton steps at most for one centre [-]: 4 to 15 are usual."""

Corner = tuple[Twofold, Twofold, Twofold, Twofold, Twofold]


@inline_kernel
def _read(y: FloatArray, j: int) -> Twofold:
    return y[j, 0], y[j, 1]


@inline_kernel
def _one(a: float) -> Twofold:
    return a, 0.0


@inline_kernel
def _corner(table: FloatArray, i: int, radius: float, y: FloatArray) -> Corner:
    """Return what a corner sees of a velocity, (n, a, b, c), and n² - a² - b² - c²."""
    q_x, q_y, spin = _one(table[i, QX]), _one(table[i, QY]), _read(y, 4)
    n = plus(times(_one(table[i, LX]), _read(y, 2)), times(_one(table[i, LY]), _read(y, 3)))
    n = plus(n, (1.0, 0.0))
    a = minus(_read(y, 0), times(q_y, spin))
    b = plus(_read(y, 1), times(q_x, spin))
    c = times(_one(radius), spin)
    side = plus(plus(times(a, a), times(b, b)), times(c, c))
    return n, a, b, c, minus(times(n, n), side)


@inline_kernel
def _add(H: FloatArray, i: int, j: int, value: Twofold) -> None:
    H[i, j, 0], H[i, j, 1] = plus((H[i, j, 0], H[i, j, 1]), value)


@inline_kernel
def _system(
    table: FloatArray, radius: float, W: FloatArray, t: float, y: FloatArray, H: FloatArray, g: FloatArray
) -> None:
    """Set H (5, 5, 2), lower triangle, and g (5, 2) to Hessian and minus gradient of t W.y - sum log det."""
    for i in range(5):
        g[i, 0], g[i, 1] = times(_one(-t), _one(W[i]))
        for j in range(i + 1):
            H[i, j, 0], H[i, j, 1] = 0.0, 0.0
    u = np.empty((5, 2))
    for i in range(table.shape[0]):
        q_x, q_y, l_x, l_y = table[i, QX], table[i, QY], table[i, LX], table[i, LY]
        n, a, b, c, det = _corner(table, i, radius, y)
        f = over((2.0, 0.0), det)
        u[0, 0], u[0, 1] = times(f, (-a[0], -a[1]))
        u[1, 0], u[1, 1] = times(f, (-b[0], -b[1]))
        u[2, 0], u[2, 1] = times(f, times(_one(l_x), n))
        u[3, 0], u[3, 1] = times(f, times(_one(l_y), n))
        turn = minus(times(_one(q_y), a), times(_one(q_x), b))
        u[4, 0], u[4, 1] = times(f, minus(turn, times(_one(radius), c)))
        for m in range(5):
            g[m, 0], g[m, 1] = plus(_read(g, m), _read(u, m))
            for j in range(m + 1):
                _add(H, m, j, times(_read(u, m), _read(u, j)))
        # less 2 / det times the form of the cone
        _add(H, 0, 0, f)
        _add(H, 1, 1, f)
        _add(H, 2, 2, times(f, times(_one(-l_x), _one(l_x))))
        _add(H, 3, 2, times(f, times(_one(-l_x), _one(l_y))))
        _add(H, 3, 3, times(f, times(_one(-l_y), _one(l_y))))
        _add(H, 4, 0, times(f, _one(-q_y)))
        _add(H, 4, 1, times(f, _one(q_x)))
        square = plus(times(_one(q_x), _one(q_x)), times(_one(q_y), _one(q_y)))
        _add(H, 4, 4, times(f, plus(square, times(_one(radius), _one(radius)))))


@inline_kernel
def _solve(H: FloatArray, x: FloatArray) -> None:
    """Replace x (5, 2) by the solution of the system whose lower triangle H (5, 5, 2) is, by L D Lᵀ."""
    for j in range(5):
        for i in range(j, 5):
            value = (H[i, j, 0], H[i, j, 1])
            for m in range(j):
                part = times((H[i, m, 0], H[i, m, 1]), (H[j, m, 0], H[j, m, 1]))
                value = minus(value, times(part, (H[m, m, 0], H[m, m, 1])))
            if i > j:
                value = over(value, (H[j, j, 0], H[j, j, 1]))
            H[i, j, 0], H[i, j, 1] = value
    for i in range(5):
        for m in range(i):
            x[i, 0], x[i, 1] = minus(_read(x, i), times((H[i, m, 0], H[i, m, 1]), _read(x, m)))
    for i in range(5):
        x[i, 0], x[i, 1] = over(_read(x, i), (H[i, i, 0], H[i, i, 1]))
    for i in range(4, -1, -1):
        for m in range(i + 1, 5):
            x[i, 0], x[i, 1] = minus(_read(x, i), times((H[m, i, 0], H[m, i, 1]), _read(x, m)))


@inline_kernel
def _centre(
    table: FloatArray, radius: float, W: FloatArray, t: float, y: FloatArray, H: FloatArray, g: FloatArray,
    step: FloatArray,
) -> None:  # fmt: skip
    """Move y (5, 2) to the minimiser of t W.y - sum log det; g is left with minus the gradient."""
    for _ in range(MOST_STEPS):
        _system(table, radius, W, t, y, H, g)
        for j in range(5):
            step[j, 0], step[j, 1] = g[j, 0], g[j, 1]
        _solve(H, step)
        decrement = 0.0
        for j in range(5):
            decrement += g[j, 0] * step[j, 0]
        if not decrement > 0.0:  # "not" catches NaN: rounding
            return
        share = 1.0 / (1.0 + math.sqrt(decrement)) if decrement > FULL else 1.0
        for j in range(5):
            y[j, 0], y[j, 1] = plus(_read(y, j), times(_one(share), _read(step, j)))
        if decrement <= CENTRED:
            _system(table, radius, W, t, y, H, g)
            return


@inline_kernel
def _need(
    table: FloatArray, start: FloatArray, radius: float, W: FloatArray, v: FloatArray, forces: FloatArray
) -> tuple[float, float]:
    """Return bounds on the least total normal force for W[:5], W (6,) of norm one, from below and above.

    v (6,) is filled with the velocity that proves the first, forces (k, 4) with the corners' that are the
    second: normal, two tangential ones, and the pad's moment over its radius, as `sole_bounds.need` has them.
    """
    k = table.shape[0]
    y, H, g, step = np.zeros((5, 2)), np.empty((5, 5, 2)), np.empty((5, 2)), np.empty((5, 2))
    t = 10.0
    while True:
        _centre(table, radius, W, t, y, H, g, step)
        if 2.0 * k / t <= FINAL:
            break
        t *= FASTER
    low, total = (0.0, 0.0), (0.0, 0.0)
    for j in range(5):
        low = minus(low, times(_one(W[j]), _read(y, j)))
        v[j] = y[j, 0]
    v[5] = 1.0
    for i in range(k):
        n, a, b, c, det = _corner(table, i, radius, y)
        f = over((2.0, 0.0), times(_one(t), det))
        total = plus(total, times(f, n))
        forces[i, 0], forces[i, 1] = times(f, n)[0], -times(f, a)[0]
        forces[i, 2], forces[i, 3] = -times(f, b)[0], -times(f, c)[0]
    rest = np.empty(5)
    for j in range(5):
        rest[j] = g[j, 0] / t
    return low[0], total[0] + lacking(start, rest, k)


@kernel
def certify_in_digits(
    numbers: FloatArray, table: FloatArray, start: FloatArray, w: FloatArray, forces: FloatArray,
    v: FloatArray,
) -> float:  # fmt: skip
    """Do as `sole_kernels.certify` in twice the digits, for a finite wrench (6,) but zero, and mu > 0."""
    W, y, found = np.empty(6), np.empty(6), np.empty(forces.shape)
    norm, _ = normalise(numbers, w, W)
    low, high = _need(table, start, numbers[RADIUS], W, y, found)
    proofs_of(numbers, norm, found, 0, y, forces, v)
    return norm * 0.5 * (low + high)
