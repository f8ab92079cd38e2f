"""How exact `ForceDistributor` is: judged by Clarabel, and both by decimal arithmetic."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchmarks.forces.digits import exact_forces
from benchmarks.forces.refined import refined_clarabel
from benchmarks.problems.allocation_program import cone_violation, objective, program
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.contact import Status
from surefoot.equilibrium.force_distribution import ForceDistributor

FAR = 1e-5
"""Distance of two forces [N] that counts as disagreement."""
Spread = tuple[float, float, float]


@dataclass(frozen=True)
class Accuracy:
    """Agreement with Clarabel at 1e-10 over random instances. Triples are percentiles 50, 99 and 100.

    Attributes
    ----------
    instances
        How many.
    not_solved
        How many `ForceDistributor` did not call SOLVED.
    objective_excess
        Largest relative excess of our objective over Clarabel's (negative where ours is lower).
    force_distance
        Largest distance between our force and Clarabel's of one contact [N].
    far
        How many instances have forces further apart than FAR.
    cone_violation
        Largest violation of a cone or bound by our forces [N].
    error, error_clarabel
        Largest distance of one contact's force to the optimum found with fifty digits [N], of our forces
        and of Clarabel's.
    """

    instances: int
    not_solved: int
    objective_excess: float
    force_distance: Spread
    far: int
    cone_violation: float
    error: Spread
    error_clarabel: Spread


def measure_accuracy(instances: Iterable[Instance], force_weight: float = FORCE_WEIGHT) -> Accuracy:
    """Compare `ForceDistributor`, cold, with refined Clarabel and with the exact forces on every instance."""
    excess, distances, violation = [], [], []
    unsolved = 0
    for instance in instances:
        distributor = ForceDistributor(
            instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, force_weight
        )
        f = distributor.solve(instance.grasp_map, instance.wrench)
        unsolved += distributor.status is not Status.SOLVED
        reference = refined_clarabel(instance, force_weight)
        exact = exact_forces(instance, reference, force_weight)
        p = program(instance, force_weight=force_weight)
        best = objective(p, reference.ravel()[p.columns])
        excess.append((objective(p, f.ravel()[p.columns]) - best) / best)
        pairs = ((f, reference), (f, exact), (reference, exact))
        distances.append([float(np.linalg.norm(a - b, axis=1).max()) for a, b in pairs])
        violation.append(cone_violation(instance, f))
    apart, mine, its = (_spread([d[k] for d in distances]) for k in range(3))
    far = sum(d[0] > FAR for d in distances)
    return Accuracy(len(distances), unsolved, max(excess), apart, far, max(violation), mine, its)


def _spread(values: list[float]) -> Spread:
    """Return percentiles 50, 99 and 100."""
    middle, most, worst = np.percentile(values, [50, 99, 100])
    return float(middle), float(most), float(worst)
