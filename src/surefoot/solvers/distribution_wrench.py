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

from surefoot.arrays import FloatArray
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
from surefoot.solvers.distribution_work import (
    ALMOST,
    BLOCK,
    CENTRE,
    FORCE,
    HIGH,
    INSIDE,
    INVALID,
    ITERATIONS,
    LIMIT,
    LOW,
    MAX_ITERATIONS,
    MU,
    OLD,
    POINT,
    SOLVED,
    STEP,
    TOLERANCE,
    WARM,
    column,
    combine,
    hold,
    load,
    measure,
    predict,
    remember,
    store,
    unload,
    weigh,
)

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
EXTRA, LESS_NOISE = 10.0, 0.01  # iterations beyond that, and the share of it at which they stop


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
def sum_outer(H: Lower, work: FloatArray, first: int, end: int, at: int) -> Lower:
    """Return H + the sum of v vᵀ over the vectors v at one place of the rows from `first` to `end`."""
    for k in range(first, end):
        H = add_outer(H, column(work, k, at))
    return H


@inline_kernel
def assemble(work: FloatArray, contacts: int, kappa: float) -> Lower:
    """Return kappa I + Σ B_i P_i' B_iᵀ at the points, P_i' the projection's Jacobian.

    On the cone's side the Jacobian has rank two: along the side, and sideways by mu f_z / ||point_t||.
    The vectors are gathered first and summed in a loop without branches, which is twice as fast.
    """
    spare = contacts + 2
    end = spare
    for k in range(contacts):
        if work[k, HIGH] <= 0.0:
            continue
        u, v, mu, z = work[k, POINT], work[k, POINT + 1], work[k, MU], work[k, FORCE + 2]
        limit = mu * z
        free = work[k, LOW] < z < work[k, HIGH]
        t = math.sqrt(u * u + v * v)
        if t <= limit and limit > 0.0:
            store(work, end, 0, column(work, k, BLOCK))
            store(work, end + 1, 0, column(work, k, BLOCK + 6))
            end += 2
            if free:
                store(work, end, 0, column(work, k, BLOCK + 12))
                end += 1
        elif z > 0.0:
            p, q = (u / t, v / t) if t > 0.0 else (0.0, 0.0)
            if limit > 0.0:
                s = math.sqrt(limit / t)
                store(work, end, 0, combine(work, k, -q * s, p * s, 0.0))
                end += 1
            if free:
                s = 1.0 / math.sqrt(1.0 + mu * mu)
                store(work, end, 0, combine(work, k, p * mu * s, q * mu * s, s))
                end += 1
    return sum_outer(scaled_identity(kappa), work, spare, end, 0)


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
    work: FloatArray, contacts: int, b: Six, start: Six, F: Six, kappa: float, tol: float, noise: float,
    limit: float, patience: float,
) -> tuple[Six, Six, int]:  # fmt: skip
    """Return the dual wrench, F there and the iterations, for a force weight kappa times larger.

    From a start at which the points and F are known. Stops at ||F||² <= tol, at the rounding error, after
    `limit` iterations or when a full step has failed `patience` times.
    """
    y, rho = start, 1.0 / kappa
    error = dot(F, F)
    best, count = error, 0
    while error > tol and error > noise * spread(work, contacts) and count < limit:
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
            if patience == 0.0:  # give up where the step began
                move(work, contacts, 0.0)
                F = evaluate(work, contacts, y, b)
                break
            t = search(work, contacts, kappa, dot(mix(y, -1.0, b), d), dot(d, d), at_0, at_1)
            move(work, contacts, t)
            y_new = mix(y, t, d)
            F_new = evaluate(work, contacts, y_new, b)
            error_new = dot(F_new, F_new)
        y, F, error = y_new, F_new, error_new
        best = min(best, error)
    return y, F, count


@kernel
def free_dual(work: FloatArray, contacts: int, b: Six, kappa: float) -> Six:
    """Return the dual wrench of the program without cones."""
    F, H = scale(-kappa, b), scaled_identity(kappa)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            F = mix(F, kappa, combine(work, k, work[k, CENTRE], work[k, CENTRE + 1], work[k, CENTRE + 2]))
    for i in range(3):
        H = sum_outer(H, work, 0, contacts, BLOCK + 6 * i)
    return solve_six(H, F)


