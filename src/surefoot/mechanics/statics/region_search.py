"""From a stance's equations to polygons: the interior that the search needs, and the gap of what it found.

Where the equations leave the forces room inside their cones, one search gives both polygons. Where they
hardly do (friction at its very limit, contacts that cannot take part), the cones are widened by a hair, the
band of a verdict: the inner polygon then has forces that a verdict would call possible, and the outer one
leaves none out. Half-planes from cones widened by more, which rounding troubles less, are added where they
help.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.orthogonal import coordinates, orthonormal_rows
from surefoot.mechanics.statics.limits import Question, equations
from surefoot.mechanics.statics.margin import (
    BAND,
    ENDLESS,
    FEASIBLE,
    INFEASIBLE,
    RUNAWAY,
    UNREACHABLE,
    depth,
    most_margin,
)
from surefoot.mechanics.statics.polygons import enclose
from surefoot.mechanics.statics.region import Region
from surefoot.mechanics.statics.region_outline import TRACED, WITHOUT_BOUND, trace
from surefoot.mechanics.statics.row_blocks import IN_ONE

Rows = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""Rows of the contact wrench that are fixed, their values, and the point as pick @ wrench + offset."""

_MOST_DIRECTIONS = 2000
ROOM = 1e-8
"""Margin, in loads, below which the forces count as having no room inside their cones."""
_HAIR = 0.5 * BAND
"""Margin, in loads, that the widened cones leave at least."""
_MOST_BACK = 30.0
"""Steps along its axis by which a cone is moved back at most, for each by which its faces should move."""
_LEAST_ROOM = 1e-12
"""Margin, in loads, below which widened cones leave no room either."""
_AIM = 0.9999
"""Share of the tolerance spent on the gap; the rest on corners that hardly stand out."""
_AIMS = (_AIM, 0.25, 0.05)
"""Shares of the tolerance that are tried: the search steers by an estimate of the gap."""


@dataclass
class RegionOutline:
    """Bounds of a region from a search: an inner polygon, half-planes around it, and the gap between them."""

    inner: FloatArray
    directions: FloatArray
    heights: FloatArray
    gap: float
    unbounded: bool = False

    @classmethod
    def nothing(cls, gap: float, unbounded: bool = False) -> RegionOutline:
        """Return an outcome without a polygon: a gap of zero proves that there is none."""
        return cls(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), gap, unbounded)

    def region(self, height: float, axis: FloatArray, tol: float, force_limit: float = math.inf) -> Region:
        """Return what was found as a region in the plane of a height [m]; see `Region` for the rest."""
        return Region(
            self.inner, self.directions, self.heights, self.gap, height, axis, force_limit, self.gap <= tol
        )


@dataclass
class OutlineProgram:
    """Equations A x = w over cones, the point G x + offset, and a start inside the cones."""

    A: FloatArray
    w: FloatArray
    e: FloatArray
    lorentz: int
    G: FloatArray
    offset: FloatArray
    start: FloatArray


def trace_outline(question: Question, rows: Rows, tol: float) -> RegionOutline:
    """Return the region of the point of `rows` to a gap of `tol`, or as near to it as rounding lets it."""
    whole = _program(question, rows)
    outcome, margin, whole.start, _, _ = most_margin(whole.A, whole.e, whole.w, whole.lorentz, IN_ONE)
    if outcome in (INFEASIBLE, UNREACHABLE):
        return RegionOutline.nothing(0.0)
    if outcome != FEASIBLE:  # forces that run away are what rounding cannot judge
        endless = outcome == ENDLESS or float(np.abs(whole.start).max()) > RUNAWAY
        return RegionOutline.nothing(math.inf, unbounded=endless)
    if margin > ROOM:
        return search_certified(whole, None, tol)
    most = _MOST_BACK / (question.facets or 1)  # a pyramid's cone moves along each of its rays
    # Without room inside the cones the interior-point method has no start. Two programs with room: one
    # widened by what a verdict forgives, whose points count as inside, one by more, whose half-planes hold
    # all the same.
    inside = _widen(_program(question, rows, BAND), max(BAND, _HAIR - margin), most)
    if inside is None:
        return RegionOutline.nothing(math.inf)
    around = _widen(_program(question, rows, ROOM), ROOM - min(0.0, margin), most)
    return search_certified(inside, around, tol)


