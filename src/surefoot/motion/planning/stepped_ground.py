"""Ground in steps as a jump sees it: where its feet stand, and what lies between that nothing may go into."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import LevelsTerrain, PitTerrain, Robot, Terrain

EDGE = 0.03
"""How near an edge the middle of a foot may land [m]."""
AHEAD, WIDTH = 0.06, 0.02
"""How far before a step motions have risen above it, and how smoothly its height is taken there [m]."""
NEAR = 4e-3
"""How much of a step may be smoothed onto a place where a foot stands [m]."""


class PassedGround(LevelsTerrain):
    """The levels between the feet of two configurations, with their ditches filled.

    Parameters
    ----------
    edges, tops
        The ground as it is, see `LevelsTerrain.levels`.
    robot, q, end
        Whose feet go from (nq,) q to (nq,) end.
    """

    def __init__(
        self, edges: FloatArray, tops: FloatArray, robot: Robot, q: FloatArray, end: FloatArray
    ) -> None:
        feet = np.vstack([robot.foot_positions(q), robot.foot_positions(end)])[:, 0]
        ends = np.clip(np.searchsorted(edges, [feet.min(), feet.max()], side="right") - 1, 0, len(tops) - 1)
        first, last = int(ends[0]), int(ends[1])
        between = tops[first : last + 1]
        left, right = (np.maximum.accumulate(side) for side in (between, between[::-1]))
        self._edges = np.array([edges[0], *edges[first + 1 : last + 1], edges[-1]])
        self._tops = np.minimum(left, right[::-1])

    def levels(self) -> tuple[FloatArray, FloatArray]:
        """Return edges and heights, see `LevelsTerrain.levels`."""
        return self._edges, self._tops

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the height at (..., 2) places [m]: (...)."""
        x = np.asarray(xy, dtype=np.float64)[..., 0]
        return np.asarray(self._tops[np.searchsorted(self._edges[1:-1], x, side="right")])

    def smooth(self, x: Any) -> Any:
        """Return the height at places along x [m], numbers or symbols, with steps that begin `AHEAD`."""
        out = float(self._tops[0])
        for edge, step in zip(self._edges[1:-1], np.diff(self._tops), strict=True):
            if step:
                t = (x - float(edge) + float(np.copysign(AHEAD, step))) / WIDTH
                out = out + 0.5 * float(step) * (1.0 + t / (1.0 + t * t) ** 0.5)
        return out


def find_passed_ground(terrain: Terrain, robot: Robot, q: FloatArray, end: FloatArray) -> PassedGround | None:
    """Return the stepped ground between the feet of two configurations (nq,); None on a plane."""
    levels = terrain.levels()
    return None if levels is None else PassedGround(*levels, robot, q, end)


def climb_of(terrain: Terrain, robot: Robot, q: FloatArray, end: FloatArray) -> float:
    """Return by how much higher than at (nq,) q the ground is under the feet of (nq,) end [m]; 0 on a plane.

    Raises
    ------
    ProblemError
        For feet that stand or land too near an edge or a step, or whose ground does not rise alike.
    """
    between = find_passed_ground(terrain, robot, q, end)
    if between is None:
        return 0.0
    places = np.array([robot.foot_positions(q), robot.foot_positions(end)])
    near = [[0.99 * side, 0.0] for side in (0.0, -EDGE, EDGE)]
    levels = np.array([terrain.height(places[..., :2] + shift) for shift in near])
    rises = levels[0, 1] - levels[0, 0]
    off = np.ptp(levels, axis=0) + np.abs(between.smooth(places[..., 0]) - levels[0])
    off[1] += np.abs(rises - np.median(rises))
    if off.max() > NEAR:
        when, foot = np.unravel_index(int(off.argmax()), off.shape)
        verb, x = ("stands", "lands")[when], places[when, foot, 0]
        raise ProblemError(
            f"{robot.foot_names[foot]} {verb} at x = {x:.3g} m, too near an edge or on another level "
            f"than the others: {terrain!r}; jump further or less far, or start elsewhere"
        )
    return float(rises[0])


def least_way(robot: Robot, q: FloatArray, over: float) -> float:
    """Return how far feet have to jump along x from (nq,) q to leave a gap of that width behind [m]."""
    return float(np.ptp(robot.foot_positions(q)[:, 0])) + over + 2.0 * EDGE


def gap_before(robot: Robot, q: FloatArray, end: FloatArray, over: float) -> PitTerrain:
    """Return the ground with a gap of a width [m] between the feet of (nq,) q and those of (nq,) end.

    As deep as the robot stands high; it begins `EDGE` beyond the feet that stand.

    Raises
    ------
    ProblemError
        For a gap that is wider than the way between them.
    """
    before, after = (robot.foot_positions(at)[:, 0] for at in (q, end))
    free = max(after.min() - before.max(), before.min() - after.max()) - 2.0 * EDGE
    if over > free + 1e-9:
        raise ProblemError(
            f"over must be a gap [m] between where feet stand and land along x: this jump leaves "
            f"{max(free, 0.0):.3g} m, got {over:g}; straight on it takes {least_way(robot, q, over):.3g} m"
        )
    ahead = after.min() > before.max()
    start = before.max() + EDGE if ahead else before.min() - EDGE - over
    return PitTerrain(float(start), over, float(robot.nominal[2]))
