"""One contact problem in one thread: Newton's method on the central path, for Warp.

The equations are those of `batch.path`, the definitions those of `batch.certificate`; everything is a loop
over a few local arrays, in double precision, so the same source runs on the CPU and on CUDA. Most problems
take five Newton steps: two or three down the path, then straight to its end.
"""

# ruff: noqa: RUF046, UP018 (Warp reads int(0) as a variable, 0 as a constant)
# mypy: disable-error-code="untyped-decorator"

from __future__ import annotations

from surefoot.batch.warp_runtime import Integers, Matrix, Real, Vector, wp

ENOUGH = wp.constant(Real(1e-12))
"""Error of the scaled equations at which a problem is left; the path ends at its square."""
PROXIMAL = wp.constant(Real(1e-9))
NOISE = wp.constant(Real(1.5e-14))
LENT = wp.constant(Real(1e-6))
EPSILON = wp.constant(Real(2.220446049250313e-16))
HUGE = wp.constant(Real(wp.inf))


@wp.func
def largest_root(cosine: Real) -> Real:
    """Return the largest x with x³ - 3 x = 2 cosine."""
    return Real(2.0) * wp.cos(wp.acos(wp.clamp(cosine, Real(-1.0), Real(1.0))) / Real(3.0))


@wp.func
def block_norm(G: Matrix, i: int) -> Real:
    """Return the spectral norm of the symmetric 3x3 block of G at row i."""
    top = Real(0.0)
    for r in range(3):
        for c in range(3):
            top = wp.max(top, wp.abs(G[i + r, i + c]))
    if not top > Real(0.0):
        return Real(0.0)
    mean = (G[i, i] + G[i + 1, i + 1] + G[i + 2, i + 2]) / (Real(3.0) * top)
    a = G[i, i] / top - mean
    b = G[i + 1, i + 1] / top - mean
    c2 = G[i + 2, i + 2] / top - mean
    d = G[i, i + 1] / top
    e = G[i, i + 2] / top
    f = G[i + 1, i + 2] / top
    half = (a * a + b * b + c2 * c2) / Real(6.0) + (d * d + e * e + f * f) / Real(3.0)
    if not half > Real(0.0):
        return wp.abs(mean) * top
    radius = wp.sqrt(half)
    product = a * (b * c2 - f * f) - d * (d * c2 - f * e) + e * (d * f - b * e)
    cosine = product / (Real(2.0) * half * radius)
    return wp.max(mean + radius * largest_root(cosine), radius * largest_root(-cosine) - mean) * top


@wp.func
def raise_speeds(
    G: Matrix, g: Vector, on: Integers, noise: Real, share: Real, reach: Integers, s: Vector
) -> int:
    """Raise s_k to `share` times the largest speed of k's part; reach[k] gets the part's contacts as bits."""
    n = on.shape[0]
    for k in range(n):
        reach[k] = wp.int32(1) << wp.int32(k)
        for j in range(n):
            entry = Real(0.0)
            trace_k = Real(0.0)
            trace_j = Real(0.0)
            for a in range(3):
                trace_k += G[3 * k + a, 3 * k + a]
                trace_j += G[3 * j + a, 3 * j + a]
                for b in range(3):
                    entry = wp.max(entry, wp.abs(G[3 * k + a, 3 * j + b]))
            joined = entry > noise * wp.sqrt(wp.abs(trace_k)) * wp.sqrt(wp.abs(trace_j))
            if joined and on[k] != 0 and on[j] != 0:
                reach[k] = reach[k] | (wp.int32(1) << wp.int32(j))
    for _ in range(n):
        for k in range(n):
            for j in range(n):
                if (reach[k] >> wp.int32(j)) & wp.int32(1) != 0:
                    reach[k] = reach[k] | reach[j]
    for k in range(n):
        for j in range(n):
            if on[k] != 0 and on[j] != 0 and (reach[k] >> wp.int32(j)) & wp.int32(1) != 0:
                x = g[3 * j]
                y = g[3 * j + 1]
                z = g[3 * j + 2]
                top = wp.max(wp.max(wp.abs(x), wp.abs(y)), wp.abs(z))
                if top > Real(1e-290):
                    x = x / top
                    y = y / top
                    z = z / top
                    s[k] = wp.max(s[k], share * top * wp.sqrt(x * x + y * y + z * z))
    return 0


