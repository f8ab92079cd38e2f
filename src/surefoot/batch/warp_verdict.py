"""The certificate and the gradient of one contact problem in one thread, for Warp.

The definitions are those of `batch.certificate` and `batch.modes`.
"""

# ruff: noqa: RUF046, UP018 (Warp reads int(0) as a variable, 0 as a constant)
# mypy: disable-error-code="untyped-decorator"

from __future__ import annotations

from surefoot.batch.warp_path import EPSILON, HUGE
from surefoot.batch.warp_runtime import Integers, Matrix, Real, Vector, wp

KINK = wp.constant(Real(1e-6))
RANK = wp.constant(Real(1e-12))
UNLOADED = wp.constant(Real(1e-9))
SWEEPS = wp.constant(40)
"""At most so many sweeps of rotations; eight are the rule."""


@wp.func
def move(G: Matrix, g: Vector, forces: Vector, u: Vector) -> int:
    """Fill u = G λ + g."""
    for i in range(g.shape[0]):
        total = g[i]
        for j in range(g.shape[0]):
            total += G[i, j] * forces[j]
        u[i] = total
    return 0


@wp.func
def weight_of(w: Vector, k: int) -> Real:
    """Return w_k, one where it is zero."""
    if w[k] > Real(0.0):
        return w[k]
    return Real(1.0)


@wp.func
def mode_of(
    forces: Vector, u: Vector, mu: Vector, on: Integers, w: Vector, s: Vector, convex: int, k: int
) -> wp.vec4d:
    """Return the code of contact k's mode, its sliding direction, and 2 ratio (+ 4 where it is a kink).

    The ratio, mu λ_n over the length of λ_t - u_t / w, is at most one where the contact slides.
    """
    i = 3 * k
    if on[k] == 0:
        return wp.vec4d(Real(0.0), Real(1.0), Real(0.0), Real(0.0))
    own = weight_of(w, k)
    lift = u[i + 2]
    if convex != 0:
        lift -= mu[k] * wp.sqrt(u[i] * u[i] + u[i + 1] * u[i + 1])
    lifted = own * forces[i + 2] - lift
    x = own * forces[i] - u[i]
    y = own * forces[i + 1] - u[i + 1]
    size = wp.sqrt(x * x + y * y)
    radius = own * mu[k] * wp.max(forces[i + 2], Real(0.0))
    near = wp.abs(lifted)
    if lifted > Real(0.0) and mu[k] > Real(0.0):
        near = wp.min(near, wp.abs(size - radius))
    kink = Real(0.0)
    if near <= KINK * s[k]:
        kink = Real(4.0)
    if not lifted > Real(0.0):
        return wp.vec4d(Real(1.0), Real(1.0), Real(0.0), kink)
    if size <= radius and radius > Real(0.0):
        return wp.vec4d(Real(2.0), Real(1.0), Real(0.0), kink)
    if size > Real(0.0):
        return wp.vec4d(Real(3.0), x / size, y / size, kink + Real(2.0) * radius / size)
    return wp.vec4d(Real(3.0), Real(1.0), Real(0.0), kink)


@wp.func
def snap(forces: Vector, u: Vector, mu: Vector, on: Integers, w: Vector, s: Vector, convex: int) -> int:
    """Take off what the iteration leaves: zero where contacts are open, on the rim where they slide."""
    for k in range(on.shape[0]):
        i = 3 * k
        code = mode_of(forces, u, mu, on, w, s, convex, k)[0]
        if code < Real(1.5):
            for a in range(3):
                forces[i + a] = Real(0.0)
        if code > Real(2.5):
            size = wp.sqrt(forces[i] * forces[i] + forces[i + 1] * forces[i + 1])
            forces[i + 2] = wp.max(forces[i + 2], Real(0.0))
            share = Real(0.0)
            if size > Real(0.0):
                share = mu[k] * forces[i + 2] / size
            forces[i] = forces[i] * share
            forces[i + 1] = forces[i + 1] * share
    return 0


