"""How exact `ForceDistributor` is, judged by Clarabel on random instances."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from surefoot.arrays import FloatArray
from surefoot.bench.forces_instances import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.bench.forces_rivals import cone_rows, contact_problem, objective, program
from surefoot.contact import Status, residuals
from surefoot.control.force_distribution import ForceDistributor
from surefoot.errors import MissingExtra

ROUNDS = (1.0, 1.0, 10.0, 10.0, 100.0, 100.0, 1000.0)
"""Factors on the objective, one per refinement of Clarabel's answer."""


@dataclass(frozen=True)
class Accuracy:
    """Agreement with Clarabel at 1e-10 over random instances.

    Attributes
    ----------
    instances
        How many.
    not_solved
        How many `ForceDistributor` did not call SOLVED.
    objective_excess
        Largest relative excess of our objective over Clarabel's (negative where ours is lower).
    force_distance
        Largest distance between the forces of one contact [N]: all, and at percentiles 50, 99, 100.
    far
        How many instances have forces further apart than 1e-5 N.
    cone_violation
        Largest violation of a cone or bound by our forces [N].
    natural_map, natural_map_clarabel
        Largest natural map residual of our forces and of Clarabel's, from the problem alone.
    far_lower
        Among the far ones, how many have the lower objective and the lower residual on our side.
    """

    instances: int
    not_solved: int
    objective_excess: float
    force_distance: tuple[float, float, float]
    far: int
    far_lower: int
    cone_violation: float
    natural_map: float
    natural_map_clarabel: float


def refined_clarabel(
    instance: Instance, force_weight: float = FORCE_WEIGHT, tol: float = 1e-10
) -> FloatArray:
    """Return Clarabel's forces, refined around its own answer: (n, 3) [N].

    Its gap of `tol` is relative to the objective, which leaves up to 1e-3 N in the forces. Solving again for
    the change from the last answer, with the objective scaled up, makes the same tolerance count for the
    forces; of all rounds the one with the least natural map is kept.
    """
    try:
        import clarabel
    except ImportError as error:
        raise MissingExtra("clarabel", "qp") from error
    p, problem = program(instance, force_weight=force_weight), contact_problem(instance, force_weight)
    M, b = cone_rows(p)
    a = p.mu.size
    cones = [clarabel.NonnegativeConeT(2 * a)] + [clarabel.SecondOrderConeT(3)] * a
    options = clarabel.DefaultSettings()
    options.verbose = options.presolve_enable = False
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = tol
    P, rows, best, x = sp.csc_matrix(np.triu(p.H)), sp.csc_matrix(M), np.inf, np.zeros(p.h.size)
    for factor in ROUNDS:
        solver = clarabel.DefaultSolver(factor * P, factor * (p.H @ x + p.h), rows, b - M @ x, cones, options)
        tried = x + np.asarray(solver.solve().x)
        residual = residuals(problem, p.forces(tried)).natural_map
        if residual < best:
            best, x = residual, tried
    return p.forces(x)


def measure_accuracy(instances: Iterable[Instance], force_weight: float = FORCE_WEIGHT) -> Accuracy:
    """Compare `ForceDistributor`, cold, with refined Clarabel on every instance."""
    excess, distance, violation, ours, theirs = [], [], [], [], []
    unsolved = lower = 0
    for instance in instances:
        distributor = ForceDistributor(
            instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, force_weight
        )
        f = distributor.solve(instance.grasp_map, instance.wrench)
        unsolved += distributor.status is not Status.SOLVED
        reference = refined_clarabel(instance, force_weight)
        p, problem = program(instance, force_weight=force_weight), contact_problem(instance, force_weight)
        best = objective(p, reference.ravel()[p.columns])
        excess.append((objective(p, f.ravel()[p.columns]) - best) / best)
        distance.append(float(np.linalg.norm(f - reference, axis=1).max()))
        mine, its = residuals(problem, f), residuals(problem, reference)
        violation.append(mine.cone_violation)
        ours.append(mine.natural_map)
        theirs.append(its.natural_map)
        lower += distance[-1] > 1e-5 and excess[-1] <= 0.0 and ours[-1] < theirs[-1]
    spread = np.percentile(distance, [50, 99, 100])
    return Accuracy(
        len(distance), unsolved, max(excess), (spread[0], spread[1], spread[2]),
        int(np.sum(np.array(distance) > 1e-5)), lower, max(violation), max(ours), max(theirs),
    )  # fmt: skip
