"""Centroidal motions over a mode schedule, by Ipopt; the equations are in `centroidal_transcribe`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.planning.direct.blocks import unpack
from surefoot.planning.schedule.centroidal_problem import CentroidalProblem, CentroidalWeights
from surefoot.planning.schedule.centroidal_transcribe import (
    STATE,
    centroidal_block,
    centroidal_rows,
    centroidal_start,
    centroidal_variables,
)
from surefoot.planning.schedule.search import Found, Search, Tell, solve_blocks

__all__ = ["CentroidalMotion", "CentroidalProblem", "CentroidalWeights", "optimise_centroidal"]


@dataclass(frozen=True, eq=False)
class CentroidalMotion(Found):
    """What the optimiser found, and the motion of T = N + 1 times under forces of N knots that it means.

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
    """

    times: FloatArray
    com: FloatArray
    velocity: FloatArray
    momentum: FloatArray
    quaternion: FloatArray
    forces: FloatArray
    footholds: FloatArray
    stance: BoolArray


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
    states, inputs = unpack(found.variables, STATE + 2 * n, N)
    forces = problem.weight * inputs.reshape(N, n, 3) @ problem.frame.T
    places = problem.origin + states[:-1, STATE:].reshape(N, n, 2) @ problem.frame[:, :2].T
    places[~stance] = np.nan
    times = np.asarray(problem.dt * np.arange(N + 1), dtype=np.float64)
    return CentroidalMotion(
        **vars(found), times=times, com=states[:, :3], velocity=states[:, 7:10],
        momentum=problem.mass * states[:, 10:13], quaternion=states[:, 3:7], forces=forces, footholds=places,
        stance=stance,
    )  # fmt: skip
