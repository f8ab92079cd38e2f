"""ForceDistributor from call to call: warm starts, contacts that come and go, copies."""

import pickle

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.allocations import (
    FORCE_WEIGHT,
    WRENCH_WEIGHTS,
    four_feet,
    pushed_stance,
)
from surefoot.contact.solvers.dual_newton import distribution_memory as distribution_work
from tests.mechanics.statics.distributors import SOLVED, distributor_of


def test_contacts_switch_without_a_trace():
    """Swing feet carry exactly zero, the others what a program without the swing feet gives."""
    instance = four_feet("near-boundary", 1)[0]
    distributor = distributor_of(instance)
    work = distributor.work
    for mask in ([1, 1, 1, 1], [1, 0, 1, 1], [1, 0, 0, 1], [0, 0, 0, 0], [0, 1, 1, 0], [1, 1, 1, 1]):
        on = np.array(mask, dtype=bool)
        f = distributor.solve(instance.grasp_map, instance.wrench, active=on)
        assert distributor.status is SOLVED
        assert np.all(f[~on] == 0.0)
        assert distributor.work is work
        if on.any():
            columns = np.repeat(on, 3)
            alone = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT)
            expected = alone.solve(instance.grasp_map[:, columns], instance.wrench)
            np.testing.assert_allclose(f[on], expected, atol=1e-6)


@pytest.mark.parametrize("slope", [0.0, 0.35])
def test_warm_start_halves_the_iterations_where_cones_are_active(slope):
    """A stance that is pushed where there is little friction, flat or on a slope: half as many as cold."""
    turn = np.array(
        [[np.cos(slope), 0.0, np.sin(slope)], [0.0, 1.0, 0.0], [-np.sin(slope), 0.0, np.cos(slope)]]
    )
    rotate = np.kron(np.eye(2), turn.T)
    counts, active = np.zeros(2), 0
    trajectory = pushed_stance(500)
    mu = 0.15 if slope == 0.0 else 0.42
    warm, cold = (sf.ForceDistributor(mu, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT) for _ in range(2))
    for instance in trajectory:
        w = rotate @ instance.wrench
        f = warm.solve(instance.grasp_map, w)
        cold.reset()
        np.testing.assert_allclose(f, cold.solve(instance.grasp_map, w), atol=2e-7)
        active += np.any(np.hypot(f[:, 0], f[:, 1]) >= mu * f[:, 2] * (1.0 - 1e-9))
        counts += warm.iterations, cold.iterations
    assert active > 300
    assert counts[0] <= 0.5 * counts[1]


def test_a_noisy_trajectory_is_not_foretold():
    """White noise on the wanted wrench: the guess stays with the last answer, and the answers are right."""
    rng = np.random.default_rng(1)
    trajectory = pushed_stance(300)
    warm, cold = distributor_of(trajectory[0]), distributor_of(trajectory[0])
    trusted = 0
    for instance in trajectory:
        w = instance.wrench + rng.normal(size=6) * [20.0, 20.0, 20.0, 4.0, 4.0, 4.0]
        f = warm.solve(instance.grasp_map, w)
        assert warm.status is SOLVED
        cold.reset()
        np.testing.assert_allclose(f, cold.solve(instance.grasp_map, w), atol=2e-7)
        trusted += warm._results[distribution_work.TREND] > 0.0
    assert trusted < 30


def test_a_copy_goes_on_by_itself():
    trajectory = pushed_stance(300)[30:130]
    distributor = distributor_of(trajectory[0])
    for instance in trajectory[:10]:
        distributor.solve(instance.grasp_map, instance.wrench)
    twin, counts = pickle.loads(pickle.dumps(distributor)), set()
    for instance in trajectory[10:]:
        f = distributor.solve(instance.grasp_map, instance.wrench)
        assert np.array_equal(f, twin.solve(instance.grasp_map, instance.wrench))
        assert twin.iterations == distributor.iterations
        counts.add(twin.iterations)
    assert len(counts) > 1
    twin.reset()
    assert twin.work[5, distribution_work.WARM] == 0.0


def test_warm_start_survives_a_trot():
    """Where feet lift off and land the warm start is no worse than a cold one."""
    feet = np.array([[1, 0, 0, 1], [1, 1, 1, 1], [0, 1, 1, 0], [1, 1, 1, 1]], dtype=bool)
    trajectory = pushed_stance(400)
    warm, cold = distributor_of(trajectory[0]), distributor_of(trajectory[0])
    counts = np.zeros(2)
    for k, instance in enumerate(trajectory):
        on = feet[(k // 10) % 4]
        f = warm.solve(instance.grasp_map, instance.wrench, active=on)
        cold.reset()
        np.testing.assert_allclose(f, cold.solve(instance.grasp_map, instance.wrench, active=on), atol=2e-7)
        if k % 10 == 0:
            counts += warm.iterations, cold.iterations + 1
    assert counts[0] < counts[1]
