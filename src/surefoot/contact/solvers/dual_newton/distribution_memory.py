"""Work space of the compiled force distribution: its layout, and what goes in and comes out.

Everything that lasts from one call to the next is in one array, since every array that a kernel is given
costs a call some 30 ns.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.projection import project_truncated
from surefoot.base.numerics.six import Six, dot, mix, scale
from surefoot.base.numerics.vectors import Three

# `work` has one row per contact ...
MU, LOW, HIGH = 0, 1, 2  # the cone, in scaled units; HIGH = 0 switches the contact off
TANGENT, NORMAL = 3, 4  # newtons per scaled unit
CENTRE = 5  # c, 3 numbers
BLOCK = 8  # the contact's part of B: three columns of six, ...
BLOCK_X, BLOCK_Y, BLOCK_Z = BLOCK, BLOCK + 6, BLOCK + 12  # ... one for each component of its force
POINT = 26  # c + Bᵀ y, 3 numbers
OLD = 29  # the points before a step
STEP = 32  # how far a full Newton step moves them
FORCE = 35  # f, 3 numbers
FLOOR, CEILING = 38, 39  # normal bounds [N]
LAST = 40  # the last command [N], 3 numbers
REFERENCE = 43  # wanted force [N], 3 numbers
PULL, DRAG = 46, 48  # what the reference and the last command give to c: tangential and normal [1/N]
WIDTH = 50
# ... one with memory: the dual wrench, roots of the wrench weights, the dual wrench's last change ...
DUAL, ROOT, CHANGE = 0, 6, 12
# ... one with settings and results ...
WARM, TOLERANCE, LIMIT, HAS_LAST, ITERATIONS, FORCE_ERROR, WRENCH_ERROR = 0, 1, 2, 3, 4, 5, 6
ROW_VIOLATION, ROWS_WARM = 7, 8  # see `rows`
TREND, INSIDE = 9, 10  # whether CHANGE foretells the next one, whether no cone or bound was active
# ... and three per contact for vectors whose outer products are summed.

SOLVED, ALMOST, MAX_ITERATIONS, INVALID, INFEASIBLE = 0, 1, 2, 3, 4

TREND_HELPS = 0.25  # share of a squared change that the one before may have left to be foretold


def new_work(contacts: int) -> FloatArray:
    """Return the (4n + 2, WIDTH) work space of n contacts, all off; nothing is known of any forces."""
    work = np.zeros((4 * contacts + 2, WIDTH))
    work[contacts + 1, [FORCE_ERROR, WRENCH_ERROR, ROW_VIOLATION]] = math.inf
    return work


@inline_kernel
def column(work: FloatArray, k: int, at: int) -> Six:
    """Return the six numbers of the work space (4n + 2, WIDTH) from column `at` of row k on."""
    return (
        work[k, at], work[k, at + 1], work[k, at + 2],
        work[k, at + 3], work[k, at + 4], work[k, at + 5],
    )  # fmt: skip


@inline_kernel
def store(work: FloatArray, k: int, at: int, y: Six) -> None:
    """Write six numbers into row k of the work space (4n + 2, WIDTH), from column `at` on."""
    work[k, at], work[k, at + 1], work[k, at + 2] = y[0], y[1], y[2]
    work[k, at + 3], work[k, at + 4], work[k, at + 5] = y[3], y[4], y[5]


@inline_kernel
def vector(work: FloatArray, k: int, at: int) -> Three:
    """Return the three numbers of the work space (4n + 2, WIDTH) from column `at` of row k on."""
    return work[k, at], work[k, at + 1], work[k, at + 2]


@inline_kernel
def store_vector(work: FloatArray, k: int, at: int, v: Three) -> None:
    """Write three numbers into row k of the work space (4n + 2, WIDTH), from column `at` on."""
    work[k, at], work[k, at + 1], work[k, at + 2] = v


@inline_kernel
def combine(work: FloatArray, k: int, f: Three) -> Six:
    """Return the weighted wrench B_k f (6,) of contact k, f (3,) in scaled units."""
    x, y, z = column(work, k, BLOCK_X), column(work, k, BLOCK_Y), column(work, k, BLOCK_Z)
    return mix(mix(scale(f[0], x), f[1], y), f[2], z)


@inline_kernel
def project(work: FloatArray, k: int, point: Three) -> Three:
    """Return the point (3,) of contact k's truncated cone nearest to a point (3,), in its scaled units."""
    return project_truncated(point[0], point[1], point[2], work[k, MU], work[k, LOW], work[k, HIGH])


