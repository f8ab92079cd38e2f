"""Least normal force of a wrench, and the nearest wrench that a sole gives, by the steps of `sole_program`.

Both are told from certificates alone: forces at the corners give an upper bound, a velocity that no corner
resists a lower one.
"""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.contact.cones.sole_program import KEPT, S, X, advance, begin, give, lacking, rest_of, see

GAP = 1e-12
"""Gap between the certificates that solves the program [-], as a share of the wrench: near rounding."""
ENOUGH, DECIDES = 1e-9, 1e-10
"""Gaps that count as solved where rounding stops the steps [-], for a number and for a wrench that is as near
to its level; what is left, 0.6 and 0.2 of 1,000 random wrenches, goes to `sole_digits`."""
MOST_STEPS = 60
"""Newton steps at most [-]: 7 to 12 are usual."""
INSIDE, OUTSIDE, SOLVED, STALLED = 0, 1, 2, 3
"""Outcomes: forces within the level, a velocity that proves there are none, the gap closed, none of these."""
PATIENCE = 2
"""Steps in a row that do not halve the gap and end the search [-]."""
LATE = 1e-6
"""Gap below which the best certificates are set aside [-]: steps from there on may lose by rounding."""


@inline_kernel
def _keep(work: FloatArray, source: int, target: int) -> None:
    """Copy the corners' forces from one place of their rows to another."""
    for i in range(work.shape[0]):
        for j in range(4):
            work[i, target + j] = work[i, source + j]


@inline_kernel
def _to_border(work: FloatArray) -> tuple[float, float]:
    """Return what v[:5] may be divided by, and an even pressure's normal force that the forces can spare."""
    k = work.shape[0]
    reach, spare = 0.0, 1e300
    for i in range(k):
        slide = math.sqrt(work[i, S + 1] ** 2 + work[i, S + 2] ** 2 + work[i, S + 3] ** 2)
        reach = max(reach, slide + 1.0 - work[i, S])
        friction = math.sqrt(work[i, X + 1] ** 2 + work[i, X + 2] ** 2 + work[i, X + 3] ** 2)
        spare = min(spare, work[i, X] - friction)
    return reach, k * spare


@kernel
def need(
    table: FloatArray, start: FloatArray, radius: float, W: FloatArray, level: float, v: FloatArray,
    work: FloatArray, space: FloatArray,
) -> tuple[int, float, float]:  # fmt: skip
    """Bound the least total normal force for W[:5], W (6,) of norm one, from both sides.

    Forces that miss the wrench by rounding count with the pressure that brings what is missing into the
    cones. `space` (9, 6) is filled.

    Returns
    -------
    tuple[int, float, float]
        The outcome, and bounds from below (v is its proof) and above (the forces in `work` are): OUTSIDE or
        INSIDE as soon as one of them is beyond `level`; NaN as level goes on to `SOLVED`.
    """
    k = table.shape[0]
    enough = begin(table, start, 1.0, radius, W, v, work)
    if enough <= level:
        return INSIDE, 0.0, enough
    rest, best = space[6], space[8]
    last, lowest, highest, kept, idle = 1e300, -1e300, 1e300, False, 0
    for _ in range(MOST_STEPS):
        low, high = 0.0, 0.0
        for j in range(5):
            low -= W[j] * v[j]
        for i in range(k):
            high += work[i, X]
        if low > level:
            return OUTSIDE, low, high
        if low < level < high:  # farther along: the border is nearer than the iterates say
            reach, spare = _to_border(work)
            if low > level * reach:
                for j in range(5):
                    v[j] /= reach
                return OUTSIDE, low / reach, high
            if high - spare <= level:
                for i in range(k):
                    work[i, X] -= spare / k
                high -= spare
        if high <= level or high - low < LATE:
            rest_of(table, 1.0, radius, 0.0, W, v, work, rest)
            high += lacking(start, rest, k)
            if high <= level:
                return INSIDE, low, high
            if low > lowest:
                lowest = low
                for j in range(6):
                    best[j] = v[j]
            if high < highest:
                highest = high
                _keep(work, X, KEPT)
            gap, kept = highest - lowest, True
            idle = idle + 1 if gap > 0.5 * last else 0
            if gap <= GAP or idle == PATIENCE:
                break
            last = gap
        if not advance(table, 1.0, radius, 5, W, v, work, space):
            break
    if not kept:
        return STALLED, low, high
    for j in range(6):
        v[j] = best[j]
    _keep(work, KEPT, X)
    enough = ENOUGH if math.isnan(level) else DECIDES
    return (SOLVED if highest - lowest <= enough else STALLED), lowest, highest


@kernel
def nearest(
    table: FloatArray, mu: float, radius: float, W: FloatArray, v: FloatArray, work: FloatArray,
    space: FloatArray, out: FloatArray,
) -> float:  # fmt: skip
    """Set out (6,) to the wrench of the cone that is nearest to W, of norm one; return the gap that is left.

    ||out - nearest||² <= twice the gap: the program is strongly convex.
    """
    k = table.shape[0]
    # an equal pressure that is large beside the wrench, and v = what it lacks: feasible on both sides
    press = 4.0 * (1.0 + mu * (1.0 + radius))
    for j in range(6):
        v[j] = -W[j]
    v[5] += press
    for i in range(k):
        for j in range(4):
            work[i, X + j] = 0.0
        work[i, X] = press / k
        see(table, i, mu, radius, v, work, S)
    last = 1e300
    for _ in range(MOST_STEPS):
        gap = 0.0
        for i in range(k):
            for j in range(4):
                gap += work[i, X + j] * work[i, S + j]
        if gap <= GAP * GAP or (gap < GAP and gap > 0.5 * last):
            last = gap
            break
        last = gap
        if not advance(table, mu, radius, 6, W, v, work, space):
            break
    for j in range(6):
        out[j] = 0.0
    for i in range(k):
        give(table, i, mu, radius, work, X, out)
    return last
