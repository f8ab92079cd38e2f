"""Where between the edges of steps a foot may stand.

A foot keeps a margin from the edges on both sides, and more from one behind it that it came down over: a shin
leans back over it.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.terrain import Terrain

SHIN, LOW_STEP = 0.13, 0.03
"""Distance that a descending foot keeps from the edge behind it, and what is a step [m]."""
UNSURE = 0.01
"""What it keeps more where edges are only believed to be where they are [m]."""
LOOK, FINE = 0.3, 0.005
"""How far along the way edges are looked for, and in what steps [m]."""
FARTHEST = 0.15
"""Farthest that a foot is moved for an edge [m]."""
NEAR = np.arange(-LOOK, LOOK + 0.5 * FINE, FINE)


def step_windows(
    terrain: Terrain, place: FloatArray, along: FloatArray, margin: float, ways: FloatArray = NEAR
) -> tuple[FloatArray, FloatArray] | None:
    """Return from where to where a foot may be moved along its way, for each tread near it.

    Parameters
    ----------
    terrain
        As believed.
    place
        (2,) where the foot would stand [m].
    along
        (2,) direction of its way, a unit vector.
    margin
        Distance to keep from edges [m].
    ways
        (m,) how far along its way to look, even steps [m].

    Returns
    -------
    (n,), (n,) least and largest move of each tread in turn [m]; None where there is no edge. Both are
    the same where a tread is too short: as far from the edge behind as the margin to the next allows,
    or the middle.
    """
    heights = terrain.height(place + ways[:, None] * along)
    jumps = heights[2:] - heights[:-2]
    at = np.flatnonzero(np.abs(jumps) > max(2.0 * terrain.noise, LOW_STEP))
    if not len(at):
        return None
    first = np.concatenate([[True], np.diff(at) > 1])  # an edge is seen by two or more differences
    begin = np.flatnonzero(first)
    last = np.append(begin[1:], len(at)) - 1
    edges = 0.5 * (ways[at[begin] + 1] + ways[at[last] + 1])
    shin = max(SHIN + (UNSURE if terrain.learns else 0.0), margin)
    behind = np.where(jumps[at[begin]] < 0.0, shin, margin)
    low = np.concatenate([[-math.inf], edges + behind])
    high = np.concatenate([edges - margin, [math.inf]])
    middles = np.concatenate([[-math.inf], 0.5 * (edges[:-1] + edges[1:]), [math.inf]])
    short = low > high
    low[short] = high[short] = np.maximum(high, middles)[short]
    return low, high


def nearest_shift(windows: tuple[FloatArray, FloatArray], ahead: FloatArray) -> FloatArray:
    """Return the least moves into any window, of feet that are `ahead` of their place: (k,) for (k,) [m].

    Examples
    --------
    >>> nearest_shift((np.array([-np.inf, 0.1]), np.array([-0.04, 0.3])), np.array([-0.1, 0.0, 0.05, 0.2]))
    array([ 0.  , -0.04,  0.05,  0.  ])
    """
    moves = np.clip(ahead, windows[0][:, None], windows[1][:, None]) - ahead
    best = np.abs(moves).argmin(axis=0)
    return np.asarray(moves[best, np.arange(len(ahead))])