def _program(question: Question, rows: Rows, more: float = 0.0) -> OutlineProgram:
    """Pick the fixed rows of the wrench, scaled, and the point as a map of the cones' coordinates.

    Every contact has so much `more` friction than it was asked about.
    """
    if more > 0.0:
        question = replace(question, stance=question.stance.with_friction(question.stance.mu + more))
    eq = equations(question)
    wrench, goal, pick, offset = rows
    # The equations hold scaled wrenches; fixed rows and the point are given in newtons and metres.
    unscale = np.array([1.0, 1.0, 1.0, eq.length, eq.length, eq.length]) * eq.scale
    A = np.vstack([(wrench * unscale) @ eq.A[:6] / eq.scale, eq.A[6:]])
    w = np.concatenate([goal / eq.scale, eq.w[6:]])
    moments = wrench[:, 3:].any(axis=1)
    A[: len(goal)][moments] /= eq.length
    w[: len(goal)][moments] /= eq.length
    G = np.ascontiguousarray((pick * unscale) @ eq.A[:6])
    return OutlineProgram(np.ascontiguousarray(A), w, eq.e, eq.lorentz, G, np.array(offset, dtype=float), w)


def search_certified(inside: OutlineProgram, around: OutlineProgram | None, tol: float) -> RegionOutline:
    """Search, and measure the gap; with a finer estimate where it is not what the search took it for."""
    best = RegionOutline.nothing(math.inf)
    for share in _AIMS:
        outcome, points, directions, heights = _outline(inside, share * tol)
        if outcome == WITHOUT_BOUND:
            return RegionOutline.nothing(math.inf, unbounded=True)
        inner, gap = enclose(points, directions, heights, (1.0 - _AIM) * tol, tol)
        if gap > tol and around is not None:
            other, _, further, higher = _outline(around, share * tol)
            if other != WITHOUT_BOUND:
                directions, heights = np.vstack([directions, further]), np.concatenate([heights, higher])
                inner, gap = enclose(points, directions, heights, (1.0 - _AIM) * tol, tol)
        if gap < best.gap or not len(best.inner):
            best = RegionOutline(inner, directions, heights, gap)
        if best.gap <= tol or outcome != TRACED:
            break
    return best


def _outline(program: OutlineProgram, tol: float) -> tuple[int, FloatArray, FloatArray, FloatArray]:
    """Trace a program; return the outcome, the points reached, directions and heights."""
    A, w = program.A, program.w
    Q, T, pivots = np.empty_like(A), np.empty((len(A), len(A))), np.empty(len(A), dtype=np.int64)
    b = w.copy()
    rank = orthonormal_rows(A, Q, T, pivots)
    coordinates(T, pivots, rank, w, b)
    directions, heights = np.empty((_MOST_DIRECTIONS, 2)), np.empty(_MOST_DIRECTIONS)
    points = np.empty((_MOST_DIRECTIONS, 2))
    outcome, count, _ = trace(
        Q[:rank], b[:rank], program.lorentz, program.start, program.G, program.offset, tol,
        directions, heights, points,
    )  # fmt: skip
    return outcome, points[:count].copy(), directions[:count].copy(), heights[:count].copy()


def _widen(program: OutlineProgram, s: float, most: float) -> OutlineProgram | None:
    """Move the cones' apices back by s, in loads: x + s e in K, in coordinates x + s e; None without room.

    Cones of little friction are moved by no more than `most` s: their width is in their friction.
    """
    outcome, _, start, _, _ = most_margin(program.A, program.e, program.w, program.lorentz, IN_ONE)
    if outcome != FEASIBLE:
        return None
    shift = s * np.minimum(program.e, most)
    if not depth(start + shift, program.e, program.lorentz) > _LEAST_ROOM:
        return None
    return replace(
        program,
        w=program.w + program.A @ shift,
        offset=program.offset - program.G @ shift,
        start=start + shift,
    )
