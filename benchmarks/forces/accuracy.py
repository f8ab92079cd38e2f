"""How exact `ForceDistributor` is: judged by decimal arithmetic."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchmarks.forces.digits import exact_forces
from benchmarks.problems.allocation_program import cone_violation
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance
from surefoot.contact.solution import Status
from surefoot.mechanics.statics.force_distribution import ForceDistributor


@dataclass(frozen=True)
class Accuracy:
    """Distance to the optimum over random instances.

    Attributes
    ----------
    instances
        How many.
    not_solved
        How many `ForceDistributor` did not call SOLVED.
    error
        Largest distance of one contact's force to the optimum found with fifty digits [N]: percentiles 50,
        99 and 100.
    cone_violation
        Largest violation of a cone or bound [N].
    """

    instances: int
    not_solved: int
    error: tuple[float, float, float]
    cone_violation: float


def measure_accuracy(instances: Iterable[Instance], force_weight: float = FORCE_WEIGHT) -> Accuracy:
    """Compare `ForceDistributor`, cold, with the exact forces on every instance."""
    distances, violation = [], []
    unsolved = 0
    for instance in instances:
        distributor = ForceDistributor(
            instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, force_weight
        )
        f = distributor.solve(instance.grasp_map, instance.wrench)
        unsolved += distributor.status is not Status.SOLVED
        exact = exact_forces(instance, f, force_weight)
        distances.append(float(np.linalg.norm(f - exact, axis=1).max()))
        violation.append(cone_violation(instance, f))
    middle, most, worst = np.percentile(distances, [50, 99, 100])
    return Accuracy(len(distances), unsolved, (float(middle), float(most), float(worst)), max(violation))
