"""The quadratic cost of six double integrators over a horizon, and its linear systems, step by step.

With accelerations x (N, 6), held over steps of h, places e and rates v follow from rest::

    e' = e + h v + h² x / 2,   v' = v + h x,   x · P x = Σ σ (w_e · e² + w_v · v²)

where σ is 1, or `terminal` for the last step. P is never formed: P x is a simulation forwards, and one of
the costates backwards. With a semi-definite block G for each step, z + G (P z + q) = r is the optimality
condition of a linear-quadratic problem, which Riccati's recursion solves in O(N) [1]_. With Π after the step
and X = Aᵀ Π B, S = Bᵀ Π B, ::

    E = G (I + S G)⁻¹ = Tᵀ T,   Π' = W + Aᵀ Π A - (T Xᵀ)ᵀ (T Xᵀ)

where G = U Uᵀ, C Cᵀ = I + Uᵀ S U and T = C⁻¹ Uᵀ: nothing is inverted that could be singular.

References
----------
.. [1] C. V. Rao, S. J. Wright, J. B. Rawlings, "Application of interior-point methods to model predictive
   control", Journal of Optimization Theory and Applications 99(3), 1998.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.cholesky import cholesky
from surefoot.base.numerics.six import Six, dot, mix, scale
from surefoot.contact.solvers.dual_newton.distribution_memory import column, store

SPENT = 1e-14
"""An entry of the diagonal of G is used up when no more than this share of it is left."""
NOTHING: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
PLACE, RATE, GAIN = 0, 6, 12
"""Columns of Π, and of `gains`: T Xᵀ, place and rate, and T."""


class Tracking(NamedTuple):
    """The cost of a motion, and room for Riccati's recursion.

    Attributes
    ----------
    weights
        (2, 6) on places and on rates, the latter positive.
    terminal
        Factor of both at the last step.
    dt
        Length of a step [s].
    path
        (N, 2, 6) places and rates after every step.
    value
        (12, 12) Π.
    small
        (4, 6, 6) Uᵀ, C, S and Uᵀ S of a step.
    push
        (6, 12) Bᵀ Π A of a step.
    gains
        (N, 6, 18) T Xᵀ and T of every step.
    """

    weights: FloatArray
    terminal: float
    dt: float
    path: FloatArray
    value: FloatArray
    small: FloatArray
    push: FloatArray
    gains: FloatArray


@inline_kernel
def tracking(weights: FloatArray, terminal: float, dt: float, steps: int) -> Tracking:
    """Return a cost with (12,) weights of the state and new room."""
    return Tracking(
        weights, terminal, dt, np.empty((steps, 2, 6)), np.empty((12, 12)), np.empty((4, 6, 6)),
        np.empty((6, 12)), np.empty((steps, 6, 18)),
    )  # fmt: skip


@inline_kernel
def _times(a: Six, b: Six) -> Six:
    """Return the products entry by entry."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3], a[4] * b[4], a[5] * b[5]


@inline_kernel
def _combine(x: Six, A: FloatArray, at: int) -> Six:
    """Return xᵀ A for six columns of A (6, ...), from `at` on."""
    low = mix(scale(x[0], column(A, 0, at)), x[1], column(A, 1, at))
    high = mix(scale(x[2], column(A, 2, at)), x[3], column(A, 3, at))
    last = mix(scale(x[4], column(A, 4, at)), x[5], column(A, 5, at))
    return mix(mix(low, 1.0, high), 1.0, last)


@inline_kernel
def _down(A: FloatArray, j: int) -> Six:
    """Return column j of A (6, ...)."""
    return A[0, j], A[1, j], A[2, j], A[3, j], A[4, j], A[5, j]


@inline_kernel
def _march(place: Six, rate: Six, h: float, x: Six) -> tuple[Six, Six]:
    """Return place and rate a step later."""
    return mix(mix(place, h, rate), 0.5 * h * h, x), mix(rate, h, x)


