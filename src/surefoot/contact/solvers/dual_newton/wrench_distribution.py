"""Force distribution in the six dimensions of the wrench: the dual Newton method on scalars in registers.

The program, after weights have been absorbed into the unknowns, is::

    min  1/2 ||B f - b||² + 1/2 ||f - c||²   over the truncated friction cones

Its dual has six unknowns y, whatever the number of contacts: f = Π(c + Bᵀ y), with the gradient
F(y) = y + B f - b. The duality gap at f is exactly 1/2 ||F||², and the distance from f to the optimum at most
||F||. Cold or warm, what is tried first is plain Newton; what resists goes down the path.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.projection import face
from surefoot.base.numerics.six import (
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
from surefoot.contact.solvers.dual_newton.distribution_memory import (
    ALMOST,
    BLOCK_X,
    BLOCK_Y,
    BLOCK_Z,
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
    project,
    remember,
    store,
    store_vector,
    unload,
    vector,
    weigh,
)
from surefoot.contact.solvers.dual_newton.method import Form, Path, Progress, Steps, descend, follow_path

Memory = tuple[FloatArray, int, Six, float]
"""The work space, its contacts, b, and the squared relative rounding error of F."""

# Counts are floats on purpose: Numba would compile a caller's integer constants into copies of a kernel.
# Tuning; what they change is the time of hard instances, never the answer.
STEPS = Steps(ahead=0.3, nearer=0.25, accuracy=0.1)
FAR = 0.3  # share of ||b||² at which the first residual sends an instance down the path
PATIENCE = 3.0  # line searches on the direct way before the path is taken
PATH_START = 0.002  # kappa at the start of the path, over the squared Frobenius norm of B
PATH_STEP = 0.05  # shrinkage of kappa from stage to stage; then, if that failed, ...
SMALL_STEP = 0.2
PATH_TOLERANCE = 1e-5  # of a stage: ||F||² over ||b||²; then, if that failed, ...
TIGHT_TOLERANCE = 1e-10
STAGE = 10.0  # iterations of a stage
PATH_LIMIT = 40.0  # iterations of the last stage before the path is taken again, carefully
RELATIVE = 1e-12  # duality gap over the objective that counts as solved where rounding stops the rest
ROUNDING = 1e-31  # square of the relative error of a residual in doubles
EXTRA, LESS_NOISE = 10.0, 0.01  # iterations beyond that, and the share of it at which they stop


@inline_kernel
def _pull_back(work: FloatArray, k: int, y: Six, rho: float) -> tuple[float, float, float]:
    """Return rho B_iᵀ y."""
    return (
        rho * dot(column(work, k, BLOCK_X), y),
        rho * dot(column(work, k, BLOCK_Y), y),
        rho * dot(column(work, k, BLOCK_Z), y),
    )


@inline_kernel
def _place(work: FloatArray, contacts: int, y: Six, kappa: float) -> None:
    """Set the points to c + Bᵀ y / kappa."""
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            c, move = vector(work, k, CENTRE), _pull_back(work, k, y, 1.0 / kappa)
            store_vector(work, k, POINT, (c[0] + move[0], c[1] + move[1], c[2] + move[2]))


@inline_kernel
def _ahead(work: FloatArray, k: int, t: float) -> tuple[float, float, float]:
    """Return the contact's point, t of the way along STEP."""
    x, y, z = vector(work, k, OLD)
    p, q, r = vector(work, k, STEP)
    return x + t * p, y + t * q, z + t * r


@inline_kernel
def _evaluate(work: FloatArray, contacts: int, y: Six, b: Six) -> Six:
    """Set the forces from the points and return the gradient F = y + B f - b."""
    F = mix(y, -1.0, b)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            f = project(work, k, vector(work, k, POINT))
            store_vector(work, k, FORCE, f)
            F = mix(F, 1.0, combine(work, k, f))
    return F


@inline_kernel
def _sum_outer(H: Lower, work: FloatArray, first: int, end: int, at: int) -> Lower:
    """Return H + the sum of v vᵀ over the vectors v at one place of the rows from `first` to `end`."""
    for k in range(first, end):
        H = add_outer(H, column(work, k, at))
    return H


