"""Where a robot starts to walk on a terrain, and which ground is beyond it."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot, Terrain, can_stand, friction_needed, place

HIGHEST_STEP = 0.5
"""Highest step that legs are asked to take, in heights of the base."""
CLEARANCE = 3.0
"""A robot starts this far before a terrain's first step, in heights of its base."""


def start_pose(robot: Robot, terrain: Terrain, posture: FloatArray | None = None) -> FloatArray:
    """Return a configuration (nq,) [m, -, rad] on the terrain, before its first step or about the origin.

    Its joints are as in (nq,) `posture`, None for the nominal pose, before it is put on its feet.

    Raises
    ------
    ModelError
        If the legs do not reach the ground.
    """
    return place(robot, terrain, posture, at=terrain.approach(CLEARANCE * float(robot.nominal[2])))


def check_ground(robot: Robot, terrain: Terrain, q: FloatArray, mu: float) -> None:
    """Refuse ground on which a robot cannot stand at (nq,) q with mu [-], or whose steps are too high.

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
    highest, step = HIGHEST_STEP * float(robot.nominal[2]), terrain.highest_step
    if step > highest:
        raise ProblemError(
            f"{robot.name} cannot walk over {terrain!r}: steps of {step:.3g} m, its legs take {highest:.3g} m"
        )