@inline_kernel
def load(grasp_map: FloatArray, work: FloatArray, contacts: int) -> tuple[float, float]:
    """Fill B and c from a (6, 3n) grasp map; return ||B||² (Frobenius), and 0 or, for bad input, NaN.

    With forces in units of 1 / sqrt(weight) and the wrench times the roots of its weights, both quadratic
    terms of the program have the weight one: B = √W A units, c = (pull f_ref + drag f_last).
    """
    total, check = 0.0, 0.0
    roots = contacts
    for k in range(contacts):
        st, sn = work[k, TANGENT], work[k, NORMAL]
        for i in range(3):
            side = 1 if i == 2 else 0
            wanted = work[k, PULL + side] * work[k, REFERENCE + i] + work[k, DRAG + side] * work[k, LAST + i]
            work[k, CENTRE + i] = wanted
            work[k, FORCE + i] = 0.0
            # zero, or NaN for a wanted force that is not finite
            check += wanted * 0.0
        if work[k, HIGH] <= 0.0:
            for i in range(18):
                work[k, BLOCK + i] = 0.0
            # a column that nothing is multiplied by may still be what a broken sensor left
            for i in range(6):
                for j in range(3):
                    check += grasp_map[i, 3 * k + j] * 0.0
            continue
        for i in range(6):
            root = work[roots, ROOT + i]
            x = grasp_map[i, 3 * k] * (root * st)
            y = grasp_map[i, 3 * k + 1] * (root * st)
            z = grasp_map[i, 3 * k + 2] * (root * sn)
            work[k, BLOCK_X + i], work[k, BLOCK_Y + i], work[k, BLOCK_Z + i] = x, y, z
            total += x * x + y * y + z * z
    return total, check + total * 0.0


@kernel
def set_limits(work: FloatArray, low: FloatArray, high: FloatArray, on: BoolArray) -> int:
    """Set (n,) normal bounds [N], zero for contacts that are off; return one with wrong bounds, or -1."""
    for k in range(on.size):
        if not 0.0 <= low[k] <= high[k]:
            return k
    for k in range(on.size):
        work[k, FLOOR] = low[k] if on[k] else 0.0
        work[k, CEILING] = high[k] if on[k] else 0.0
        work[k, LOW] = work[k, FLOOR] / work[k, NORMAL]
        work[k, HIGH] = work[k, CEILING] / work[k, NORMAL]
    work[on.size + 1, TREND] = 0.0
    return -1


@inline_kernel
def unload(work: FloatArray, contacts: int, forces: FloatArray) -> None:
    """Write the (n, 3) forces [N], contact frames, and remember them as the last command."""
    for k in range(contacts):
        x = y = z = 0.0
        if work[k, HIGH] > 0.0:
            x, y, z = vector(work, k, FORCE)
            x, y, z = x * work[k, TANGENT], y * work[k, TANGENT], z * work[k, NORMAL]
            # scaling there and back rounds: bounds [N] are kept to the digit
            z = min(max(z, work[k, FLOOR]), work[k, CEILING])
        forces[k, 0], forces[k, 1], forces[k, 2] = x, y, z
        store_vector(work, k, LAST, (x, y, z))


