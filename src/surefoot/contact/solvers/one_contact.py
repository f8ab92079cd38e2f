"""The contact problem of a single contact, solved exactly; the local step of Gauss-Seidel.

Three cases: take-off, stick (a 3x3 solve) and slide. A sliding force lies on the cone, r = s (mu e, 1) with a
unit direction e, and its normal part s follows from e in closed form; what is left is one equation in the
angle of e (a quartic in the tangent of its half), which a safeguarded Newton iteration solves; where that
fails the whole circle is searched. Bounds on the normal force turn the section into a disc of known radius.

References
----------
.. [1] O. Bonnefon, G. Daviet, "Quartic formulation of Coulomb 3D frictional contact", INRIA RT-0400, 2011.
.. [2] P. C. Horak, J. C. Trinkle, "On the similarities and differences among contact models in robot
   simulation", IEEE RA-L 4(2), 2019.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel

LOCAL_DAMPING = 1e-12
"""Added to a block's diagonal, relative to its trace; a proximal term, so it moves no solution."""
FRICTIONLESS = 1e-140
"""Friction below this is none: its square would not be a number."""
WIDTH = 16
"""Numbers kept of a contact: 14 by `prepare`, 2 by `stopping.fill_measure`."""
Block = tuple[float, ...]
"""The first twelve of them: a tuple lives in registers, where a view of an array is counted and reloaded."""
CLOSE = 1e-4
"""A Newton step on the angle below this squares itself away: the next sweep starts from 1e-8 of the angle."""


@inline_kernel
def prepare(
    G00: float, G01: float, G02: float, G11: float, G12: float, G22: float, local: FloatArray, k: int
) -> None:
    """Fill row k of local: [0:6] the damped 3x3 block (00, 01, 02, 11, 12, 22), [6:12] its inverse.

    [12:14] is room for the direction in which the contact last slid; zero, as here, if that is not known.
    """
    trace = G00 + G11 + G22
    # a proximal term: `nsgs._change` subtracts this same damped block from the velocity, so that a force that
    # solves the contact solves it damped or not. A block of zeros has no size of its own: any unit will do.
    damping = LOCAL_DAMPING * trace if trace > 0.0 else 1.0
    a, b, c = G00 + damping, G11 + damping, G22 + damping
    # the inverse by cofactors: symmetric, without branches, six numbers to keep
    A, B, C = b * c - G12 * G12, G02 * G12 - G01 * c, G01 * G12 - G02 * b
    det = a * A + G01 * B + G02 * C
    # a rank-one block has det = damping² trace, 1e-24 of trace³: what is far below that, negative or no
    # number at all is what cancellation in the cofactors left, and its inverse would be noise
    if not det > 1e-30 * trace * trace * trace:  # singular beyond rounding: damp more
        damping = 1e-9 * trace if trace > 0.0 else 1.0
        a, b, c = G00 + damping, G11 + damping, G22 + damping
        A, B, C = b * c - G12 * G12, G02 * G12 - G01 * c, G01 * G12 - G02 * b
        det = a * A + G01 * B + G02 * C
    local[k, 0], local[k, 1], local[k, 2], local[k, 3], local[k, 4], local[k, 5] = a, G01, G02, b, G12, c
    share = 1.0 / det
    local[k, 6], local[k, 7], local[k, 8] = A * share, B * share, C * share
    local[k, 9], local[k, 10] = (a * c - G02 * G02) * share, (G01 * G02 - a * G12) * share
    local[k, 11] = (a * b - G01 * G01) * share
    local[k, 12] = local[k, 13] = 0.0


@inline_kernel
def _slope(
    W: Block, q0: float, q1: float, q2: float, mu: float, convex: bool, ex: float, ey: float
) -> tuple[float, float, float]:
    """Return h, dh/dangle and s = v . e (negative at a solution) for a direction e.

    v is the tangential velocity times a positive factor; h its part across e.
    """
    # r = s (mu e, 1) slides with u_n = 0 (Coulomb) or u_n = -mu u_t·e (convex): s = -b / a, and a > 0 times
    # the tangential velocity is v = a q_t - b (mu W_tt e + W_tn); it must point against e
    tx, ty = W[0] * ex + W[1] * ey, W[1] * ex + W[3] * ey
    px, py = -W[0] * ey + W[1] * ex, -W[1] * ey + W[3] * ex  # Wtt times e turned by 90 degrees
    wx, wy = mu * tx + W[2], mu * ty + W[4]
    # a(e) = nᵀ W n and b(e) = q·n with n = (mu e, 1) for the convex law, whose sliding force
    # does no work on u; Coulomb's asks for u_n = 0 alone, which drops the rows of the
    # tangents. da and db: along the turn of e
    if convex:
        a = mu * (wx * ex + wy * ey) + mu * (W[2] * ex + W[4] * ey) + W[5]
        da = 2.0 * mu * (-wx * ey + wy * ex)
        b = q2 + mu * (q0 * ex + q1 * ey)
        db = mu * (-q0 * ey + q1 * ex)
    else:
        a = W[5] + mu * (W[2] * ex + W[4] * ey)
        da = mu * (-W[2] * ey + W[4] * ex)
        b = q2
        db = 0.0
    vx, vy = q0 * a - b * wx, q1 * a - b * wy
    dx, dy = q0 * da - db * wx - b * mu * px, q1 * da - db * wy - b * mu * py
    # v = s e + h e⊥; e⊥ turns towards -e, hence -s in dh: where friction opposes a fast slide (s << 0) h
    # rises steeply through its zero, where it would drive the slide (s > 0) it falls
    h = -vx * ey + vy * ex
    s = vx * ex + vy * ey
    slope = -dx * ey + dy * ex - s
    return h, slope, s