@inline_kernel
def _assemble(work: FloatArray, contacts: int, kappa: float) -> Lower:
    """Return kappa I + Σ B_i Π_i' B_iᵀ at the points, Π_i' the projection's Jacobian.

    The vectors are gathered first and summed in a loop without branches, which is twice as fast.
    """
    spare = contacts + 2
    end = spare
    for k in range(contacts):
        if work[k, HIGH] <= 0.0:
            continue
        mu, z = work[k, MU], work[k, FORCE + 2]
        sticks, free, p, q, across, along = face(
            work[k, POINT], work[k, POINT + 1], z, mu, work[k, LOW], work[k, HIGH]
        )
        # inside its disc: Π' is the identity of the tangents, and of the normal where no bound holds
        if sticks:
            store(work, end, 0, column(work, k, BLOCK_X))
            store(work, end + 1, 0, column(work, k, BLOCK_Y))
            end += 2
            if free:
                store(work, end, 0, column(work, k, BLOCK_Z))
                end += 1
            continue
        # on the cone: e⊥, shrunk by the ratio of the radii, and the generator (mu e, 1): v vᵀ each
        if across > 0.0:
            store(work, end, 0, combine(work, k, (-q * across, p * across, 0.0)))
            end += 1
        if along > 0.0:
            store(work, end, 0, combine(work, k, (p * mu * along, q * mu * along, along)))
            end += 1
    return _sum_outer(scaled_identity(kappa), work, spare, end, 0)


@inline_kernel
def _enter(memory: Memory, y: Six, kappa: float) -> tuple[Six, float]:
    """Place the points and evaluate; see `method.Form`, here and below."""
    work, contacts, b, _ = memory
    _place(work, contacts, y, kappa)
    F = _evaluate(work, contacts, y, b)
    return F, dot(F, F)


@inline_kernel
def _direction(memory: Memory, F: Six, kappa: float) -> tuple[Six, float]:
    work, contacts, _, _ = memory
    d = scale(kappa, solve_six(_assemble(work, contacts, kappa), F))
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            store_vector(work, k, OLD, vector(work, k, POINT))
            store_vector(work, k, STEP, _pull_back(work, k, d, 1.0 / kappa))
    return d, dot(F, d)


@inline_kernel
def _take(
    memory: Memory, y: Six, d: Six, kappa: float, t: float, before: float
) -> tuple[Six, Six, float, float]:
    work, contacts, b, _ = memory
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            store_vector(work, k, POINT, _ahead(work, k, t))
    # y is moved from the last trial (`before`), the points from where the step began
    y = mix(y, t - before, d)
    F = _evaluate(work, contacts, y, b)
    return y, F, dot(F, F), dot(F, d)


@inline_kernel
def _line(memory: Memory, y: Six, d: Six) -> tuple[float, float]:
    return dot(mix(y, -1.0, memory[2]), d), dot(d, d)


@inline_kernel
def _derivative(line: tuple[Memory, float, float, float], t: float) -> float:
    memory, kappa, ahead, curve = line
    work, contacts, _, _ = memory
    total = 0.0
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            p, q, r = project(work, k, _ahead(work, k, t))
            total += p * work[k, STEP] + q * work[k, STEP + 1] + r * work[k, STEP + 2]
    return kappa * total + ahead + (t - 1.0) * curve


@inline_kernel
def _spread(work: FloatArray, contacts: int) -> float:
    """Return Σ ||point||², on which the rounding error of F depends."""
    total = 0.0
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            total += work[k, POINT] ** 2 + work[k, POINT + 1] ** 2 + work[k, POINT + 2] ** 2
    return total


@inline_kernel
def _rounding(memory: Memory, progress: Progress, tol: float) -> bool:
    work, contacts, _, noise = memory
    return progress.error <= noise * _spread(work, contacts)


@inline_kernel
def _predict(memory: Memory, y: Six, kappa: float, smaller: float) -> Six:
    """Return the solution for the smaller weight if no contact changes its face."""
    work, contacts, _, _ = memory
    y = times(_assemble(work, contacts, kappa), y)
    return scale(-smaller / kappa, solve_six(_assemble(work, contacts, smaller), y))


FORM = Form(_enter, _direction, _take, _line, _derivative, _rounding, _predict)


@kernel
def _newton(
    memory: Memory, y: Six, F: Six, error: float, kappa: float, tol: float, limit: float, patience: float
) -> tuple[Six, Six, float, int]:
    return descend(FORM, STEPS, memory, y, F, error, kappa, tol, limit, patience)


