"""When the interior point is asked: where contacts are redundant or bodies known, by how heavy steps are.

Each function returns None for a problem that is not its own: `auto` has them at several places of its plans.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.redundancy import few_bodies, in_a_row
from surefoot.contact.solvers.delassus_factor import MOST_ROWS, SPARSE_FROM, find_factor, likely_work
from surefoot.contact.solvers.interior_point import Extent, active_contacts, solve_factored
from surefoot.contact.solvers.newton_step import FEW
from surefoot.contact.solvers.reduced_structure import Structure
from surefoot.contact.solvers.solver import Answer, SolverSettings

MOST_RANK, REDUNDANT, FEW_BODIES = 600, 0.75, 0.4
"""Rank of G where its factor is dense, and the rank's share of the rows, up to which
`where_redundant` tries: each iteration has a dense factor, and problems of full rank defeat the method.
Up to the last share, of walls, it comes early: Newton steps they defeat."""
LONGEST, LONG, LIGHT, LIGHTEST = 4e8, 1e8, 3e7, 1e6
"""Multiplications of a step's matrix up to which all steps take no longer than ten thousand iterations of
ADMM, than some thousand (others do as well beyond it), than Newton's first ones, and than the compiled call's
later rounds."""
ALL_STEPS = 1.5e11
"""Those of all steps of the heaviest matrices together, at most: 170 steps of 463 contacts on 100
bodies, 3 s. Where a path winds for longer ADMM is quicker."""


class MatrixLimits(NamedTuple):
    """Of which matrices an interior point is asked: those whose rank's share of the rows lies between two.

    Attributes
    ----------
    above, most
        Shares: above the first, and up to the second.
    work, sparse_above
        Multiplications of a step's matrix, at most, and those that a sparse one takes at least.
    any_sparse
        Whether sparse ones, and those of known bodies, may have any rank.
    dense
        Whether dense ones alone are wanted.
    """

    above: float = -1.0
    most: float = REDUNDANT
    work: float = math.inf
    sparse_above: float = 0.0
    any_sparse: bool = False
    dense: bool = False


REST = MatrixLimits(above=FEW_BODIES)
HEAVIER = MatrixLimits(above=FEW_BODIES, sparse_above=LIGHTEST)
BODIES = MatrixLimits(most=FEW_BODIES, work=LONG)
LIGHT_AND_SPARSE = MatrixLimits(above=FEW_BODIES, work=LIGHTEST)
KNOWN_OR_SPARSE = MatrixLimits(above=1.0, most=0.0, work=LONG, any_sparse=True)
HEAVY, HEAVIEST = MatrixLimits(work=LONGEST, dense=True), MatrixLimits(dense=True)
EARLY = MatrixLimits(most=FEW_BODIES, work=LIGHT, any_sparse=True)
"""What `auto` asks for, before its other methods (`EARLY`) and between them; no dense matrix has a share
above all of the rows and up to none of them."""


def where_redundant(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts are redundant, a warm start (n, 3) as `solve_interior`; else None.

    Of more than `FEW` contacts where others of this module do not.
    """
    if problem.contacts <= FEW:
        return _solve(problem, settings, warm_start, MatrixLimits())
    if likely_work(problem) <= LIGHTEST:
        return None
    return _solve(problem, settings, warm_start, HEAVIER)


def where_few_bodies(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose contacts hold few bodies, a warm start (n, 3) as `solve_interior`; else None."""
    # a sparse factor takes longer to find than sweeps that solve most where bodies are many
    if problem.g.size >= SPARSE_FROM and not few_bodies(problem):
        return None
    return _solve(problem, settings, warm_start, BODIES)


def where_sparse(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem of known bodies, or of a sparse matrix, a warm start (n, 3) as `solve_interior`.

    None for others. A stack is long; balls at rest in a pit creep along motions that next to nothing resists,
    at which other methods crawl.
    """
    return _solve(problem, settings, warm_start, KNOWN_OR_SPARSE)


def where_dense(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose matrix is dense and heavy, a warm start (n, 3) as `solve_interior`; else None."""
    if problem.factor is not None or likely_work(problem) <= LIGHT:
        return None
    return _solve(problem, settings, warm_start, HEAVY)


def where_heaviest(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None
) -> Answer | None:
    """Solve a problem whose matrix is too heavy for `where_dense`, in few steps; None for others.

    A warm start is (n, 3) as `solve_interior`.
    """
    work = likely_work(problem)
    if problem.factor is not None or work <= LONGEST:
        return None
    steps = int(ALL_STEPS / work)
    if settings.max_iterations is not None:
        steps = min(steps, settings.max_iterations)
    return _solve(problem, SolverSettings(settings.tol, steps, settings.max_time), warm_start, HEAVIEST)


def where_light(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None,
    extent: Extent = Extent.SHORT,
) -> Answer | None:  # fmt: skip
    """Solve a problem of few bodies, known ones, or contacts in a row, where steps are light; else None.

    A warm start is (n, 3) as `solve_interior`.
    """
    if problem.factor is None and not (few_bodies(problem) or in_a_row(problem)):
        return None
    return _solve(problem, settings, warm_start, EARLY, extent)


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
    light = likely_work(problem) <= LIGHTEST
    return _solve(problem, settings, warm_start, REST if light else LIGHT_AND_SPARSE)


def _solve(
    problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None, limits: MatrixLimits,
    extent: Extent = Extent.SHORT,
) -> Answer | None:  # fmt: skip
    """Solve a problem whose matrix is one of those asked for; else None."""
    found = _find_matrix(problem, limits)
    if found is None:
        return None
    return solve_factored(problem, settings, warm_start, *found, extent)


def _find_matrix(problem: ContactProblem, limits: MatrixLimits) -> tuple[BoolArray, Any, Structure] | None:
    """Return the active contacts (n,), the factor of their G and its structure; None if not asked for."""
    if problem.general or problem.facets is not None or (problem.normal_max < np.inf).any():
        return None
    if problem.factor is None and problem.g.size > MOST_ROWS:
        return None
    active = active_contacts(problem)
    found = find_factor(problem, np.repeat(active, 3), limits.work)
    if found is None:
        return None
    factor, structure = found
    rows, rank = factor.shape
    if rank > MOST_RANK and not structure.sparse:
        return None
    if structure.sparse and (limits.dense or structure.work <= limits.sparse_above):
        return None
    free = limits.any_sparse and (structure.sparse or problem.factor is not None)
    if not (free or limits.above * rows < rank <= limits.most * rows):
        return None
    return active, factor, structure
