"""Compiled Newton method for force distribution, in the six dimensions of the wrench.

The program, after weights have been absorbed into the unknowns, is::

    min  1/2 ||B f - b||² + 1/2 ||f - c||²   over the truncated friction cones

Its dual has six unknowns y, whatever the number of contacts, and no constraint. Given y the forces
are f = P(c + Bᵀ y), one projection per contact, hence always inside the cones; the dual's gradient is
F(y) = y + B f - b. It is piecewise smooth and strongly monotone, so Newton's method with the
projection's Jacobian and a line search on the (convex) dual converges from anywhere, with a
quadratic tail [1]_. The duality gap at f is exactly 1/2 ||F||², and the distance from f to the optimum
at most ||F||: every answer carries its own error bound.

Where the wanted wrench is out of reach and the force weight small, the dual is almost polyhedral and
Newton alone would zigzag. Then the force weight is first taken `kappa` times larger and brought back
in steps, each with a prediction of y (a path that starts at an easy program and ends at ours).

References
----------
.. [1] L. Qi, J. Sun, "A nonsmooth version of Newton's method", Mathematical Programming 58, 1993.
"""

from __future__ import annotations

import math

from surefoot.arrays import BoolArray, FloatArray
from surefoot.cones.projection import project_truncated
from surefoot.kernels import inline_kernel, kernel
from surefoot.solvers.distribution_six import (
    Lower,
    Six,
    add_outer,
    dot,
    mix,
    scale,
    scaled_identity,
    solve_six,
    times,
)

# `work` has one row per contact ...
MU, LOW, HIGH = 0, 1, 2  # the cone, in scaled units; HIGH = 0 switches the contact off
CENTRE = 5  # c, 3 numbers
BLOCK = 8  # the contact's part of B: three columns of six
POINT = 26  # c + Bᵀ y, 3 numbers
OLD = 29  # the points before a step
STEP = 32  # how far a full Newton step moves them
FORCE = 35  # f, 3 numbers
TANGENT, NORMAL = 3, 4  # newtons per scaled unit
FLOOR, CEILING = 38, 39  # normal bounds [N]
LAST = 40  # the last command [N], 3 numbers
REFERENCE = 43  # wanted force [N], 3 numbers
PULL, DRAG = 46, 48  # what the reference and the last command give to c: tangential and normal [1/N]
WIDTH = 50
# ... and two more: memory (the dual wrench, roots of the wrench weights) ...
DUAL, ROOT = 0, 6
# ... and settings and results.
WARM, TOLERANCE, LIMIT, HAS_LAST, ITERATIONS, FORCE_ERROR, GAP, WRENCH_ERROR = 0, 1, 2, 3, 4, 5, 6, 7
ROW_VIOLATION, ROWS_WARM = 8, 9  # see `surefoot.solvers.distribution_rows`

SOLVED, ALMOST, MAX_ITERATIONS, INVALID, INFEASIBLE = 0, 1, 2, 3, 4

# Counts are floats on purpose: Numba would compile a caller's integer constants into copies of a kernel.
# Tuning; what they change is the time of hard instances, never the answer.
FAR = 0.3  # share of ||b||² at which the first residual sends an instance down the path
PATIENCE = 3.0  # line searches on the direct way before the path is taken
PATH_START = 0.002  # kappa at the start of the path, over the squared Frobenius norm of B
PATH_STEP = 0.05  # shrinkage of kappa from stage to stage; then, if that failed, ...
SMALL_STEP = 0.2
PATH_TOLERANCE = 1e-5  # of a stage: ||F||² over ||b||²; then, if that failed, ...
TIGHT_TOLERANCE = 1e-10
PATH_LIMIT = 40.0  # iterations of the last stage before the path is taken again, carefully
RELATIVE = 1e-12  # duality gap over the objective that counts as solved where rounding stops the rest
ROUNDING = 1e-31  # square of the relative error of a residual in doubles


@inline_kernel
def column(work: FloatArray, k: int, at: int) -> Six:
    """Return six numbers of a row."""
    return (
        work[k, at], work[k, at + 1], work[k, at + 2],
        work[k, at + 3], work[k, at + 4], work[k, at + 5],
    )  # fmt: skip