@kernel
def _free_dual(work: FloatArray, contacts: int, b: Six, kappa: float) -> Six:
    """Return the dual wrench of the program without cones."""
    F, H = scale(-kappa, b), scaled_identity(kappa)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            F = mix(F, kappa, combine(work, k, vector(work, k, CENTRE)))
    for i in range(3):
        H = _sum_outer(H, work, 0, contacts, BLOCK_X + 6 * i)
    return solve_six(H, F)


@kernel
def _follow_path(memory: Memory, path: Path, tol: float) -> tuple[Six, Six, float, int]:
    work, contacts, b, _ = memory
    return follow_path(FORM, _newton, memory, _free_dual(work, contacts, b, path.start), path, tol)


@kernel
def distribute_wrench(grasp_map: FloatArray, wrench: FloatArray, work: FloatArray, forces: FloatArray) -> int:
    """Write the (n, 3) optimal forces [N] for a (6, 3n) grasp map and a (6,) wrench; return a code."""
    contacts = forces.shape[0]
    results = contacts + 1
    b = weigh(wrench, work, contacts)
    norm, check = load(grasp_map, work, contacts)
    size = dot(b, b)
    # NaN and infinities survive a product with zero: one comparison refuses all bad input
    if check + size * 0.0 != 0.0:
        hold(work, contacts, forces)
        work[results, ITERATIONS] = 0.0
        return INVALID
    tol, noise, limit = work[results, TOLERANCE] ** 2, ROUNDING * norm, work[results, LIMIT]
    # where no cone was active the program without cones is the best guess, cold or warm
    guess = work[results, WARM] > 0.0 and work[results, INSIDE] == 0.0
    y = predict(work, contacts) if guess else _free_dual(work, contacts, b, 1.0)
    memory = work, contacts, b, noise
    F, error = _enter(memory, y, 1.0)
    count = 0
    # a first residual near ||b||² itself means an optimum far from c, where Newton alone zigzags (see
    # `method`): those go down the path at once
    if tol < error < FAR * size:
        y, F, error, count = _newton(memory, y, F, error, 1.0, tol, limit, PATIENCE)
    if not error <= tol:
        y, F, error, count = _persist(memory, y, F, error, norm, count)
    return _finish(memory, y, F, error, count, forces)


@kernel
def _persist(
    memory: Memory, y: Six, F: Six, error: float, norm: float, count: int
) -> tuple[Six, Six, float, int]:
    """Return what `_newton` does, for an instance that it alone has not solved in `count` iterations.

    Goes down the path unless only rounding is left. The bound on that is a cautious one: if the gap is not
    small relative to the objective either, a few more steps mostly make it so.
    """
    work, contacts, b, noise = memory
    results, start, size = contacts + 1, max(1.0, PATH_START * norm), dot(b, b)
    tol, limit = work[results, TOLERANCE] ** 2, work[results, LIMIT]
    if not error <= noise * _spread(work, contacts):
        # quickly first: few stages, loosely solved
        path = Path(start, 1.0, PATH_STEP, PATH_TOLERANCE * size, STAGE, limit - count, PATH_LIMIT)
        y, F, error, used = _follow_path(memory, path, tol)
        count += used
    if not error <= max(tol, noise * _spread(work, contacts)) and count < limit:
        # that failed: shorter stages solved tightly, so that each prediction starts on the right faces
        path = Path(start, 1.0, SMALL_STEP, TIGHT_TOLERANCE * size, STAGE, limit - count, limit - count)
        y, F, error, used = _follow_path(memory, path, tol)
        count += used
    # F = y + B f - b: what is left of the wrench is the part that is not y
    missing = mix(F, -1.0, y)
    if error > max(tol, RELATIVE * dot(missing, missing)) and count < limit:
        memory, extra = (work, contacts, b, LESS_NOISE * noise), min(EXTRA, limit - count)
        y, F, error, used = _newton(memory, y, F, error, 1.0, tol, extra, -1.0)
        count += used
    return y, F, error, count


@inline_kernel
def _finish(memory: Memory, y: Six, F: Six, error: float, count: int, forces: FloatArray) -> int:
    """Write forces, memory and results, and return the code."""
    work, contacts, _, noise = memory
    results = contacts + 1
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
    # solved up to rounding, and the gap small beside the objective: there is no more to be had in doubles
    floor = max(tol, noise * _spread(work, contacts))
    if error <= floor and error <= RELATIVE * left:
        return SOLVED
    return ALMOST if error <= 1e6 * floor else MAX_ITERATIONS