@wp.func
def error_of(forces: Vector, u: Vector, mu: Vector, w: Vector, s: Vector, convex: int, k: int) -> Real:
    """Return ε_k / s_k of a contact that is on."""
    i = 3 * k
    x = forces[i]
    y = forces[i + 1]
    z = forces[i + 2]
    if not s[k] > Real(0.0):
        if x == Real(0.0) and y == Real(0.0) and z == Real(0.0):
            return Real(0.0)
        return HUGE
    v0 = u[i] / s[k]
    v1 = u[i + 1] / s[k]
    v2 = u[i + 2] / s[k]
    if convex == 0:
        v2 += mu[k] * wp.sqrt(v0 * v0 + v1 * v1)
    own = weight_of(w, k) / s[k]
    p = own * x - v0
    q = own * y - v1
    r = own * z - v2
    radius = wp.sqrt(p * p + q * q)
    if radius <= mu[k] * r:
        return wp.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
    height = wp.max(mu[k] * radius + r, Real(0.0)) / (Real(1.0) + mu[k] * mu[k])
    share = Real(0.0)
    if radius > Real(0.0):
        share = mu[k] * height / radius
    a = v0 - (p * share - p)
    b = v1 - (q * share - q)
    c = v2 - (height - r)
    return wp.sqrt(a * a + b * b + c * c)


@wp.func
def worst_rest(
    G: Matrix, forces: Vector, u: Vector, on: Integers, w: Vector, s: Vector, reach: Integers, convex: int
) -> Real:
    """Return the larger of `rounding` and, for the convex law, `energy_gap`."""
    n = on.shape[0]
    worst = Real(0.0)
    for k in range(n):
        total = Real(0.0)
        energy = Real(0.0)
        for j in range(n):
            block = Real(0.0)
            size = Real(0.0)
            for a in range(3):
                row = Real(0.0)
                for b in range(3):
                    row += G[3 * k + a, 3 * j + b] * G[3 * k + a, 3 * j + b]
                block += wp.sqrt(row)
                size += forces[3 * j + a] * forces[3 * j + a]
            total += block * wp.sqrt(size)
            if (reach[k] >> wp.int32(j)) & wp.int32(1) != 0 and on[j] != 0 and w[j] > Real(0.0):
                energy += s[j] / w[j] * s[j]
        if s[k] > Real(0.0):
            worst = wp.max(worst, Real(4.0) * EPSILON * total / s[k])
        power = Real(0.0)
        for a in range(3):
            power += forces[3 * k + a] * u[3 * k + a]
        if convex != 0 and wp.abs(power) > Real(0.0):
            gap = HUGE
            if energy > Real(0.0):
                gap = wp.abs(power) / energy
            worst = wp.max(worst, gap)
    return worst


