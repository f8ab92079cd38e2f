"""The judges of force distribution: decimal arithmetic, and the table that it fills."""

from decimal import Decimal, localcontext
from itertools import islice

import numpy as np
import pytest

from benchmarks.forces.accuracy import measure_accuracy
from benchmarks.forces.digits import DIGITS, exact_forces, exactly, project
from benchmarks.problems.allocation_program import cone_violation, objective, program
from benchmarks.problems.allocations import WRENCH_WEIGHTS, random_instances
from tests.mechanics.statics.distributors import convex_error, distributor_of


@pytest.mark.parametrize("force_weight", [1e-1, 1e-2, 1e-4])
def test_ours_are_near_the_exact_forces(force_weight):
    """A sample of the ten thousand instances of `surefoot bench forces --instances 10000`."""
    found = measure_accuracy(islice(random_instances(10_000), 120), force_weight)
    assert found.instances == 120
    assert found.not_solved == 0
    assert found.error[2] <= 1e-7
    assert found.cone_violation <= 1e-9


def test_exact_forces_are_optimal_by_the_problem_alone():
    for instance in random_instances(20, seed=6):
        f = exact_forces(instance, np.zeros((instance.mu.size, 3)), 0.1)
        A, w, bounds = instance.grasp_map, instance.wrench, (instance.normal_min, instance.normal_max)
        G = A.T @ (WRENCH_WEIGHTS[:, None] * A) + 0.1 * np.eye(A.shape[1])
        assert convex_error(G, -A.T @ (WRENCH_WEIGHTS * w), f, instance.mu, *bounds) < 1e-9
        assert cone_violation(instance, f) < 1e-12
        p = program(instance, force_weight=0.1)
        least = objective(p, f.ravel())
        rng = np.random.default_rng(0)
        for _ in range(20):
            other = f + 0.1 * rng.normal(size=f.shape)
            other = np.array(
                [
                    project(exactly(x), *(Decimal(float(v)) for v in (m, low, high)))[0].astype(float)
                    for x, m, low, high in zip(
                        other, instance.mu, instance.normal_min, instance.normal_max, strict=True
                    )
                ]
            )
            assert objective(p, other.ravel()) >= least * (1.0 - 1e-12)


@pytest.mark.parametrize("seed", range(60))
def test_decimal_projection_and_its_jacobian(seed):
    rng = np.random.default_rng(seed)
    point, mu, low = rng.normal(size=3) * 5.0, rng.uniform(0.0, 1.5), rng.uniform(0.0, 2.0)
    cone = [Decimal(v) for v in (mu, low, low + 2.0)]
    value, J = project(exactly(point), *cone)
    t, h = float(np.hypot(*point[:2])), Decimal("1e-20")
    assert float(value[2]) == pytest.approx(
        np.clip(point[2] if t <= mu * point[2] else max((mu * t + point[2]) / (1 + mu**2), 0.0), low, low + 2)
    )
    assert np.hypot(*value[:2].astype(float)) <= mu * float(value[2]) + 1e-12
    for j in range(3):
        with localcontext(prec=DIGITS):
            ahead = exactly(point)
            ahead[j] += h
            slope = (project(ahead, *cone)[0] - project(exactly(point), *cone)[0]) / h
        np.testing.assert_allclose(slope.astype(float), J[:, j].astype(float), atol=1e-12)


@pytest.mark.parametrize("force_weight", [1e-2, 1e-5, 1e-7])
def test_the_error_bound_holds_to_fifty_digits(force_weight):
    for instance in random_instances(60, seed=21):
        distributor = distributor_of(instance, force_weight)
        f = distributor.solve(instance.grasp_map, instance.wrench)
        distance = np.linalg.norm(f - exact_forces(instance, f, force_weight))
        assert distance <= distributor.force_error + 1e-11
        assert distance <= 1e-5