@kernel
def follow_path(
    work: FloatArray, contacts: int, b: Six, kappa: float, tol: float, noise: float, limit: float,
    last: float, shrink: float, accuracy: float,
) -> tuple[Six, Six, int]:  # fmt: skip
    """Solve for a large force weight first and bring it back in steps; returns what `newton` does.

    At most `limit` iterations in all and `last` in the last stage.
    """
    y, count, enough = free_dual(work, contacts, b, kappa), 0, accuracy * dot(b, b)
    while True:
        place(work, contacts, y, 1.0 / kappa)
        F = evaluate(work, contacts, y, b)
        if kappa <= 1.0:
            break
        stage = min(10.0, limit - count)
        y, F, used = newton(work, contacts, b, y, F, kappa, enough, noise, stage, -1.0)
        count += used
        smaller = max(1.0, kappa * shrink)
        # the solution for the smaller weight if no contact changes its face
        y = times(assemble(work, contacts, kappa), y)
        y = scale(-smaller / kappa, solve_six(assemble(work, contacts, smaller), y))
        kappa = smaller
    y, F, used = newton(work, contacts, b, y, F, 1.0, tol, noise, min(last, limit - count), -1.0)
    return y, F, count + used


@kernel
def distribute_wrench(grasp_map: FloatArray, wrench: FloatArray, work: FloatArray, forces: FloatArray) -> int:
    """Write the (n, 3) optimal forces [N] for a (6, 3n) grasp map and a (6,) wrench; return a code."""
    contacts = forces.shape[0]
    results = contacts + 1
    b = weigh(wrench, work, contacts)
    norm, check = load(grasp_map, work, contacts)
    size = dot(b, b)
    if check + size * 0.0 != 0.0:
        hold(work, contacts, forces)
        work[results, ITERATIONS] = 0.0
        return INVALID
    tol, noise, limit = work[results, TOLERANCE] ** 2, ROUNDING * norm, work[results, LIMIT]
    # where no cone was active the program without cones is the best guess, cold or warm
    guess = work[results, WARM] > 0.0 and work[results, INSIDE] == 0.0
    y = predict(work, contacts) if guess else free_dual(work, contacts, b, 1.0)
    place(work, contacts, y, 1.0)
    F, count = evaluate(work, contacts, y, b), 0
    if tol < dot(F, F) < FAR * size:
        y, F, count = newton(work, contacts, b, y, F, 1.0, tol, noise, limit, PATIENCE)
    if not dot(F, F) <= tol:
        y, F, count = persist(work, contacts, b, y, F, norm, count)
    return finish(work, contacts, y, F, noise, count, forces)


@kernel
def persist(
    work: FloatArray, contacts: int, b: Six, y: Six, F: Six, norm: float, count: int
) -> tuple[Six, Six, int]:  # fmt: skip
    """Return what `newton` does, for an instance that it alone has not solved in `count` iterations.

    Goes down the path unless only rounding is left. The bound on that is a cautious one: if the gap is not
    small relative to the objective either, a few more steps mostly make it so.
    """
    results, start = contacts + 1, max(1.0, PATH_START * norm)
    tol, noise, limit = work[results, TOLERANCE] ** 2, ROUNDING * norm, work[results, LIMIT]
    if not dot(F, F) <= noise * spread(work, contacts):
        y, F, used = follow_path(
            work, contacts, b, start, tol, noise, limit - count, PATH_LIMIT, PATH_STEP, PATH_TOLERANCE
        )
        count += used
    if not dot(F, F) <= max(tol, noise * spread(work, contacts)) and count < limit:
        left = limit - count
        y, F, used = follow_path(
            work, contacts, b, start, tol, noise, left, left, SMALL_STEP, TIGHT_TOLERANCE
        )
        count += used
    missing = mix(F, -1.0, y)
    if dot(F, F) > max(tol, RELATIVE * dot(missing, missing)) and count < limit:
        extra = min(EXTRA, limit - count)
        y, F, used = newton(work, contacts, b, y, F, 1.0, tol, LESS_NOISE * noise, extra, -1.0)
        count += used
    return y, F, count


@inline_kernel
def finish(
    work: FloatArray, contacts: int, y: Six, F: Six, noise: float, count: int, forces: FloatArray
) -> int:
    """Write forces, memory and results, and return the code."""
    results, error = contacts + 1, dot(F, F)
    work[results, ITERATIONS] = count
    if not error < math.inf:
        work[results, WARM] = 0.0
        hold(work, contacts, forces)
        return INVALID
    remember(work, contacts, y)
    unload(work, contacts, forces)
    left = measure(work, contacts, mix(F, -1.0, y), error)
    tol = work[results, TOLERANCE] ** 2
    if error <= tol:
        return SOLVED
    floor = max(tol, noise * spread(work, contacts))
    if error <= floor and error <= RELATIVE * left:
        return SOLVED
    return ALMOST if error <= 1e6 * floor else MAX_ITERATIONS
