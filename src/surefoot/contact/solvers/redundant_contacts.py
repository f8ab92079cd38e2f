"""When the interior point is asked: where contacts are redundant or bodies known, by how heavy steps are.

Each function returns None for a problem that is not its own: `auto` has them at several places of its plans.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.redundancy import few_bodies, in_a_row, likely_rank
from surefoot.contact.solvers.delassus_factor import MOST_ROWS, find_factor
from surefoot.contact.solvers.interior_point import Extent, Method, active_contacts, solve_factored
from surefoot.contact.solvers.newton_step import FEW
from surefoot.contact.solvers.solver import Answer, SolverSettings

MOST_RANK, REDUNDANT, FEW_BODIES = 600, 0.75, 0.4
"""Rank of G where its factor is dense, and the rank's share of the rows, up to which
`where_redundant` tries: each iteration has a dense factor, and problems of full rank defeat the method.
Up to the last share, of walls, it comes early: Newton steps they defeat."""
LONGEST, LONG, LIGHT, LIGHTEST = 4e8, 1e8, 3e7, 1e6
"""Multiplications of a step's matrix up to which all steps take no longer than ten thousand iterations of
ADMM, than some thousand (others do as well beyond it), than Newton's first ones, and than the compiled call's
later rounds."""
NONE = (1.0, 0.0)
"""No share of the rows."""


def where_redundant(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts are redundant, a warm start (n, 3) as `solve_interior`; else None.

    Of more than `FEW` contacts where others of this module do not.
    """
    if problem.contacts <= FEW:
        return _where(problem, settings, warm_start, (-1.0, REDUNDANT))
    if _likely_work(problem) <= LIGHTEST:
        return None
    return _where(problem, settings, warm_start, (FEW_BODIES, REDUNDANT))


def where_few_bodies(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts hold few bodies, a warm start (n, 3) as `solve_interior`; else None."""
    return _where(problem, settings, warm_start, (-1.0, FEW_BODIES), LONG)


def where_sparse(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem of known bodies, or of a sparse matrix, a warm start (n, 3) as `solve_interior`.

    None for others. A stack is long; balls at rest in a pit creep along motions that next to nothing resists,
    at which other methods crawl.
    """
    return _where(problem, settings, warm_start, NONE, LONG, any_sparse=True)


def where_dense(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose matrix is dense and heavy, a warm start (n, 3) as `solve_interior`; else None."""
    if problem.factor is not None or _likely_work(problem) <= LIGHT:
        return None
    return _where(problem, settings, warm_start, (-1.0, REDUNDANT), LONGEST, dense=True)


def where_light(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None,
    extent: Extent = Extent.SHORT, at_turns: Method | None = None,
) -> Answer | None:  # fmt: skip
    """Solve a problem of few bodies, known ones, or contacts in a row, where steps are light; else None.

    Another method is asked where the path turns. A warm start is (n, 3) as `solve_interior`.
    """
    if problem.factor is None and not (few_bodies(problem) or in_a_row(problem)):
        return None
    return _where(
        problem, settings, warm_start, (-1.0, FEW_BODIES), LIGHT, (extent, at_turns), any_sparse=True
    )  # fmt: skip


def where_long(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Follow a winding path to its end, a warm start (n, 3) as `solve_interior`; None where steps are heavy.

    It takes ten seconds of a wall of 60 bricks, which nothing else solves.
    """
    return where_light(problem, settings, warm_start, Extent.LONG)


def where_lightest(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose steps are lightest, a warm start (n, 3) as `solve_interior`; else None."""
    if _likely_work(problem) > LIGHTEST:
        return None
    return _where(problem, settings, warm_start, (FEW_BODIES, REDUNDANT))


def _likely_work(problem: ContactProblem) -> float:
    """Return what a step's matrix takes where it is dense, as far as `likely_rank` knows."""
    return float(problem.g.size * likely_rank(problem) ** 2)


def _where(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None,
    shares: tuple[float, float], most: float = math.inf,
    ways: tuple[Extent, Method | None] = (Extent.SHORT, None), any_sparse: bool = False, dense: bool = False,
) -> Answer | None:  # fmt: skip
    """Solve where the rank's share of the rows is above the first, up to the second; else None.

    A step's matrix takes so many multiplications at most. Sparse ones, and known bodies, may have any rank;
    or dense ones alone are wanted.
    """
    if problem.general or problem.facets is not None or (problem.normal_max < np.inf).any():
        return None
    if problem.factor is None and problem.g.size > MOST_ROWS:
        return None
    active = active_contacts(problem)
    found = find_factor(problem, np.repeat(active, 3), most)
    if found is None:
        return None
    factor, structure = found
    rows, rank = factor.shape
    sparse = structure.sparse
    if dense and sparse:
        return None
    free = any_sparse and (sparse or problem.factor is not None)
    if (rank > MOST_RANK and not sparse) or not (free or shares[0] * rows < rank <= shares[1] * rows):
        return None
    return solve_factored(problem, settings, warm_start, active, factor, structure, *ways)
