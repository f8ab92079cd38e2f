"""Where the interior point is asked: of problems whose contacts are redundant, by how heavy its steps are.

Each function returns None for a problem that is not its own: `auto` has them at several places of its plans.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.redundancy import LIKELY_FEW, likely_rank
from surefoot.contact.solvers.interior_point import LIGHT, active_contacts, factor_of, solve_factored
from surefoot.contact.solvers.newton_step import FEW
from surefoot.contact.solvers.solver import Answer, SolverSettings

MOST_RANK, MOST_ROWS, REDUNDANT, FEW_BODIES = 450, 1500, 0.75, 0.4
"""Rank of G, rows where the rank is not known, and the rank's share of the rows, up to which
`where_redundant` tries: each iteration has a dense factor, and problems of full rank defeat the method.
Up to the last share, of walls, it comes early: Newton steps they defeat."""
LONG, LIGHTEST = 1e8, 1e6
"""Rows times the square of the rank up to which all steps take no longer than some thousand iterations of
ADMM (others do as well beyond it), and up to which no longer than the compiled call's later rounds."""


def where_redundant(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts are redundant, a warm start (n, 3) as `solve_interior`; else None.

    Of more than `FEW` contacts where others of this module do not.
    """
    if problem.contacts <= FEW:
        return _where(problem, settings, warm_start, -1.0, REDUNDANT)
    if _likely_work(problem) <= LIGHTEST:
        return None
    return _where(problem, settings, warm_start, FEW_BODIES, REDUNDANT)


def where_few_bodies(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts hold few bodies, a warm start (n, 3) as `solve_interior`; else None."""
    if _likely_work(problem) > LONG:
        return None
    return _where(problem, settings, warm_start, -1.0, FEW_BODIES)


def where_light(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose steps are light, a warm start (n, 3) as `solve_interior`; else None."""
    rows, rank = problem.g.size, likely_rank(problem)
    if rank > LIKELY_FEW * rows or rows * rank**2 > LIGHT:
        return None
    return _where(problem, settings, warm_start, -1.0, FEW_BODIES)


def where_lightest(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose steps are lightest, a warm start (n, 3) as `solve_interior`; else None."""
    if _likely_work(problem) > LIGHTEST:
        return None
    return _where(problem, settings, warm_start, FEW_BODIES, REDUNDANT)


def _likely_work(problem: ContactProblem) -> float:
    """Return rows times the square of the rank, as far as `likely_rank` knows: what a step's matrix takes."""
    return float(problem.g.size * likely_rank(problem) ** 2)


def _where(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None, low: float, high: float
) -> Answer | None:
    """Solve where the rank's share of the rows is above low, up to high; else None."""
    if problem.general or problem.facets is not None or (problem.normal_max < np.inf).any():
        return None
    known = None if problem.factor is None else problem.factor.shape[1]
    if known is not None and known > MOST_RANK:
        return None
    active = active_contacts(problem)
    if known is None and problem.g.size > MOST_ROWS:
        return None
    factor = factor_of(problem, np.repeat(active, 3))
    rows, rank = factor.shape
    if rank > MOST_RANK or not low * rows < rank <= high * rows:
        return None
    return solve_factored(problem, settings, warm_start, active, factor)
