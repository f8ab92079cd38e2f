"""What the tests of ForceDistributor share."""

import numpy as np

import surefoot as sf
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, random_rotation
from benchmarks.problems.allocations import grasp_map as grasp_map_of

SOLVED = sf.Status.SOLVED


def distributor_of(instance, force_weight=FORCE_WEIGHT, **options):
    return sf.ForceDistributor(
        instance.mu, instance.normal_min, instance.normal_max, WRENCH_WEIGHTS, force_weight, **options
    )


def convex_error(G, g, f, mu=0.6, low=5.0, high=250.0):
    """Return how far forces are from the least of f·Gf/2 + g·f over the cones."""
    return sf.residuals(sf.ContactProblem(G, g, mu, low, high, law="convex"), f).velocity_error


def some_map(seed=0, n=4):
    rng = np.random.default_rng(seed)
    return grasp_map_of(
        np.array([random_rotation(rng) for _ in range(n)]), rng.uniform(-0.3, 0.3, (n, 3)) - [0, 0, 0.3]
    )
