"""What joint torque limits cost `ForceDistributor`: where they hold by themselves and where they bind."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, four_feet
from benchmarks.timing import Timing, one_core
from surefoot.arrays import FloatArray
from surefoot.contact import Status
from surefoot.equilibrium.force_distribution import ForceDistributor

LIMITS = (100.0, 12.0, 6.0)
"""Torque limits of the three runs [N·m]: never, often and almost always binding."""
REPEATS = 5


@dataclass(frozen=True)
class TorqueRow:
    """One limit: the share of allocations that it binds, how many were solved, the worst excess and the time.

    Attributes
    ----------
    limit
        Torque limit of every joint [N·m].
    binding
        Share of the allocations whose torques exceed it without the limit.
    solved
        Share solved to the optimum.
    excess
        Worst torque above the limit [N·m]; negative means that all are within.
    timing
        Cold time per call [s].
    """

    limit: float
    binding: float
    solved: float
    excess: float
    timing: Timing


def random_legs(rng: np.random.Generator, feet: int) -> FloatArray:
    """Return the (3n, 3n) contact Jacobian of legs with three joints, lever arms of about 0.2 m."""
    jacobian = np.zeros((3 * feet, 3 * feet))
    for k in range(feet):
        jacobian[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = 0.2 * rng.normal(size=(3, 3))
    return jacobian


def time_torque_limits(count: int) -> list[TorqueRow]:
    """Return a row per limit, over `count` allocations near the cones' boundary."""
    instances = four_feet("near-boundary", count)
    rng = np.random.default_rng(0)
    jacobians = [random_legs(rng, i.mu.size) for i in instances]
    out = []
    with one_core():
        for limit in LIMITS:
            binding = solved = 0
            excess, seconds = -np.inf, np.full(count, np.inf)
            for k, (instance, jacobian) in enumerate(zip(instances, jacobians, strict=True)):
                distributor = ForceDistributor(
                    instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, FORCE_WEIGHT,
                    torque_limit=np.full(jacobian.shape[1], limit),
                )  # fmt: skip
                free = distributor.solve(instance.grasp_map, instance.wrench)
                binding += int(np.abs(jacobian.T @ free.ravel()).max() > limit)
                for _ in range(REPEATS):
                    distributor.reset()
                    start = time.perf_counter()
                    f = distributor.solve(instance.grasp_map, instance.wrench, jacobian=jacobian)
                    seconds[k] = min(seconds[k], time.perf_counter() - start)
                solved += distributor.status is Status.SOLVED
                excess = max(excess, float(np.abs(jacobian.T @ f.ravel()).max()) - limit)
            out.append(TorqueRow(limit, binding / count, solved / count, excess, Timing.of(seconds)))
    return out