@inline_kernel
def _sliding_normal(
    W: Block, q0: float, q1: float, q2: float, mu: float, convex: bool, ex: float, ey: float
) -> float:
    """Return the normal force with which the contact slides along e; -1 if there is none."""
    a, b = W[5] + mu * (W[2] * ex + W[4] * ey), q2
    if convex:
        tx, ty = W[0] * ex + W[1] * ey, W[1] * ex + W[3] * ey
        a += mu * ((mu * tx + W[2]) * ex + (mu * ty + W[4]) * ey)
        b += mu * (q0 * ex + q1 * ey)
    # a <= 0: normal and tangents are coupled so strongly that a sliding force drives the
    # contact inwards (Painlevé's paradox)
    return -b / a if a > 0.0 else -1.0


@kernel
def _search_circle(
    W: Block, q0: float, q1: float, q2: float, mu: float, convex: bool
) -> tuple[bool, float, float]:
    """Look for a sliding direction on the whole circle: sign changes of h, refined by bisection."""
    count = 96
    last = _slope(W, q0, q1, q2, mu, convex, 1.0, 0.0)[0]
    for k in range(count):
        low, high = 2.0 * math.pi * k / count, 2.0 * math.pi * (k + 1) / count
        now = _slope(W, q0, q1, q2, mu, convex, math.cos(high), math.sin(high))[0]
        if last <= 0.0 <= now:  # h rises through a solution
            # fifty halvings of 2π / 96 leave 6e-17 rad, less than a double tells from the angle
            for _ in range(50):
                middle = 0.5 * (low + high)
                if _slope(W, q0, q1, q2, mu, convex, math.cos(middle), math.sin(middle))[0] <= 0.0:
                    low = middle
                else:
                    high = middle
            ex, ey = math.cos(low), math.sin(low)
            s = _slope(W, q0, q1, q2, mu, convex, ex, ey)[2]
            # a rising zero of h may still be one where a changes sign, or whose force would pull
            if s <= 0.0 and _sliding_normal(W, q0, q1, q2, mu, convex, ex, ey) > 0.0:
                return True, ex, ey
        last = now
    return False, 1.0, 0.0


@kernel
def _disc(W: Block, q0: float, q1: float, normal: float, radius: float) -> tuple[float, float]:
    """Return the tangential force of least energy in a disc, the normal force being known.

    On the rim (Wtt + s) r = -p with a multiplier s >= 0; Newton on 1 / |r(s)| climbs to it from s = 0.
    """
    # min ½ rᵀ Wtt r + p·r over ||r|| <= radius, a trust region's subproblem: p is the free velocity that the
    # known normal force leaves, and a force inside the disc stops the contact (s = 0, it sticks)
    px, py = q0 + W[2] * normal, q1 + W[4] * normal
    s = 0.0
    x = y = 0.0
    for _ in range(60):
        a, c = W[0] + s, W[3] + s
        det = a * c - W[1] * W[1]
        # tangents that no force moves: any multiplier that makes the matrix definite, doubled until one does
        if not det > 0.0:
            s = 1e-12 * (W[0] + W[3]) + 2.0 * s
            continue
        x, y = -(c * px - W[1] * py) / det, -(a * py - W[1] * px) / det
        square = x * x + y * y
        length = math.sqrt(square)
        if length <= radius * (1.0 + 1e-14):
            break
        # rᵀ (Wtt + s)⁻¹ r, minus half the derivative of ||r||². 1 / ||r(s)|| is nearly linear in s where
        # ||r(s)|| has a pole, and concave: from s = 0 the steps never pass the root (Moré and Sorensen 1983)
        along = (c * x * x - 2.0 * W[1] * x * y + a * y * y) / det
        if not along > 0.0:  # a radius too small to square
            break
        s += (length / radius - 1.0) * square / along  # Newton on 1 / |r(s)| = 1 / radius
    # onto the rim exactly: rounding must not leave a force outside its cone
    length = math.sqrt(x * x + y * y)
    if length > radius:
        x, y = radius * x / length, radius * y / length
    return x, y


@inline_kernel
def block_of(local: FloatArray, k: int) -> Block:
    """Return the twelve numbers that `prepare` put in row k of local (n, WIDTH): block of G, and inverse."""
    return (
        local[k, 0], local[k, 1], local[k, 2], local[k, 3], local[k, 4], local[k, 5],
        local[k, 6], local[k, 7], local[k, 8], local[k, 9], local[k, 10], local[k, 11],
    )  # fmt: skip


