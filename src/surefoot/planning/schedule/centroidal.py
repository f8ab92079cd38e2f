"""Centroidal motions over a mode schedule, by Ipopt; the equations are in `centroidal_transcribe`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.planning.schedule.centroidal_problem import CentroidalProblem, CentroidalWeights
from surefoot.planning.schedule.centroidal_transcribe import (
    STATE,
    centroidal_block,
    centroidal_rows,
    centroidal_start,
    centroidal_variables,
)
from surefoot.planning.schedule.search import ACCEPTED, Found, Search, Tell, solve_blocks

__all__ = ["CentroidalMotion", "CentroidalProblem", "CentroidalWeights", "optimise_centroidal"]


@dataclass(frozen=True, eq=False)
class CentroidalMotion:
    """What the optimiser found; motion of T = N + 1 times under forces of N knots.

    Attributes
    ----------
    times
        (T,) [s].
    com, velocity, momentum
        (T, 3) centre of mass [m], its velocity [m/s], angular momentum about it [N m s]; world axes.
    quaternion
        (T, 4) orientation (x, y, z, w).
    forces
        (N, n, 3) in world axes [N].
    footholds
        (N, n, 3) where the feet stand [m], NaN in the air.
    stance
        (N, n) which feet stand.
    cost, violation
        Objective, and the largest violation of a row or bound in its own scale [-].
    found
        Whether the violation is within `search.ACCEPTED`.
    iterations
        Ipopt's.
    said
        Its return status.
    """

    times: FloatArray
    com: FloatArray
    velocity: FloatArray
    momentum: FloatArray
    quaternion: FloatArray
    forces: FloatArray
    footholds: FloatArray
    stance: BoolArray
    cost: float
    violation: float
    found: bool
    iterations: int
    said: str


def optimise_centroidal(
    problem: CentroidalProblem, max_iterations: int = 500, tell: Tell | None = None, **options: Any
) -> CentroidalMotion:
    """Return the best centroidal motion that Ipopt finds over a problem's schedule, from its reference.

    Parameters
    ----------
    problem
        See `CentroidalProblem`.
    max_iterations
        Of Ipopt.
    tell
        Called with the number of every iteration, cost and violation.
    options
        Ipopt's, without their prefix.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    begin, search = centroidal_start(problem), Search(max_iterations, tell, options)
    data = np.hstack([problem.reference[1:], problem.stance])
    found = solve_blocks(
        centroidal_block(problem),
        data,
        centroidal_rows(problem),
        centroidal_variables(problem),
        begin,
        search,
    )
    return _read(problem, found)


def _read(problem: CentroidalProblem, found: Found) -> CentroidalMotion:
    """Return the motion that variables mean."""
    n, N, stance = problem.schedule.feet, problem.knots, problem.stance
    size = STATE + 2 * n
    table = found.variables[:-size].reshape(N, -1)
    states = np.vstack([table[:, :size], found.variables[-size:]])
    forces = problem.weight * table[:, size:].reshape(N, n, 3) @ problem.frame.T
    places = problem.origin + states[:-1, STATE:].reshape(N, n, 2) @ problem.frame[:, :2].T
    places[~stance] = np.nan
    times = np.asarray(problem.dt * np.arange(N + 1), dtype=np.float64)
    return CentroidalMotion(
        times, states[:, :3], states[:, 7:10], problem.mass * states[:, 10:13],
        states[:, 3:7], forces, places, stance, found.cost, found.violation,
        bool(found.violation <= ACCEPTED), found.iterations, found.said,
    )  # fmt: skip
