"""The scales by which an answer to a contact problem is judged; properties of the problem, not of the answer.

Contact k has its weight w_k = ||G_kk||₂, the velocity that a unit of force makes there, and its speed s_k:
the largest velocity, of all contacts that are on and joined to k through G, at the admissible forces
nearest to zero. So an error in contact k counts against the motion of its own connected part of the
problem, and neither huge forces nor an unrelated fast part can make it look small.

Entries of G at rounding level (`NOISE`) join contacts of two bodies that touch nothing in common: J M⁻¹ Jᵀ
computed with dense arithmetic is full of them. Through those a part lends only `LENT` of its speed, which
covers what the noise itself can do to the other's velocities.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.problem.blocks import dense_blocks

THIRD = 1.0 / 3.0
NOISE = 1.5e-14
"""Share of sqrt(trace G_kk trace G_jj) up to which the entries of G_kj are rounding."""
ROUNDING = 2.3e-16
"""Of one operation in double precision."""
REST = 1e-290
"""Speeds up to this are none: their quotients would not be numbers."""
LENT = 1e-6
"""Share of its speed that a part lends to one it is joined to by rounding alone."""


@inline_kernel
def symmetric_norm(a: float, b: float, c: float, d: float, e: float, f: float) -> float:
    """Return the spectral norm of [[a, d, e], [d, b, f], [e, f, c]], to 1e-8 relative.

    The largest root x = 2 cos(acos(y) / 3) of x³ - 3 x = 2 y (O. K. Smith, CACM 4(4), 1961), of the matrix
    less its mean and in units of its radius; as a polynomial in sqrt((1 + y) / 2), where it is analytic.
    """
    # the eigenvalues are mean + radius x with x³ - 3 x = 2 y, y = det(A - mean) / (2 radius³)
    mean = THIRD * (a + b + c)
    p, q, r = a - mean, b - mean, c - mean
    half = THIRD * (0.5 * (p * p + q * q + r * r) + d * d + e * e + f * f)
    if not 1e-60 < half < 1e60:  # cubes of it would overflow or vanish
        return _scaled_norm(a, b, c, d, e, f)
    return _norm_about(mean, half, p, q, r, d, e, f)


@inline_kernel
def _norm_about(
    mean: float, half: float, p: float, q: float, r: float, x: float, y: float, z: float
) -> float:
    """Return the norm from the diagonal's mean, the radius squared and the matrix less the mean."""
    radius = math.sqrt(half)
    cosine = (p * (q * r - z * z) - x * (x * r - z * y) + y * (x * z - q * y)) / (2.0 * half * radius)
    largest = mean + radius * _largest_root(cosine)
    # roots lie in [-2, 2] and the largest is 1 or more: only a mean below half the radius lets the
    # smallest eigenvalue have the larger size
    if mean < 0.5 * radius:  # not semidefinite, perhaps: the other end may be farther out
        largest = max(largest, radius * _largest_root(-cosine) - mean)
    return largest


@inline_kernel
def _scaled_norm(a: float, b: float, c: float, d: float, e: float, f: float) -> float:
    """Return the norm of a matrix of any size, or of one that is all but a multiple of the identity."""
    top = max(max(abs(a), abs(b)), max(abs(c), max(abs(d), max(abs(e), abs(f)))))
    if not 0.0 < top < np.inf:
        return top
    unit = 1.0 / top
    a, b, c, d, e, f = a * unit, b * unit, c * unit, d * unit, e * unit, f * unit
    mean = THIRD * (a + b + c)
    p, q, r = a - mean, b - mean, c - mean
    half = THIRD * (0.5 * (p * p + q * q + r * r) + d * d + e * e + f * f)
    if not half > 0.0:
        return abs(mean) * top
    return _norm_about(mean, half, p, q, r, d, e, f) * top