@inline_kernel
def _unit(x: float, y: float) -> tuple[float, float]:
    length = math.sqrt(x * x + y * y)
    return (x / length, y / length) if length > 0.0 else (1.0, 0.0)


@inline_kernel
def _turn(
    W: Block, q0: float, q1: float, q2: float, mu: float, convex: bool, ex: float, ey: float
) -> tuple[bool, float, float, float]:
    """Turn a unit direction by Newton steps until it is one of sliding.

    Return whether it is, the direction, and the normal force. Contacts are solved one after another, so what
    counts is how long each number waits for the last: a turn by t takes one division and no root.
    """
    for _ in range(20):
        h, slope, s = _slope(W, q0, q1, q2, mu, convex, ex, ey)
        if slope > 0.0 and s < 0.0:
            turn = -h / slope
            good = abs(turn) < CLOSE
            # Cayley's rotation: of length one whatever the turn, and its angle right
            # to third order, all that Newton uses
            half = 0.5 * max(-0.8, min(0.8, turn))
            share = 1.0 / (1.0 + half * half)
            cosine, sine = (1.0 - half * half) * share, 2.0 * half * share
            ex, ey = cosine * ex - sine * ey, cosine * ey + sine * ex
            # judged before the turn, so that the step just taken is the last:
            # what it leaves is the square of `CLOSE`
            if good:
                normal = _sliding_normal(W, q0, q1, q2, mu, convex, ex, ey)
                if normal > 0.0:
                    return True, ex, ey, normal
        else:  # uphill: turn against the velocity
            # v = s e + h e⊥ as `_slope` splits it: friction against the velocity
            # that e itself leads to, a fixed point
            fx, fy = -(ex * s - h * ey), -(ey * s + h * ex)
            length = math.sqrt(fx * fx + fy * fy)
            if length == 0.0:
                break
            ex, ey = fx / length, fy / length
    return False, ex, ey, 0.0


@inline_kernel
def solve_one(
    W: Block, q0: float, q1: float, q2: float, mu: float, low: float, high: float, convex: bool,
    x: float, y: float, ex: float, ey: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Return the force of one contact with free velocity q, and the direction in which it slides.

    (ex, ey) is the direction in which it last slid, returned as it came where it does not slide; for (0, 0)
    a guess (x, y) of the tangential force serves. low = -inf marks a bilateral contact.
    """
    # a free velocity in K* needs no force; Coulomb's law shifts it into K* by Γ, which leaves q_n >= 0 to
    # ask. First, because take-off and stick may both be solutions where normal and tangents couple
    lifts = q2 >= (mu * math.sqrt(q0 * q0 + q1 * q1) if convex else 0.0)
    if lifts and low == 0.0:
        return 0.0, 0.0, 0.0, ex, ey
    # the force that stops the contact, -W⁻¹ q: the answer of a bilateral contact, and of one that sticks
    r0 = -(W[6] * q0 + W[7] * q1 + W[8] * q2)
    r1 = -(W[7] * q0 + W[9] * q1 + W[10] * q2)
    r2 = -(W[8] * q0 + W[10] * q1 + W[11] * q2)
    if low == -math.inf:
        return r0, r1, r2, ex, ey
    limit = mu * r2
    if low <= r2 <= high and r0 * r0 + r1 * r1 <= limit * limit:
        return r0, r1, r2, ex, ey
    if mu < FRICTIONLESS:
        return 0.0, 0.0, min(max(-q2 / W[5], low), high), ex, ey
    normal = 0.0
    if r2 > 0.0 and r0 * r0 + r1 * r1 <= limit * limit:  # it would stick, but for the bounds
        normal = r2
    elif not lifts:  # what lifts is held down by a bound, and may still slide under it
        # towards where it would stick: right where the tangents' inertias differ much
        if ex == 0.0 and ey == 0.0:
            ex, ey = _unit(r0, r1) if x == 0.0 and y == 0.0 else _unit(x, y)
        good, ex, ey, normal = _turn(W, q0, q1, q2, mu, convex, ex, ey)
        if not good:  # afresh
            ex, ey = _unit(r0, r1)
            good, ex, ey, normal = _turn(W, q0, q1, q2, mu, convex, ex, ey)
        if not good:
            # twice Newton has left the branch: every zero of h is looked at, far more slowly
            good, ex, ey = _search_circle(W, q0, q1, q2, mu, convex)
            normal = _sliding_normal(W, q0, q1, q2, mu, convex, ex, ey) if good else 0.0
        if low <= normal <= high:
            long = 1.5 - 0.5 * (ex * ex + ey * ey)  # keeps it of length one over many turns
            return mu * normal * ex, mu * normal * ey, normal, long * ex, long * ey
    # a bound holds the normal force; where no sliding force exists the free normal force decides
    normal = min(max(normal, low), high)
    radius = mu * normal
    if radius == 0.0:
        return 0.0, 0.0, normal, ex, ey
    a, b = _disc(W, q0, q1, normal, radius)
    return a, b, normal, ex, ey