@kernel
def hold(work: FloatArray, contacts: int, forces: FloatArray) -> None:
    """Write the last command (n, 3) [N], brought into today's cones; without one, the least normal forces.

    How far that is from an optimum is unknown, and said to be infinite.
    """
    results = contacts + 1
    work[results, FORCE_ERROR] = work[results, WRENCH_ERROR] = math.inf
    work[results, ROW_VIOLATION] = math.inf
    keep = work[contacts + 1, HAS_LAST] > 0.0
    for k in range(contacts):
        x, y, z = vector(work, k, LAST) if keep else (0.0, 0.0, 0.0)
        # friction or bounds may have changed since: the old command is projected onto what is admissible now
        x, y, z = x / work[k, TANGENT], y / work[k, TANGENT], z / work[k, NORMAL]
        store_vector(work, k, FORCE, project(work, k, (x, y, z)))
    unload(work, contacts, forces)


@inline_kernel
def weigh(wrench: FloatArray, work: FloatArray, contacts: int) -> Six:
    """Return b = √W w, the wanted wrench (6,) [N, N·m] times the roots of its weights."""
    return (
        wrench[0] * work[contacts, ROOT], wrench[1] * work[contacts, ROOT + 1],
        wrench[2] * work[contacts, ROOT + 2], wrench[3] * work[contacts, ROOT + 3],
        wrench[4] * work[contacts, ROOT + 4], wrench[5] * work[contacts, ROOT + 5],
    )  # fmt: skip


@inline_kernel
def measure(work: FloatArray, contacts: int, missing: Six, error: float) -> float:
    """Write what the forces leave of the wrench, and how far from the optimum; return ||B f - b||².

    The work space is (4n + 2, WIDTH). `missing` is B f - b, `error` ||F||²: the duality gap is ½ ||F||², and
    by strong convexity (weight one in scaled units) ||f - f*|| <= ||F||, in newtons at most the widest unit
    times that.
    """
    widest, results = 0.0, contacts + 1
    for k in range(contacts):
        widest = max(widest, work[k, TANGENT], work[k, NORMAL])
    left = dot(missing, missing)
    work[results, FORCE_ERROR] = widest * math.sqrt(error)
    work[results, WRENCH_ERROR] = math.sqrt(left)
    return left


@kernel
def remainder(work: FloatArray, contacts: int, b: Six) -> Six:
    """Return B f - b (6,), weighted."""
    out = scale(-1.0, b)
    for k in range(contacts):
        if work[k, HIGH] > 0.0:
            out = mix(out, 1.0, combine(work, k, vector(work, k, FORCE)))
    return out


@inline_kernel
def _inside(work: FloatArray, contacts: int) -> bool:
    """Tell whether every point lies within its cone and bounds."""
    for k in range(contacts):
        if work[k, HIGH] > 0.0 and vector(work, k, FORCE) != vector(work, k, POINT):
            return False
    return True


@inline_kernel
def predict(work: FloatArray, contacts: int) -> Six:
    """Return the last dual wrench (6,), moved on by its last change if such a guess has just proved good."""
    last = column(work, contacts, DUAL)
    if work[contacts + 1, TREND] > 0.0:
        return mix(last, 1.0, column(work, contacts, CHANGE))
    return last


@inline_kernel
def remember(work: FloatArray, contacts: int, y: Six) -> None:
    """Keep the dual wrench (6,) and its change; find out whether the one before would have foretold it."""
    results = contacts + 1
    change, surprise = scale(0.0, y), scale(0.0, y)
    if work[results, WARM] > 0.0:
        change = mix(y, -1.0, column(work, contacts, DUAL))
        surprise = mix(change, -1.0, column(work, contacts, CHANGE))
    helps = dot(surprise, surprise) < TREND_HELPS * dot(change, change)
    store(work, contacts, DUAL, y)
    store(work, contacts, CHANGE, change)
    work[results, WARM], work[results, HAS_LAST] = 1.0, 1.0
    work[results, TREND] = 1.0 if helps else 0.0
    work[results, INSIDE] = 1.0 if _inside(work, contacts) else 0.0