@inline_kernel
def _largest_root(cosine: float) -> float:
    """Return the largest x with x³ - 3 x = 2 cosine, to 1e-8."""
    # rounding takes a cosine beyond ±1 where two eigenvalues coincide
    t = math.sqrt(min(max(0.5 + 0.5 * cosine, 0.0), 1.0))
    x = 0.00741545040178 - 0.00127864228505 * t
    x = 0.0393516268071 + t * (-0.0206511564316 + t * x)
    x = 0.106577352451 + t * (-0.0639227086751 + t * x)
    x = 1.15469944022 + t * (-0.222191373842 + t * x)
    return 1.0000000065 + t * x


@kernel
def _labels(
    starts: IntArray, columns: IntArray, values: FloatArray, on: FloatArray, trace: FloatArray, noise: float,
    label: IntArray,
) -> bool:  # fmt: skip
    """Fill the labels (smallest contact) of the parts of a block matrix; tell whether noise joins some.

    By breadth-first search from each contact not yet reached.
    """
    n = label.size
    queue = np.empty(n, dtype=np.int64)
    faint = False
    for k in range(n):
        label[k] = -1
    for first in range(n):
        if label[first] >= 0:
            continue
        label[first], queue[0] = first, first
        head, tail = 0, 1
        # breadth first over the blocks that are no rounding: ||G_kj||² > noise² tr G_kk tr G_jj
        while head < tail:
            k = queue[head]
            head += 1
            for at in range(starts[k], starts[k + 1]):
                j = columns[at]
                # a contact that is off carries no force, and so couples nothing
                if label[j] >= 0 or on[k] == 0.0 or on[j] == 0.0:
                    continue
                entry = np.abs(values[at]).max()
                if entry > noise * math.sqrt(abs(trace[k])) * math.sqrt(abs(trace[j])):
                    label[j], queue[tail] = first, j
                    tail += 1
                else:
                    faint = faint or entry > 0.0
    return faint