@inline_kernel
def combine(work: FloatArray, k: int, x: float, y: float, z: float) -> Six:
    """Return the wrench B_i (x, y, z) of the contact in a row."""
    return (
        work[k, 8] * x + work[k, 14] * y + work[k, 20] * z,
        work[k, 9] * x + work[k, 15] * y + work[k, 21] * z,
        work[k, 10] * x + work[k, 16] * y + work[k, 22] * z,
        work[k, 11] * x + work[k, 17] * y + work[k, 23] * z,
        work[k, 12] * x + work[k, 18] * y + work[k, 24] * z,
        work[k, 13] * x + work[k, 19] * y + work[k, 25] * z,
    )


@inline_kernel
def place(work: FloatArray, contacts: int, y: Six, rho: float) -> None:
    """Set the points to c + rho Bᵀ y."""
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            work[k, POINT] = work[k, CENTRE] + rho * dot(column(work, k, BLOCK), y)
            work[k, POINT + 1] = work[k, CENTRE + 1] + rho * dot(column(work, k, BLOCK + 6), y)
            work[k, POINT + 2] = work[k, CENTRE + 2] + rho * dot(column(work, k, BLOCK + 12), y)


@inline_kernel
def aim(work: FloatArray, contacts: int, d: Six, rho: float) -> None:
    """Remember the points and set STEP to rho Bᵀ d."""
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            work[k, OLD], work[k, OLD + 1], work[k, OLD + 2] = (
                work[k, POINT],
                work[k, POINT + 1],
                work[k, POINT + 2],
            )
            work[k, STEP] = rho * dot(column(work, k, BLOCK), d)
            work[k, STEP + 1] = rho * dot(column(work, k, BLOCK + 6), d)
            work[k, STEP + 2] = rho * dot(column(work, k, BLOCK + 12), d)


@inline_kernel
def move(work: FloatArray, contacts: int, t: float) -> None:
    """Set the points to OLD + t STEP.

    They are carried along and not computed from y, which has too few digits for them when the force
    weight is tiny; a rounding error in a point is harmless, it acts like one in c.
    """
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            work[k, POINT] = work[k, OLD] + t * work[k, STEP]
            work[k, POINT + 1] = work[k, OLD + 1] + t * work[k, STEP + 1]
            work[k, POINT + 2] = work[k, OLD + 2] + t * work[k, STEP + 2]


@inline_kernel
def evaluate(work: FloatArray, contacts: int, y: Six, b: Six) -> Six:
    """Set the forces from the points and return the gradient F = y + B f - b."""
    F = mix(y, -1.0, b)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            p, q, r = project_truncated(
                work[k, POINT],
                work[k, POINT + 1],
                work[k, POINT + 2],
                work[k, MU],
                work[k, LOW],
                work[k, HIGH],
            )
            work[k, FORCE], work[k, FORCE + 1], work[k, FORCE + 2] = p, q, r
            F = mix(F, 1.0, combine(work, k, p, q, r))
    return F


@inline_kernel
def assemble(work: FloatArray, contacts: int, kappa: float) -> Lower:
    """Return kappa I + Σ B_i P_i' B_iᵀ at the points, P_i' the projection's Jacobian.

    On the cone's side the Jacobian has rank two: along the side, and sideways by mu f_z / ||point_t||.
    """
    H = scaled_identity(kappa)
    for k in range(contacts):
        if work[k, HIGH] <= 0.0:
            continue
        u, v, mu, z = work[k, POINT], work[k, POINT + 1], work[k, MU], work[k, FORCE + 2]
        limit = mu * z
        free = work[k, LOW] < z < work[k, HIGH]
        t = math.sqrt(u * u + v * v)
        if t <= limit and limit > 0.0:
            H = add_outer(H, column(work, k, BLOCK))
            H = add_outer(H, column(work, k, BLOCK + 6))
            if free:
                H = add_outer(H, column(work, k, BLOCK + 12))
        elif z > 0.0:
            p, q = (u / t, v / t) if t > 0.0 else (0.0, 0.0)
            if limit > 0.0:
                s = math.sqrt(limit / t)
                H = add_outer(H, combine(work, k, -q * s, p * s, 0.0))
            if free:
                s = 1.0 / math.sqrt(1.0 + mu * mu)
                H = add_outer(H, combine(work, k, p * mu * s, q * mu * s, s))
    return H