@wp.func
def prepare(
    G: Matrix,
    g: Vector,
    mu: Vector,
    on: Integers,
    w: Vector,
    s: Vector,
    reach: Integers,
    H: Matrix,
    f: Vector,
    turn: Vector,
    tilt: Vector,
) -> Real:
    """Fill the scales w, s and the scaled problem H, f, with forces per unknown; return the unit of κ."""
    n = on.shape[0]
    m = g.shape[0]
    for k in range(n):
        w[k] = block_norm(G, 3 * k)
        s[k] = Real(0.0)
    raise_speeds(G, g, on, Real(0.0), LENT, reach, s)
    raise_speeds(G, g, on, NOISE, Real(1.0), reach, s)
    top = Real(0.0)
    for k in range(n):
        i = 3 * k
        trace = (mu[k] * mu[k] * (G[i, i] + G[i + 1, i + 1]) + G[i + 2, i + 2]) / Real(3.0)
        D = Real(1.0)
        if trace > Real(0.0):
            D = Real(1.0) / wp.sqrt(trace)
        if on[k] == 0:
            D = Real(0.0)
        turn[i] = mu[k] * D
        turn[i + 1] = mu[k] * D
        turn[i + 2] = D
        tilt[k] = mu[k] * D
        for a in range(3):
            top = wp.max(top, wp.abs(turn[i + a] * g[i + a]))
    if not top > Real(0.0):
        top = Real(1.0)
    for i in range(m):
        f[i] = turn[i] * g[i] / top
        for j in range(m):
            H[i, j] = turn[i] * G[i, j] * turn[j]
    for i in range(m):
        turn[i] = turn[i] * top
    for k in range(n):
        tilt[k] = tilt[k] / top
    return top * top


@wp.func
def rise(value: Real, root: Real, kappa: Real) -> Real:
    """Return (value + root) / 2 with root² = value² + 4 κ, without cancelling."""
    if value > Real(0.0):
        return Real(0.5) * (value + root)
    if root - value > Real(0.0):
        return Real(2.0) * kappa / (root - value)
    return Real(0.0)


@wp.func
def slope(value: Real, root: Real) -> Real:
    """Return (1 + value / root) / 2, zero at the apex."""
    if root > Real(0.0):
        return Real(0.5) * (Real(1.0) + value / root)
    return Real(0.0)


@wp.func
def linearise(
    H: Matrix,
    f: Vector,
    on: Integers,
    tilt: Vector,
    w: Vector,
    s: Vector,
    convex: int,
    y: Vector,
    kappa: Real,
    unit: Real,
    proximal: Real,
    F: Vector,
    M: Matrix,
    whole: int,
) -> Real:
    """Fill F(y), and its Jacobian M if `whole`; return ||F||²."""
    n = on.shape[0]
    m = y.shape[0]
    total = Real(0.0)
    for k in range(n):
        i = 3 * k
        if on[k] == 0:
            for a in range(3):
                F[i + a] = y[i + a]
                total += y[i + a] * y[i + a]
                if whole != 0:
                    for j in range(m):
                        M[i + a, j] = Real(0.0)
                    M[i + a, i + a] = Real(1.0)
            continue
        u0 = f[i]
        u1 = f[i + 1]
        u2 = f[i + 2]
        for j in range(m):
            u0 += H[i, j] * y[j]
            u1 += H[i + 1, j] * y[j]
            u2 += H[i + 2, j] * y[j]
        t0 = Real(0.0)
        t1 = Real(0.0)
        if convex == 0:  # the De Saxcé shift, rounded
            power = kappa * unit * w[k]
            least = wp.sqrt(power)
            if s[k] > Real(0.0):
                least = power / s[k]
            speed = wp.sqrt(u0 * u0 + u1 * u1 + tilt[k] * tilt[k] * wp.min(power, least * least))
            if speed > Real(0.0):
                t0 = u0 / speed
                t1 = u1 / speed
            u2 += speed
        x = y[i] - u0
        z = y[i + 1] - u1
        h = y[i + 2] - u2
        radius = wp.sqrt(x * x + z * z)
        q = wp.sqrt((h + radius) * (h + radius) + Real(4.0) * kappa)
        r = wp.sqrt((h - radius) * (h - radius) + Real(4.0) * kappa)
        across = slope(Real(2.0) * h, q + r)
        F[i] = y[i] - across * x
        F[i + 1] = y[i + 1] - across * z
        F[i + 2] = y[i + 2] - Real(0.5) * (rise(h + radius, q, kappa) + rise(h - radius, r, kappa))
        total += F[i] * F[i] + F[i + 1] * F[i + 1] + F[i + 2] * F[i + 2]
        if whole == 0:
            continue
        ex = Real(1.0)
        ey = Real(0.0)
        if radius > Real(0.0):
            ex = x / radius
            ey = z / radius
        a0 = slope(h + radius, q)
        b0 = slope(h - radius, r)
        mean = Real(0.5) * (a0 + b0)
        skew = Real(0.5) * (a0 - b0)
        turned = mean - across
        J00 = across + turned * ex * ex
        J01 = turned * ex * ey
        J02 = skew * ex
        J11 = across + turned * ey * ey
        J12 = skew * ey
        # J times ds/du
        A00 = J00 + J02 * t0
        A01 = J01 + J02 * t1
        A10 = J01 + J12 * t0
        A11 = J11 + J12 * t1
        A20 = J02 + mean * t0
        A21 = J12 + mean * t1
        for j in range(m):
            p0 = H[i, j]
            p1 = H[i + 1, j]
            p2 = H[i + 2, j]
            M[i, j] = A00 * p0 + A01 * p1 + J02 * p2
            M[i + 1, j] = A10 * p0 + A11 * p1 + J12 * p2
            M[i + 2, j] = A20 * p0 + A21 * p1 + mean * p2
        one = Real(1.0) + proximal
        M[i, i] = M[i, i] + one - J00
        M[i, i + 1] = M[i, i + 1] - J01
        M[i, i + 2] = M[i, i + 2] - J02
        M[i + 1, i] = M[i + 1, i] - J01
        M[i + 1, i + 1] = M[i + 1, i + 1] + one - J11
        M[i + 1, i + 2] = M[i + 1, i + 2] - J12
        M[i + 2, i] = M[i + 2, i] - J02
        M[i + 2, i + 1] = M[i + 2, i + 1] - J12
        M[i + 2, i + 2] = M[i + 2, i + 2] + one - mean
    return total