@inline_kernel
def _drop_noise(velocities: FloatArray, sizes: FloatArray) -> None:
    """Set velocities of contacts to zero where they are what rounding makes of sums of terms of such sizes.

    Preloads that hold each other up to rounding leave no motion: their own sum is the solution.
    """
    for k in range(velocities.size // 3):
        i = 3 * k
        speed = abs(velocities[i]) + abs(velocities[i + 1]) + abs(velocities[i + 2])
        if speed <= ROUNDING * velocities.size * (sizes[i] + sizes[i + 1] + sizes[i + 2]):
            velocities[i] = velocities[i + 1] = velocities[i + 2] = 0.0


@inline_kernel
def _largest_speeds(
    velocities: FloatArray, on: FloatArray, label: IntArray, share: float, s: FloatArray
) -> None:
    """Raise s of every contact to `share` times the largest speed of its part."""
    n = label.size
    most = np.zeros(n)
    for k in range(n):
        if on[k] > 0.0:
            i = 3 * k
            speed = math.sqrt(velocities[i] ** 2 + velocities[i + 1] ** 2 + velocities[i + 2] ** 2)
            if not speed < 1e150 or 0.0 <= speed < 1e-150:  # the squares overflow, or vanish
                speed = math.hypot(math.hypot(velocities[i], velocities[i + 1]), velocities[i + 2])
                speed = speed if speed > REST else 0.0
            most[label[k]] = max(most[label[k]], speed)
    for k in range(n):
        s[k] = max(s[k], share * most[label[k]])


@inline_kernel
def _energies(w: FloatArray, s: FloatArray, label: IntArray, energy: FloatArray) -> None:
    """Fill the energy of every contact's part, Σ s_j² / w_j."""
    most = np.zeros(label.size)
    for k in range(label.size):
        if w[k] > 0.0:
            most[label[k]] += s[k] / w[k] * s[k]
    for k in range(label.size):
        energy[k] = most[label[k]]


@inline_kernel
def _in_one_part(G: FloatArray, trace: FloatArray, low: FloatArray, high: FloatArray) -> bool:
    """Tell whether every contact is on, without preload, and joined to the first: most robots' problems."""
    first = NOISE * NOISE * trace[0]
    for k in range(trace.size):
        if not (high[k] > 0.0 and low[k] <= 0.0):
            return False
        # squares are compared: no root for each of the blocks; |G_kj|² >
        # noise² tr G_kk tr G_jj as in `_labels`
        bound, joined = first * trace[k], k == 0
        for a in range(3):
            for b in range(3):
                joined = joined or G[a, 3 * k + b] * G[a, 3 * k + b] > bound
        if not joined:
            return False
    return True


@inline_kernel
def _scales_of_one_part(g: FloatArray, scales: FloatArray) -> bool:
    """Fill s and the energy of problems in one part; False where squares overflow or vanish."""
    n = scales.shape[1]
    most = energy = 0.0
    for k in range(n):
        most = max(most, g[3 * k] * g[3 * k] + g[3 * k + 1] * g[3 * k + 1] + g[3 * k + 2] * g[3 * k + 2])
        # Σ s² / w of one part, whose contacts all have the speed s
        energy += 1.0 / scales[0, k] if scales[0, k] > 0.0 else 0.0
    if not 1e-250 < most < 1e250:
        return False
    speed = math.sqrt(most)
    for k in range(n):
        scales[1, k], scales[3, k] = speed, energy * most
    return True


@inline_kernel
def scales_dense(G: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray, scales: FloatArray) -> None:
    """Fill the rows of `scales` (4, n) for a dense G: w, s, trace G_kk, and Σ s_j² / w_j of the part.

    A contact that is off (high = 0) joins nothing and has no speed of its own.
    """
    for k in range(low.size):
        i = 3 * k
        a, b, c = G[i, i], G[i + 1, i + 1], G[i + 2, i + 2]
        scales[0, k] = symmetric_norm(a, b, c, G[i, i + 1], G[i, i + 2], G[i + 1, i + 2])
        scales[2, k] = a + b + c
    # a search over blocks only where there may be more than one part
    if not (_in_one_part(G, scales[2], low, high) and _scales_of_one_part(g, scales)):
        starts, columns, values = dense_blocks(G)
        scales_blocks(starts, columns, values, g, low, high, scales)


@kernel
def scales_blocks(
    starts: IntArray, columns: IntArray, values: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray,
    scales: FloatArray,
) -> None:  # fmt: skip
    """Fill the rows of `scales` (4, n) for a block matrix in any number of parts; see `scales_dense`."""
    n = low.size
    label, work = np.empty(n, dtype=np.int64), np.empty((3, 3 * n))
    velocities, sizes, on = work[0], work[1], work[2]
    w, s, trace, energy = scales[0], scales[1], scales[2], scales[3]
    preloaded = False
    for i in range(3 * n):
        velocities[i], sizes[i] = g[i], abs(g[i])
    for k in range(n):
        s[k], on[k] = 0.0, 1.0 if high[k] > 0.0 else 0.0
        for at in range(starts[k], starts[k + 1]):
            B, preload = values[at], low[columns[at]]
            if columns[at] == k:
                w[k] = symmetric_norm(B[0, 0], B[1, 1], B[2, 2], B[0, 1], B[0, 2], B[1, 2])
                trace[k] = B[0, 0] + B[1, 1] + B[2, 2]
            if preload > 0.0:  # u = G λ + g at λ = (0, 0, low), the admissible forces nearest to zero
                preloaded = True
                for a in range(3):
                    velocities[3 * k + a] += B[a, 2] * preload
                    sizes[3 * k + a] += abs(B[a, 2] * preload)
    if preloaded:
        _drop_noise(velocities, sizes)
    faint = _labels(starts, columns, values, on, trace, NOISE, label)
    _largest_speeds(velocities, on, label, 1.0, s)
    # before noise lends speeds: the energy is the part's own
    _energies(w, s, label, energy)
    # parts that only blocks near rounding join lend each other a share of their speed
    if faint:
        _labels(starts, columns, values, on, trace, 0.0, label)
        _largest_speeds(velocities, on, label, LENT, s)