@inline_kernel
def slope(work: FloatArray, contacts: int, t: float) -> float:
    """Return the contacts' part of the dual's derivative, t of the way along STEP."""
    total = 0.0
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            e0, e1, e2 = work[k, STEP], work[k, STEP + 1], work[k, STEP + 2]
            p, q, r = project_truncated(
                work[k, OLD] + t * e0, work[k, OLD + 1] + t * e1, work[k, OLD + 2] + t * e2,
                work[k, MU], work[k, LOW], work[k, HIGH],
            )  # fmt: skip
            total += p * e0 + q * e1 + r * e2
    return total


@kernel
def search(
    work: FloatArray, contacts: int, kappa: float, base: float, curve: float, at_0: float, at_1: float
) -> float:
    """Return a step in (0, 1) at which the dual's derivative is a tenth of that at 0, or less.

    `base` + t `curve` is what y adds to the derivative. False position with the Illinois rule, and
    a bisection every third time because the derivative may be almost a staircase.
    """
    left, right, f_left, f_right = 0.0, 1.0, at_0, at_1
    t, side = 1.0, 0
    for k in range(60):
        t = (left * f_right - right * f_left) / (f_right - f_left)
        if k % 3 == 2:
            t = 0.5 * (left + right)
        f = kappa * slope(work, contacts, t) + base + t * curve
        if abs(f) <= -0.1 * at_0:
            break
        if f < 0.0:
            left, f_left = t, f
            f_right = 0.5 * f_right if side < 0 else f_right
            side = -1
        else:
            right, f_right = t, f
            f_left = 0.5 * f_left if side > 0 else f_left
            side = 1
    return t


@inline_kernel
def spread(work: FloatArray, contacts: int) -> float:
    """Return Σ ||point||², on which the rounding error of F depends."""
    total = 0.0
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            total += work[k, POINT] ** 2 + work[k, POINT + 1] ** 2 + work[k, POINT + 2] ** 2
    return total


@kernel
def newton(
    work: FloatArray, contacts: int, b: Six, start: Six, kappa: float, tol: float, noise: float,
    limit: float, patience: float,
) -> tuple[Six, float, int]:  # fmt: skip
    """Return the dual wrench, ||F||² and the iterations, for a force weight kappa times larger.

    Stops at ||F||² <= tol, at the rounding error, after `limit` iterations or when a full step has
    failed `patience` times.
    """
    y, rho = start, 1.0 / kappa
    place(work, contacts, y, rho)
    F = evaluate(work, contacts, y, b)
    error = dot(F, F)
    best, count = error, 0
    while error > max(tol, noise * spread(work, contacts)) and count < limit:
        count += 1
        d = scale(kappa, solve_six(assemble(work, contacts, kappa), F))
        aim(work, contacts, d, rho)
        move(work, contacts, 1.0)
        y_new = mix(y, 1.0, d)
        F_new = evaluate(work, contacts, y_new, b)
        error_new = dot(F_new, F_new)
        at_0, at_1 = dot(F, d), dot(F_new, d)
        if at_1 > -0.3 * at_0 and error_new > 0.25 * best:  # too far, and no nearer either
            patience -= 1.0
            if patience == 0.0:
                break
            t = search(work, contacts, kappa, dot(mix(y, -1.0, b), d), dot(d, d), at_0, at_1)
            move(work, contacts, t)
            y_new = mix(y, t, d)
            F_new = evaluate(work, contacts, y_new, b)
            error_new = dot(F_new, F_new)
        y, F, error = y_new, F_new, error_new
        best = min(best, error)
    return y, error, count


@kernel
def free_dual(work: FloatArray, contacts: int, b: Six, kappa: float) -> Six:
    """Return the dual wrench of the program without cones."""
    H = scaled_identity(kappa)
    F = scale(-kappa, b)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            F = mix(F, kappa, combine(work, k, work[k, CENTRE], work[k, CENTRE + 1], work[k, CENTRE + 2]))
            H = add_outer(H, column(work, k, BLOCK))
            H = add_outer(H, column(work, k, BLOCK + 6))
            H = add_outer(H, column(work, k, BLOCK + 12))
    return solve_six(H, F)