@kernel
def energy(t: Tracking, x: FloatArray) -> float:
    """Return x · P x for accelerations (N, 6)."""
    total, place, rate = 0.0, NOTHING, NOTHING
    by_place, by_rate = column(t.weights, 0, 0), column(t.weights, 1, 0)
    for k in range(x.shape[0]):
        place, rate = _march(place, rate, t.dt, column(x, k, 0))
        share = t.terminal if k == x.shape[0] - 1 else 1.0
        total += share * (dot(_times(by_place, place), place) + dot(_times(by_rate, rate), rate))
    return total


@kernel
def costates(
    weights: FloatArray, terminal: float, dt: float, path: FloatArray, q: FloatArray, out: FloatArray
) -> None:
    """Fill out (N, 6) with q (N, 6) plus the slope of a motion's cost in the accelerations of its steps.

    `path` (N, 2, 6) holds place and rate after every step.
    """
    place, rate, last = NOTHING, NOTHING, out.shape[0] - 1
    by_place, by_rate = column(weights, 0, 0), column(weights, 1, 0)
    for k in range(last, -1, -1):
        share = terminal if k == last else 1.0
        rate = mix(mix(rate, dt, place), share, _times(by_rate, column(path[k], 1, 0)))
        place = mix(place, share, _times(by_place, column(path[k], 0, 0)))
        store(out, k, 0, mix(mix(column(q, k, 0), dt, rate), 0.5 * dt * dt, place))


@inline_kernel
def _root(left: FloatArray, V: FloatArray) -> None:
    """Fill V (6, 6) so that Vᵀ V = G, a semi-definite matrix; `left` (6, 6) is its lower triangle at first.

    Cholesky's elimination in the order of the shares that are left of the diagonal: one or two feet do not
    span all accelerations, and in a fixed order rounding would pass for what they lack.
    """
    x = left[0, 0], left[1, 1], left[2, 2], left[3, 3], left[4, 4], left[5, 5]
    for i in range(6):
        for j in range(i):
            left[j, i] = left[i, j]
        store(V, i, 0, NOTHING)
    for k in range(6):
        # the pivot whose share of its own diagonal is largest, not the
        # largest entry: rows have different units
        most, p = SPENT, -1
        for i in range(6):
            share = left[i, i] / x[i] if x[i] > 0.0 else 0.0
            most, p = (share, i) if share > most else (most, p)
        if p < 0:
            break
        row = scale(1.0 / math.sqrt(left[p, p]), column(left, p, 0))
        store(V, k, 0, row)
        for i in range(6):
            store(left, i, 0, mix(column(left, i, 0), -V[k, i], row))


@kernel
def _gain(t: Tracking, G: FloatArray, gain: FloatArray) -> None:
    """Fill the gain (6, 18) of a step with the block G (6, 6), which is lost; `push` and S on the way."""
    V, C, S, VS, push, value, h = t.small[0], t.small[1], t.small[2], t.small[3], t.push, t.value, t.dt
    half = 0.5 * h * h
    for i in range(6):
        # Bᵀ Π with B = (h²/2, h): rows of place and rate; times B it is
        # S, times A = (1, h; 0, 1) it is `push`
        by_place = mix(scale(h, column(value, 6 + i, PLACE)), half, column(value, i, PLACE))
        by_rate = mix(scale(h, column(value, 6 + i, RATE)), half, column(value, i, RATE))
        store(S, i, 0, mix(scale(h, by_rate), half, by_place))
        store(push, i, PLACE, by_place)
        store(push, i, RATE, mix(by_rate, h, by_place))
    _root(G, V)
    for i in range(6):
        # C Cᵀ = I + Uᵀ S U is positive definite whatever the rank of G
        store(VS, i, 0, _combine(column(V, i, 0), S, 0))
        for j in range(i + 1):
            C[i, j] = dot(column(VS, i, 0), column(V, j, 0))
        C[i, i] += 1.0
    cholesky(C)
    for i in range(6):
        # T = C⁻¹ Uᵀ by forward substitution, and T Xᵀ = T Bᵀ Π A beside it: Riccati's step needs no more
        x = column(V, i, 0)
        for m in range(i):
            x = mix(x, -C[i, m], column(gain, m, GAIN))
        x = scale(1.0 / C[i, i], x)
        store(gain, i, GAIN, x)
        store(gain, i, PLACE, _combine(x, push, PLACE))
        store(gain, i, RATE, _combine(x, push, RATE))


