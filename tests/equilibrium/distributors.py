"""What the tests of ForceDistributor share."""

import numpy as np

import surefoot as sf
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, random_rotation
from benchmarks.problems.allocations import grasp_map as grasp_map_of

SOLVED = sf.Status.SOLVED


def distributor_of(instance, **options):
    return sf.ForceDistributor(
        instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, FORCE_WEIGHT, **options
    )


def some_map(seed=0, n=4):
    rng = np.random.default_rng(seed)
    return grasp_map_of(
        np.array([random_rotation(rng) for _ in range(n)]), rng.uniform(-0.3, 0.3, (n, 3)) - [0, 0, 0.3]
    )