@kernel
def follow_path(
    work: FloatArray, contacts: int, b: Six, kappa: float, tol: float, noise: float, limit: float,
    last: float, shrink: float, accuracy: float,
) -> tuple[Six, float, int]:  # fmt: skip
    """Solve for a large force weight first and bring it back in steps; returns what `newton` does.

    At most `limit` iterations in all and `last` in the last stage.
    """
    y = free_dual(work, contacts, b, kappa)
    count = 0
    while kappa > 1.0:
        stage = min(10.0, limit - count)
        y, _, used = newton(work, contacts, b, y, kappa, accuracy * dot(b, b), noise, stage, -1.0)
        count += used
        smaller = max(1.0, kappa * shrink)
        # the solution for the smaller weight if no contact changes its face
        y = times(assemble(work, contacts, kappa), y)
        y = scale(-smaller / kappa, solve_six(assemble(work, contacts, smaller), y))
        kappa = smaller
    y, error, used = newton(work, contacts, b, y, 1.0, tol, noise, min(last, limit - count), -1.0)
    return y, error, count + used


@kernel
def load(grasp_map: FloatArray, work: FloatArray, contacts: int) -> tuple[float, float]:
    """Fill B and c; return the squared Frobenius norm of B, and 0 or, for bad input, NaN."""
    total, check = 0.0, 0.0
    roots = contacts
    for k in range(contacts):
        st, sn = work[k, TANGENT], work[k, NORMAL]
        for i in range(3):
            side = 1 if i == 2 else 0
            wanted = work[k, PULL + side] * work[k, REFERENCE + i] + work[k, DRAG + side] * work[k, LAST + i]
            work[k, CENTRE + i] = wanted
            work[k, FORCE + i] = 0.0
            check += wanted * 0.0
        if work[k, HIGH] <= 0.0:
            continue
        for i in range(6):
            root = work[roots, ROOT + i]
            x = grasp_map[i, 3 * k] * (root * st)
            y = grasp_map[i, 3 * k + 1] * (root * st)
            z = grasp_map[i, 3 * k + 2] * (root * sn)
            work[k, BLOCK + i], work[k, BLOCK + 6 + i], work[k, BLOCK + 12 + i] = x, y, z
            total += x * x + y * y + z * z
    return total, check + total * 0.0


@kernel
def set_limits(work: FloatArray, low: FloatArray, high: FloatArray, on: BoolArray) -> int:
    """Set the normal bounds [N], zero for contacts that are off; return a contact with wrong bounds or -1."""
    for k in range(on.size):
        if not 0.0 <= low[k] <= high[k]:
            return k
    for k in range(on.size):
        work[k, FLOOR] = low[k] if on[k] else 0.0
        work[k, CEILING] = high[k] if on[k] else 0.0
        work[k, LOW] = work[k, FLOOR] / work[k, NORMAL]
        work[k, HIGH] = work[k, CEILING] / work[k, NORMAL]
    return -1


@kernel
def unload(work: FloatArray, contacts: int, forces: FloatArray) -> None:
    """Write the forces in newtons and remember them as the last command."""
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            forces[k, 0] = work[k, FORCE] * work[k, TANGENT]
            forces[k, 1] = work[k, FORCE + 1] * work[k, TANGENT]
            forces[k, 2] = min(max(work[k, FORCE + 2] * work[k, NORMAL], work[k, FLOOR]), work[k, CEILING])
        else:
            forces[k, 0] = forces[k, 1] = forces[k, 2] = 0.0
        work[k, LAST], work[k, LAST + 1], work[k, LAST + 2] = forces[k, 0], forces[k, 1], forces[k, 2]


@kernel
def hold(work: FloatArray, contacts: int, forces: FloatArray) -> None:
    """Write the last command, brought into today's cones; without one, the least normal forces."""
    keep = work[contacts + 1, HAS_LAST] > 0.0
    for k in range(contacts):
        x, y, z = (work[k, LAST], work[k, LAST + 1], work[k, LAST + 2]) if keep else (0.0, 0.0, 0.0)
        work[k, FORCE], work[k, FORCE + 1], work[k, FORCE + 2] = project_truncated(
            x / work[k, TANGENT],
            y / work[k, TANGENT],
            z / work[k, NORMAL],
            work[k, MU],
            work[k, LOW],
            work[k, HIGH],
        )
    unload(work, contacts, forces)