@kernel
def _step_back(t: Tracking, gain: FloatArray) -> None:
    """Replace the value by that before the step whose gain is given."""
    value, h = t.value, t.dt
    for i in range(6):
        place, cross = column(value, i, PLACE), column(value, i, RATE)
        back, rate = column(value, 6 + i, PLACE), column(value, 6 + i, RATE)
        rate = mix(rate, h, mix(mix(cross, 1.0, back), h, place))  # symmetric to the last digit
        by_place, by_rate = _down(gain, i), _down(gain, 6 + i)
        # Aᵀ Π A for A = (1, h; 0, 1), less (T Xᵀ)ᵀ (T Xᵀ), block by block
        store(value, i, PLACE, mix(place, -1.0, _combine(by_place, gain, PLACE)))
        store(value, i, RATE, mix(mix(cross, h, place), -1.0, _combine(by_place, gain, RATE)))
        store(value, 6 + i, PLACE, mix(mix(back, h, place), -1.0, _combine(by_rate, gain, PLACE)))
        store(value, 6 + i, RATE, mix(rate, -1.0, _combine(by_rate, gain, RATE)))
        value[i, i] += t.weights[0, i]
        value[6 + i, 6 + i] += t.weights[1, i]


@kernel
def solve(t: Tracking, blocks: FloatArray, q: FloatArray, z: FloatArray, out: FloatArray) -> None:
    """Replace z (N, 6), a right side r, by the solution of z + G y = r, y = P z + q; fill out (N, 6) with y.

    `blocks` (N, 6, 6) are the lower triangles of G, and are lost; q is (N, 6).
    """
    N, h, half = z.shape[0], t.dt, 0.5 * t.dt * t.dt
    t.value[:] = 0.0
    for i in range(6):
        t.value[i, i], t.value[6 + i, 6 + i] = t.terminal * t.weights[0, i], t.terminal * t.weights[1, i]
    place, rate = NOTHING, NOTHING  # what the costate is at a place and rate of zero
    for k in range(N - 1, -1, -1):
        gain, r = t.gains[k], column(z, k, 0)
        _gain(t, blocks[k], gain)
        # the acceleration at a place and rate of zero: r - E (Bᵀ π + S r + q)
        b = mix(mix(mix(_combine(r, t.small[2], 0), h, rate), half, place), 1.0, column(q, k, 0))
        for i in range(6):
            x = column(gain, i, GAIN)
            r = mix(r, -dot(x, b), x)
        store(z, k, 0, r)
        # π <- Aᵀ (π + Π B r): the costate at rest, one step earlier
        rate = mix(mix(rate, h, place), 1.0, _combine(r, t.push, RATE))
        place = mix(place, 1.0, _combine(r, t.push, PLACE))
        if k > 0:
            _step_back(t, gain)
    # forwards from rest: each acceleration is its value at rest less E Xᵀ times the state that has come about
    place, rate = NOTHING, NOTHING
    for k in range(N):
        gain, x = t.gains[k], column(z, k, 0)
        for i in range(6):
            y = column(gain, i, PLACE), column(gain, i, RATE)
            x = mix(x, -dot(y[0], place) - dot(y[1], rate), column(gain, i, GAIN))
        store(z, k, 0, x)
        place, rate = _march(place, rate, h, x)
        store(t.path[k], 0, 0, place)
        store(t.path[k], 1, 0, rate)
    costates(t.weights, t.terminal, h, t.path, q, out)
