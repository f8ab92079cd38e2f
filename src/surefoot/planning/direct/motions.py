"""Problems that are often asked: from rest to rest some way on, by a jump if need be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from surefoot.arrays import FloatArray, real_number, whole_number
from surefoot.planning.direct.problem import DirectProblem, Weights
from surefoot.planning.transcription.window import StateWindow
from surefoot.robot import Robot
from surefoot.terrain import FlatTerrain, Terrain

WITHIN, SPEED = 1e-3, 1e-2
"""How near the end is to be met: of q [m, rad], of v [m/s, rad/s]."""
TOP = 0.55
"""Share of the time at which a jump is to be at its height: a robot pushes off more slowly than it lands."""


def rest_to_rest(
    robot: Robot,
    distance: float = 0.0,
    rise: float = 0.0,
    *,
    knots: int = 24,
    dt: float = 0.03,
    mu: float = 0.6,
    terrain: Terrain | None = None,
    weights: Weights | None = None,
    q: FloatArray | None = None,
) -> DirectProblem:
    """Return the problem to stand `distance` further along x in the same pose.

    Parameters
    ----------
    robot
        One of `planar`, whose q begins with x and z.
    distance
        [m].
    rise
        How far the base is to be above its start at `TOP` of the time [m]; 0 leaves it to the optimiser.
    knots, dt, mu, terrain, weights
        See `DirectProblem`.
    q
        (nq,) the pose; None for the nominal one.

    Raises
    ------
    ProblemError
        For numbers out of range, and what `DirectProblem` refuses.

    Examples
    --------
    >>> from surefoot.planning.direct import planar_hopper, rest_to_rest
    >>> problem = rest_to_rest(planar_hopper(), 0.3)
    >>> problem.knots, problem.references[-1].round(2)
    (24, array([ 0.3 ,  0.43,  0.  ,  0.6 , -1.2 ]))
    """
    real_number("distance", distance, low=-1e3, high=1e3)
    real_number("rise", rise, low=0.0, high=1e3)
    whole_number("knots", knots, low=2)
    ground = FlatTerrain() if terrain is None else terrain
    q = robot.nominal if q is None else q
    there = robot.configuration(q)
    there[0] += distance
    there[1] += float(ground.height([there[0], 0.0]) - ground.height([there[0] - distance, 0.0]))
    windows = {}
    if rise > 0.0:
        low = np.full(len(there), -np.inf)
        low[1] = q[1] + rise
        windows[round(TOP * knots)] = StateWindow(q_low=low)
    chosen = Weights() if weights is None else weights
    rest = np.zeros(int(robot.model.nv))
    end = StateWindow.at(there, rest, WITHIN, SPEED)
    return DirectProblem(robot, q, rest, knots, dt, there, end, windows, chosen, mu, ground)


def finer(problem: DirectProblem, factor: int) -> DirectProblem:
    """Return a problem with `factor` times as many knots in the same time, to start from the coarse plan."""
    factor = whole_number("factor", factor, low=1)
    at = np.minimum(-(-np.arange(problem.knots * factor + 1) // factor), problem.knots)
    return replace(
        problem,
        knots=problem.knots * factor,
        dt=problem.dt / factor,
        reference=problem.references[at],
        windows={k * factor: window for k, window in problem.windows.items()},
    )