@inline_kernel
def weigh(wrench: FloatArray, work: FloatArray, contacts: int) -> Six:
    """Return b, the wanted wrench times the roots of its weights."""
    return (
        wrench[0] * work[contacts, ROOT], wrench[1] * work[contacts, ROOT + 1],
        wrench[2] * work[contacts, ROOT + 2], wrench[3] * work[contacts, ROOT + 3],
        wrench[4] * work[contacts, ROOT + 4], wrench[5] * work[contacts, ROOT + 5],
    )  # fmt: skip


@kernel
def distribute_wrench(grasp_map: FloatArray, wrench: FloatArray, work: FloatArray, forces: FloatArray) -> int:
    """Write the (n, 3) optimal forces [N] for a (6, 3n) grasp map and a (6,) wrench; return a code."""
    contacts = forces.shape[0]
    memory, results = contacts, contacts + 1
    b = weigh(wrench, work, contacts)
    norm, check = load(grasp_map, work, contacts)
    size = dot(b, b)
    if check + size * 0.0 != 0.0:
        hold(work, contacts, forces)
        work[results, ITERATIONS] = 0.0
        return INVALID
    tol, noise, limit = work[results, TOLERANCE] ** 2, ROUNDING * norm, work[results, LIMIT]
    y = column(work, memory, DUAL) if work[results, WARM] > 0.0 else free_dual(work, contacts, b, 1.0)
    place(work, contacts, y, 1.0)
    F = evaluate(work, contacts, y, b)
    error, count = dot(F, F), 0
    if error < FAR * size:
        y, error, count = newton(work, contacts, b, y, 1.0, tol, noise, limit, PATIENCE)
    start = max(1.0, PATH_START * norm)
    if not error <= max(tol, noise * spread(work, contacts)):
        y, error, used = follow_path(
            work, contacts, b, start, tol, noise, limit - count, PATH_LIMIT, PATH_STEP, PATH_TOLERANCE
        )
        count += used
    if not error <= max(tol, noise * spread(work, contacts)) and count < limit:
        left = limit - count
        y, error, used = follow_path(
            work, contacts, b, start, tol, noise, left, left, SMALL_STEP, TIGHT_TOLERANCE
        )
        count += used
    return finish(work, contacts, b, y, error, max(tol, noise * spread(work, contacts)), count, forces)


@kernel
def measure(work: FloatArray, contacts: int, missing: Six, error: float) -> float:
    """Write what the forces leave of the wrench and how far they may be from the optimum."""
    widest, results = 0.0, contacts + 1
    for k in range(contacts):
        widest = max(widest, work[k, TANGENT], work[k, NORMAL])
    left = dot(missing, missing)
    work[results, GAP] = 0.5 * error
    work[results, FORCE_ERROR] = widest * math.sqrt(error)
    work[results, WRENCH_ERROR] = math.sqrt(left)
    return left


@kernel
def remainder(work: FloatArray, contacts: int, b: Six) -> Six:
    """Return B f - b."""
    out = scale(-1.0, b)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            out = mix(out, 1.0, combine(work, k, work[k, FORCE], work[k, FORCE + 1], work[k, FORCE + 2]))
    return out


@kernel
def finish(
    work: FloatArray, contacts: int, b: Six, y: Six, error: float, tol: float, count: int, forces: FloatArray
) -> int:
    """Write forces, memory and results, and return the code."""
    memory, results = contacts, contacts + 1
    work[results, ITERATIONS] = count
    if not error < math.inf:
        work[results, WARM] = 0.0
        hold(work, contacts, forces)
        return INVALID
    work[memory, 0], work[memory, 1], work[memory, 2], work[memory, 3], work[memory, 4], work[memory, 5] = y
    work[results, WARM], work[results, HAS_LAST] = 1.0, 1.0
    unload(work, contacts, forces)
    left = measure(work, contacts, remainder(work, contacts, b), error)
    if error <= work[results, TOLERANCE] ** 2 or (error <= tol and error <= RELATIVE * left):
        return SOLVED
    return ALMOST if error <= 1e6 * tol else MAX_ITERATIONS