@wp.func
def eliminate(A: Matrix, b: Vector) -> int:
    """Replace b by A⁻¹ b (A is lost), with pivots chosen by rows; a column of zeros moves nothing."""
    m = b.shape[0]
    for k in range(m):
        p = int(k)
        best = wp.abs(A[k, k])
        for i in range(k + 1, m):
            if wp.abs(A[i, k]) > best:
                best = wp.abs(A[i, k])
                p = int(i)
        if p != k:
            for j in range(k, m):
                held = A[k, j]
                A[k, j] = A[p, j]
                A[p, j] = held
            other = b[k]
            b[k] = b[p]
            b[p] = other
        if best > Real(0.0):
            share = Real(1.0) / A[k, k]
            for i in range(k + 1, m):
                factor = A[i, k] * share
                if factor != Real(0.0):
                    for j in range(k + 1, m):
                        A[i, j] = A[i, j] - factor * A[k, j]
                    b[i] = b[i] - factor * b[k]
    for back in range(m):
        i = m - 1 - back
        rest = b[i]
        for j in range(i + 1, m):
            rest -= A[i, j] * b[j]
        if A[i, i] != Real(0.0):
            b[i] = rest / A[i, i]
        else:
            b[i] = Real(0.0)
    return 0


@wp.func
def descend(
    H: Matrix,
    f: Vector,
    on: Integers,
    tilt: Vector,
    w: Vector,
    s: Vector,
    convex: int,
    unit: Real,
    y: Vector,
    best: Vector,
    F: Vector,
    trial: Vector,
    M: Matrix,
) -> Real:
    """Follow the path to its end; fill `best` and return its error. Slower descents follow a fast one."""
    m = y.shape[0]
    error = HUGE
    for stage in range(3):
        factor = Real(0.05)
        jump = Real(0.001)
        share = Real(0.001)
        limit = int(12)
        if stage == 1:
            factor = Real(0.3)
            jump = Real(0.0)
            limit = int(40)
        if stage == 2:
            factor = Real(0.6)
            jump = Real(0.0)
            share = Real(0.01)
            limit = int(100)
        kappa = Real(1.0)
        for i in range(m):
            y[i] = Real(0.0)
            if i % 3 == 2:
                y[i] = Real(1.0)
        count = int(0)
        while count < limit and error > ENOUGH:
            count += 1
            root = wp.sqrt(kappa)
            before = wp.sqrt(linearise(
                H, f, on, tilt, w, s, convex, y, kappa, unit, wp.max(share * root, PROXIMAL), F, M, 1
            ))  # fmt: skip
            eliminate(M, F)
            for i in range(m):
                trial[i] = F[i]  # the step
            length = Real(2.0)
            after = HUGE
            halvings = int(0)
            kept_length = Real(0.0)
            kept = HUGE
            while halvings < 6:
                halvings += 1
                length = Real(0.5) * length
                for i in range(m):
                    y[i] = y[i] - length * trial[i]
                after = wp.sqrt(linearise(
                    H, f, on, tilt, w, s, convex, y, kappa, unit, Real(0.0), F, M, 0
                ))  # fmt: skip
                for i in range(m):
                    y[i] = y[i] + length * trial[i]
                if after < kept:
                    kept = after
                    kept_length = length
                if after <= (Real(1.0) - Real(0.1) * length) * before:
                    halvings = int(6)
            for i in range(m):
                y[i] = y[i] - kept_length * trial[i]
            if kept <= root:
                down = factor
                if kept_length == Real(1.0):
                    down = factor * factor
                kappa = kappa * down
                if kappa < jump or kappa < ENOUGH * ENOUGH:
                    kappa = ENOUGH * ENOUGH
            now = wp.sqrt(linearise(
                H, f, on, tilt, w, s, convex, y, Real(0.0), unit, Real(0.0), F, M, 0
            ))  # fmt: skip
            if now < error:
                error = now
                for i in range(m):
                    best[i] = y[i]
    return error
