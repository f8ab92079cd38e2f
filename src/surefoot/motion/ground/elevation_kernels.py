"""Compiled loops of the height map: fusing points, filling what is unknown, reading between cells."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel

REACH = 5
"""Unknown cells go by the lowest of the nearest ring with a known one, within so many cells."""
FLIGHT_ENDS, FLIGHT_EDGE = 0.6, 0.3
"""How far a flight of stairs reaches beyond its first and last edge, and how near to an edge a map knows less
of the ground than the flight does, in treads."""


@kernel
def fuse_points(
    heights: FloatArray,
    variances: FloatArray,
    corner: FloatArray,
    spacing: float,
    points: FloatArray,
    spread: FloatArray,
    gate: float,
    doubt: float,
    alone: BoolArray,
    trusted: bool,
) -> None:
    """Fuse (k, 3) points with variances (k,) into heights and variances (m, m), one after another.

    A point within `gate` standard deviations of its cell is averaged in, as a scalar Kalman filter does;
    another adds `doubt` times its squared distance to the cell's variance, and is taken once that lets it in.
    Cells that a single point has hit are `alone` (m, m), for it may be a stray one: the next point that
    contradicts it takes its place. A point that is `trusted` is none of these.
    """
    count = heights.shape[0]
    for k in range(points.shape[0]):
        if not (math.isfinite(points[k, 0]) and math.isfinite(points[k, 1]) and math.isfinite(points[k, 2])):
            continue
        # The nearest cell; corner is the middle of the first one.
        i = math.floor((points[k, 0] - corner[0]) / spacing + 0.5)
        j = math.floor((points[k, 1] - corner[1]) / spacing + 0.5)
        if i < 0 or j < 0 or i >= count or j >= count:
            continue
        z, r, p = points[k, 2], spread[k], variances[i, j]
        if p == np.inf:
            heights[i, j], variances[i, j], alone[i, j] = z, r, not trusted
            continue
        miss = z - heights[i, j]
        if alone[i, j]:
            alone[i, j] = miss * miss > gate * gate * (p + r) and not trusted
            if miss * miss > gate * gate * (p + r):
                heights[i, j], variances[i, j] = z, r
                continue
        if miss * miss > gate * gate * (p + r):
            p += doubt * miss * miss
            variances[i, j] = p
            if miss * miss > gate * gate * (p + r):
                continue
        # Scalar Kalman update.
        gain = p / (p + r)
        heights[i, j] += gain * miss
        variances[i, j] = (1.0 - gain) * p


@kernel
def leave_out_strays(
    heights: FloatArray, variances: FloatArray, alone: BoolArray, apart: float, out: FloatArray
) -> None:
    """Write variances (m, m), infinite for cells `alone` without a neighbour within `apart` of them."""
    count = heights.shape[0]
    for i in range(count):
        for j in range(count):
            out[i, j] = variances[i, j]
            if not alone[i, j]:
                continue
            backed = False
            for a in range(max(i - 1, 0), min(i + 2, count)):
                for b in range(max(j - 1, 0), min(j + 2, count)):
                    if (a != i or b != j) and variances[a, b] != np.inf:
                        backed |= abs(heights[a, b] - heights[i, j]) < apart
            # Only of what is passed on: in the map itself the cell keeps its height and variance, and counts
            # as soon as a neighbour backs it.
            if not backed:
                out[i, j] = np.inf


@kernel
def fill_unknown(
    heights: FloatArray,
    variances: FloatArray,
    level: float,
    slope_x: float,
    slope_y: float,
    filled: FloatArray,
) -> None:
    """Write the heights that are believed (m, m): medians of 3 x 3 known cells, guesses where none is known.

    `level` is the guessed plane's height at the first cell, `slope_x` and `slope_y` its rise per cell [m];
    next to known cells the guess is that plane through the one that lies lowest above or below it.
    """
    count = heights.shape[0]
    near = np.empty(9)
    for i in range(count):
        for j in range(count):
            if variances[i, j] == np.inf:
                lowest = np.inf
                for reach in range(1, REACH + 1):
                    for a in range(max(i - reach, 0), min(i + reach + 1, count)):
                        inner = abs(a - i) < reach
                        for b in range(max(j - reach, 0), min(j + reach + 1, count)):
                            if inner and abs(b - j) < reach:
                                continue
                            if variances[a, b] != np.inf:
                                # Heights over the guessed plane: on a slope the lowest one would be the one
                                # farthest down it.
                                lowest = min(lowest, heights[a, b] - slope_x * a - slope_y * b)
                    if lowest < np.inf:
                        break
                filled[i, j] = (level if lowest == np.inf else lowest) + slope_x * i + slope_y * j
                continue
            known = 0
            for a in range(max(i - 1, 0), min(i + 2, count)):
                for b in range(max(j - 1, 0), min(j + 2, count)):
                    if variances[a, b] != np.inf:
                        h = heights[a, b]
                        c = known  # insertion into the sorted ones so far
                        while c > 0 and near[c - 1] > h:
                            near[c] = near[c - 1]
                            c -= 1
                        near[c] = h
                        known += 1
            half = known // 2
            filled[i, j] = near[half] if known % 2 == 1 else 0.5 * (near[half - 1] + near[half])


@kernel
def bilinear(filled: FloatArray, corner: FloatArray, spacing: float, xy: FloatArray) -> FloatArray:
    """Return heights (k,) at (k, 2) places between the cells of (m, m) heights; level beyond the border."""
    count = filled.shape[0]
    out = np.empty(xy.shape[0])
    for k in range(xy.shape[0]):
        x = min(max((xy[k, 0] - corner[0]) / spacing, 0.0), count - 1.0)
        y = min(max((xy[k, 1] - corner[1]) / spacing, 0.0), count - 1.0)
        if not (x >= 0.0 and y >= 0.0):  # a place that is not a number
            out[k] = math.nan
            continue
        # On the far border the last square serves with a share of one: behind it there is no cell.
        i, j = min(int(x), count - 2), min(int(y), count - 2)
        u, w = x - i, y - j
        low = filled[i, j] + w * (filled[i, j + 1] - filled[i, j])
        high = filled[i + 1, j] + w * (filled[i + 1, j + 1] - filled[i + 1, j])
        out[k] = low + u * (high - low)
    return out


@kernel
def stair_heights(
    seen: FloatArray, known: BoolArray, xy: FloatArray, flight: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return heights (k,) at (k, 2) places on a flight of stairs or beside it, and where they are its own.

    Parameters
    ----------
    seen, known
        (k,) heights by a map [m], and where it knows them. Known ones that differ from the flight's by more
        than half a step, other than next to its edges, stay.
    xy
        Places [m].
    flight
        (10,) as `StairFit.parameters` gives: a unit vector across its edges, the place beside it about
        which it turns, the place of its edge 0, the depth of its treads, its turn [-], the height before the
        edge 0, the rise, and the numbers of its first and its last edge.
    """
    out, own = seen.copy(), np.zeros(len(seen), dtype=np.bool_)
    tread, rise = flight[4], flight[7]
    for k in range(len(seen)):
        # Along the flight and beside it; its turn is small, so that edges are moved by turn times w.
        s = xy[k, 0] * flight[0] + xy[k, 1] * flight[1]
        w = xy[k, 1] * flight[0] - xy[k, 0] * flight[1] - flight[2]
        share = (s - flight[3] - flight[5] * w) / tread
        if not (flight[8] - FLIGHT_ENDS < share < flight[9] + FLIGHT_ENDS):
            continue
        number = min(max(math.floor(share) + 1.0, flight[8]), flight[9] + 1.0)
        height = flight[6] + number * rise
        from_edge = abs(share - min(max(math.floor(share + 0.5), flight[8]), flight[9]))
        if not known[k] or from_edge < FLIGHT_EDGE or abs(seen[k] - height) < 0.5 * abs(rise):
            out[k], own[k] = height, True
    return out, own
