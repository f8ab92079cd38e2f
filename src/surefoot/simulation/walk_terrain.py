"""Ground to walk on: random bumps, and where a robot starts on each terrain."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, real_number
from surefoot.equilibrium import can_stand, friction_needed
from surefoot.errors import ProblemError
from surefoot.robot import Robot, place
from surefoot.stance import HeightfieldTerrain, StairsTerrain, Terrain

BUMP = 0.2
"""Distance between the random heights of rough ground [m]."""
FIELD = (16.0, 8.0)
"""Size of rough ground along x and y [m], about the origin."""
HIGHEST_STEP = 0.5
"""Highest step that legs are asked to take, in heights of the base."""
BEFORE_STAIRS = 3.0
"""A robot starts this far before the first riser, in heights of its base."""


class PitTerrain(Terrain):
    """Level ground with a ditch across the way.

    Parameters
    ----------
    start, length
        Where along x the ditch begins, and how long it is [m].
    depth
        Of the ditch [m].

    Examples
    --------
    >>> PitTerrain(start=1.0, length=0.3, depth=0.05).height([[0.9, 0.0], [1.1, 2.0]])
    array([ 0.  , -0.05])
    """

    def __init__(self, start: float, length: float, depth: float) -> None:
        self.start, self.length = real_number("start", start), real_number("length", length, low=0.0)
        self.depth = real_number("depth", depth, low=0.0)

    def __repr__(self) -> str:
        return f"PitTerrain(start={self.start:g}, length={self.length:g}, depth={self.depth:g})"

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the ground height under (..., 2) places [m]: (...)."""
        x = np.asarray(xy, dtype=np.float64)[..., 0]
        return np.where((x >= self.start) & (x < self.start + self.length), -self.depth, 0.0)

    def normal(self, xy: ArrayLike) -> FloatArray:
        """Return the vertical at (..., 2) places: (..., 3)."""
        return np.broadcast_to(np.array([0.0, 0.0, 1.0]), (*np.asarray(xy).shape[:-1], 3)).copy()


def rough_ground(seed: int, height: float) -> HeightfieldTerrain:
    """Return ground with random heights, uniform between 0 and `height` [m], every `BUMP`, smooth in between.

    Examples
    --------
    >>> ground = rough_ground(seed=3, height=0.04)
    >>> bool(0.0 <= ground.heights.min() <= ground.heights.max() <= 0.04)
    True
    """
    top = real_number("height", height, low=0.0, high=10.0)
    counts = [round(size / BUMP) + 1 for size in FIELD]
    return HeightfieldTerrain(np.random.default_rng(seed).uniform(0.0, top, counts), BUMP)


def start_pose(robot: Robot, terrain: Terrain) -> FloatArray:
    """Return a configuration that stands on the terrain: about the origin, or before the stairs' first riser.

    Raises
    ------
    ModelError
        If the legs do not reach the ground.
    """
    if not isinstance(terrain, StairsTerrain):
        return place(robot, terrain)
    q = place(robot)
    q[0] -= BEFORE_STAIRS * float(robot.nominal[2])
    return q


def check_ground(robot: Robot, terrain: Terrain, q: FloatArray, mu: float) -> None:
    """Refuse ground on which a robot cannot even stand at (nq,) q, or whose steps its legs cannot take.

    Raises
    ------
    ProblemError
        Saying what would be needed.
    """
    stance, com = robot.stance(q, mu=mu, terrain=terrain), robot.com(q)
    if not can_stand(stance, com, robot.mass).feasible:
        needed = friction_needed(stance, com, robot.mass)
        remedy = f"{needed:.2f} would be needed" if np.isfinite(needed) else "no friction would be enough"
        raise ProblemError(f"{robot.name} cannot stand on {terrain!r} with friction {mu:g}: {remedy}")
    highest, step = HIGHEST_STEP * float(robot.nominal[2]), 0.0
    if isinstance(terrain, StairsTerrain):
        step = abs(terrain.rise)
    elif isinstance(terrain, HeightfieldTerrain):
        step = float(np.ptp(terrain.heights))
    if step > highest:
        raise ProblemError(
            f"{robot.name} cannot walk over {terrain!r}: steps of {step:.3g} m, its legs take {highest:.3g} m"
        )