@wp.func
def assemble(
    G: Matrix, forces: Vector, u: Vector, mu: Vector, on: Integers, w: Vector, s: Vector, convex: int,
    C: Matrix, R: Matrix, W: Vector, target: Vector, lean: Matrix, A: Matrix,
) -> int:  # fmt: skip
    """Fill the active system: C and R (m, 3) by unknown, W, A = R G C + W, and what mu moves.

    Unknown i belongs to contact i / 3; an unused one has W = 0 and zeros, and in A a one on the diagonal.
    """
    n = on.shape[0]
    m = W.shape[0]
    level = Real(0.0)
    for i in range(m):
        level += G[i, i] / Real(m)
        W[i] = Real(0.0)
        target[i] = Real(0.0)
        for a in range(3):
            C[i, a] = Real(0.0)
            R[i, a] = Real(0.0)
    if not level > Real(0.0):
        level = Real(1.0)
    for k in range(n):
        i = 3 * k
        lean[k, 0] = Real(0.0)
        lean[k, 1] = Real(0.0)
        mode = mode_of(forces, u, mu, on, w, s, convex, k)
        ex = mode[1]
        ey = mode[2]
        if mode[0] > Real(1.5) and mode[0] < Real(2.5):
            for a in range(3):
                C[i + a, a] = Real(1.0)
                R[i + a, a] = Real(1.0)
        if mode[0] > Real(2.5):
            ratio = Real(0.5) * mode[3]
            if mode[3] >= Real(4.0):
                ratio = Real(0.5) * (mode[3] - Real(4.0))
            C[i + 1, 0] = -ey
            C[i + 1, 1] = ex
            R[i + 1, 0] = -ratio * ey
            R[i + 1, 1] = ratio * ex
            W[i + 1] = (Real(1.0) - ratio) * weight_of(w, k)
            C[i + 2, 0] = mu[k] * ex
            C[i + 2, 1] = mu[k] * ey
            C[i + 2, 2] = Real(1.0)
            R[i + 2, 2] = Real(1.0)
            if convex != 0:
                R[i + 2, 0] = mu[k] * ex
                R[i + 2, 1] = mu[k] * ey
                target[i + 2] = -(u[i] * ex + u[i + 1] * ey)
            lean[k, 0] = forces[i + 2] * ex
            lean[k, 1] = forces[i + 2] * ey
    for i in range(m):
        for j in range(m):
            total = Real(0.0)
            for a in range(3):
                for b in range(3):
                    total += R[i, a] * G[3 * (i // 3) + a, 3 * (j // 3) + b] * C[j, b]
            A[i, j] = total
        own = wp.abs(C[i, 0]) + wp.abs(C[i, 1]) + wp.abs(C[i, 2])
        if own > Real(0.0):
            A[i, i] = A[i, i] + W[i]
        else:
            A[i, i] = level
    return 0


@wp.func
def rotate(A: Matrix, V: Matrix) -> int:
    """Turn A into A V with orthogonal columns (one-sided Jacobi); V is filled."""
    m = A.shape[0]
    for i in range(m):
        for j in range(m):
            V[i, j] = Real(0.0)
        V[i, i] = Real(1.0)
    turning = int(1)
    sweep = int(0)
    while turning != 0 and sweep < SWEEPS:
        turning = int(0)
        sweep += 1
        for p in range(m - 1):
            for q in range(p + 1, m):
                a = Real(0.0)
                b = Real(0.0)
                c = Real(0.0)
                for i in range(m):
                    a += A[i, p] * A[i, p]
                    b += A[i, q] * A[i, q]
                    c += A[i, p] * A[i, q]
                if wp.abs(c) > Real(1e-15) * wp.sqrt(a * b) and wp.abs(c) > Real(1e-290):
                    turning = int(1)
                    zeta = (b - a) / (Real(2.0) * c)
                    t = Real(1.0) / (wp.abs(zeta) + wp.sqrt(Real(1.0) + zeta * zeta))
                    if zeta < Real(0.0):
                        t = -t
                    cosine = Real(1.0) / wp.sqrt(Real(1.0) + t * t)
                    sine = cosine * t
                    for i in range(m):
                        x = A[i, p]
                        y = A[i, q]
                        A[i, p] = cosine * x - sine * y
                        A[i, q] = sine * x + cosine * y
                        x2 = V[i, p]
                        y2 = V[i, q]
                        V[i, p] = cosine * x2 - sine * y2
                        V[i, q] = sine * x2 + cosine * y2
    return sweep


@wp.func
def solve_transposed(A: Matrix, V: Matrix, C: Matrix, R: Matrix, p: Vector, u: Vector, q: Vector) -> int:
    """Fill q = A⁺ᵀ Cᵀ p and add what Sᵀ u has beyond A's range (R S = 1); A and V are `rotate`'s."""
    m = A.shape[0]
    most = Real(0.0)
    for c in range(m):
        size = Real(0.0)
        for i in range(m):
            size += A[i, c] * A[i, c]
        most = wp.max(most, size)
    for i in range(m):
        row = Real(0.0)
        over = Real(0.0)
        for a in range(3):
            row += R[i, a] * R[i, a]
            over += R[i, a] * u[3 * (i // 3) + a]
        q[i] = Real(0.0)
        if row > UNLOADED * UNLOADED:
            q[i] = over / row
    # from the outside in: first take from q what A reaches, then add the inverse
    for c in range(m):
        size = Real(0.0)
        along = Real(0.0)
        for i in range(m):
            size += A[i, c] * A[i, c]
            along += A[i, c] * q[i]
        if size > RANK * RANK * most:
            for i in range(m):
                q[i] = q[i] - along / size * A[i, c]
    for c in range(m):
        size = Real(0.0)
        along = Real(0.0)
        for i in range(m):
            size += A[i, c] * A[i, c]
            part = Real(0.0)
            for a in range(3):
                part += C[i, a] * p[3 * (i // 3) + a]
            along += V[i, c] * part
        if size > RANK * RANK * most:
            for i in range(m):
                q[i] = q[i] + along / size * A[i, c]
    return 0
