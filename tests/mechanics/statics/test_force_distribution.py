"""ForceDistributor against its own error bound, and on everything that can go wrong.

`tests/benchmarks/test_forces_accuracy.py` holds it to Clarabel and to fifty digits.
"""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from benchmarks.problems.allocation_program import cone_violation
from benchmarks.problems.allocations import (
    FORCE_WEIGHT,
    WRENCH_WEIGHTS,
    four_feet,
    pushed_stance,
    random_instances,
)
from benchmarks.problems.allocations import grasp_map as grasp_map_of
from surefoot.contact.solvers.dual_newton import wrench_distribution as distribution_wrench
from tests.mechanics.statics.distributors import SOLVED, convex_error, distributor_of, some_map


@pytest.mark.parametrize("force_weight", [1e-1, 1e-3, 1e-5, 1e-7, 1e-9])
def test_hard_instances_are_solved_whatever_the_force_weight(force_weight):
    for instance in random_instances(200, seed=11):
        distributor = distributor_of(instance, force_weight)
        f = distributor.solve(instance.grasp_map, instance.wrench)
        assert distributor.status is SOLVED
        assert distributor.iterations <= 100
        assert cone_violation(instance, f) <= 1e-9


def test_error_bound_holds():
    """The true distance to the optimum is below `force_error`, also when Newton is cut short."""
    tight = 0
    for instance in random_instances(200, seed=3):
        exact = distributor_of(instance, tol=1e-10).solve(instance.grasp_map, instance.wrench)
        short = distributor_of(instance, max_iterations=1)
        # four feet with one Newton step: far from the optimum, but the bound knows how far
        f = short.solve(instance.grasp_map, instance.wrench)
        distance = np.linalg.norm(f - exact)
        assert distance <= short.force_error + 1e-7
        tight += distance > 1e-3 * short.force_error > 0.0
    assert tight > 20


@settings(max_examples=150, deadline=None)
@given(
    st.integers(0, 10**6), st.integers(1, 8), st.floats(0.0, 3.0), st.floats(0.0, 100.0), st.floats(0.0, 1e4),
    st.floats(-8.0, 2.0), st.floats(-1.0, 6.0), st.integers(1, 100),
)  # fmt: skip
def test_forces_are_always_feasible(seed, n, mu, low, extra, weight_power, wrench_power, limit):
    rng = np.random.default_rng(seed)
    w = rng.normal(size=6) * 10.0**wrench_power
    distributor = sf.ForceDistributor(
        mu, low, low + extra, rng.uniform(0.0, 2.0, 6), 10.0**weight_power, max_iterations=limit
    )
    A = some_map(seed, n)
    for scale in (1.0, -1.0, 0.3):  # the second and third start from a wrong place
        f = distributor.solve(A, scale * w)
        assert f.shape == (n, 3)
        assert np.all(np.hypot(f[:, 0], f[:, 1]) <= mu * f[:, 2] + 1e-9)
        assert np.all((f[:, 2] >= low) & (f[:, 2] <= low + extra))
        assert distributor.iterations <= limit
        assert distributor.status is not sf.Status.INVALID


@pytest.mark.parametrize(
    ("mu", "low", "high"),
    [(0.0, 5.0, 250.0), (0.6, 40.0, 40.0), (0.0, 40.0, 40.0), (1e-12, 0.0, 250.0), (50.0, 0.0, 1e9)],
)
@pytest.mark.parametrize("n", [1, 2, 4, 8])
def test_degenerate_cones_are_solved(mu, low, high, n):
    rng = np.random.default_rng(n)
    for k in range(20):
        A, w = some_map(k, n), rng.normal(size=6) * 100.0
        distributor = sf.ForceDistributor(mu, low, high, 1.0, 1e-2)
        f = distributor.solve(A, w)
        assert distributor.status is SOLVED
        assert convex_error(A.T @ A + 1e-2 * np.eye(3 * n), -A.T @ w, f, mu, low, high) < 1e-8


def test_collinear_and_coincident_contacts():
    rng = np.random.default_rng(0)
    for arms in (np.outer(np.linspace(-1, 1, 5), [0.3, 0.1, 0.0]), np.zeros((4, 3))):
        A = grasp_map_of(np.array([np.eye(3)] * len(arms)), arms - [0, 0, 0.3])
        for _ in range(20):
            w = rng.normal(size=6) * 50.0 + [0, 0, 160, 0, 0, 0]
            distributor = sf.ForceDistributor(0.6, 0.0, 250.0, 1.0, 1e-3)
            f = distributor.solve(A, w)
            assert distributor.status is SOLVED
            assert convex_error(A.T @ A + 1e-3 * np.eye(A.shape[1]), -A.T @ w, f, low=0.0) < 1e-8


def test_no_contacts_and_no_friction_budget():
    distributor = sf.ForceDistributor(0.6, 0.0, 100.0, 1.0, 1e-3)
    assert distributor.solve(np.zeros((6, 0)), np.ones(6)).shape == (0, 3)
    assert distributor.wrench_error == pytest.approx(np.sqrt(6.0))
    all_off = sf.ForceDistributor(0.6, 0.0, 0.0, 1.0, 1e-3)
    assert np.array_equal(all_off.solve(some_map(), np.ones(6)), np.zeros((4, 3)))


def test_reference_and_smoothness_are_quadratic_terms():
    instance = four_feet("near-boundary", 1)[0]
    A, w = instance.grasp_map, instance.wrench
    wanted = np.tile([3.0, -2.0, 60.0], (4, 1))
    r, s = 0.05, 0.4
    distributor = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, r, smoothness=s)
    last = np.zeros((4, 3))
    for turn in range(4):
        f = distributor.solve(A, (1 + 0.2 * turn) * w, wanted)
        G = A.T @ (WRENCH_WEIGHTS[:, None] * A) + (r + s) * np.eye(12)
        g = -A.T @ (WRENCH_WEIGHTS * (1 + 0.2 * turn) * w) - r * wanted.ravel() - s * last.ravel()
        assert convex_error(G, g, f) < 1e-9
        last = f
    distributor.reset(np.full((4, 3), 7.0))
    g = -A.T @ (WRENCH_WEIGHTS * w) - r * wanted.ravel() - s * 7.0
    f = distributor.solve(A, w)
    assert convex_error(G, g, f) < 1e-9


def test_tangential_and_normal_weights():
    instance = four_feet("near-boundary", 1)[0]
    A, w = instance.grasp_map, instance.wrench
    weights = np.column_stack([np.full(4, 0.3), np.full(4, 0.02)])
    wanted, s = np.tile([4.0, -8.0, 30.0], (4, 1)), 0.1
    f = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, weights, smoothness=s).solve(A, w, wanted)
    r = np.tile([0.3, 0.3, 0.02], 4)
    G = A.T @ (WRENCH_WEIGHTS[:, None] * A) + np.diag(r + s)
    g = -A.T @ (WRENCH_WEIGHTS * w) - r * wanted.ravel()
    assert convex_error(G, g, f) < 1e-9


def test_anything_array_like_is_taken_and_compiles_nothing_new():
    instance = four_feet("easy", 1)[0]
    A, w = instance.grasp_map, instance.wrench
    distributor = distributor_of(instance)
    expected = distributor.solve(A, w)
    signatures = len(distribution_wrench.distribute_wrench.signatures)
    for map_like in (np.asfortranarray(A), A.tolist(), np.hstack([A, A])[:, :12], A[::-1][::-1]):
        np.testing.assert_allclose(distributor.solve(map_like, list(w)), expected, atol=1e-7)
    assert distributor.solve(A.astype(np.float32), w).dtype == np.float64
    for array in (A, w):
        array.setflags(write=False)
    np.testing.assert_allclose(distributor.solve(A, w), expected, atol=1e-7)
    assert len(distribution_wrench.distribute_wrench.signatures) == signatures


def test_solve_allocates_only_what_it_returns():
    trajectory = pushed_stance(200)
    distributor = distributor_of(trajectory[0])
    for instance in trajectory[:50]:
        distributor.solve(instance.grasp_map, instance.wrench)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for instance in trajectory:
            distributor.solve(instance.grasp_map, instance.wrench)
        assert tracemalloc.get_traced_memory()[0] - before < 2000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mu": -0.1}, r"mu\[0\] must be >= 0"),
        ({"mu": np.inf}, "mu must be finite"),
        ({"mu": [0.5, 0.6], "normal_max": [1.0, 2.0, 3.0]}, "agree on the number of contacts"),
        ({"mu": [0.5, 0.6], "normal_min": [1.0, 9.0], "normal_max": 5.0}, "at contact 1"),
        ({"mu": 0.5, "wrench_weights": [1.0, 2.0]}, "wrench_weights must be a number or have shape"),
        ({"mu": 0.5, "wrench_weights": -1.0}, "wrench_weights must be >= 0"),
        ({"mu": [0.5], "force_weight": 0.0}, "force_weight must be positive"),
        ({"mu": [0.5], "force_weight": [[1.0, 2.0, 3.0]]}, "force_weight must be a number"),
        ({"mu": 0.5, "smoothness": -1.0}, "smoothness"),
        ({"mu": 0.5, "smoothness": np.inf}, "smoothness"),
        ({"mu": 0.5, "max_iterations": 0}, "max_iterations"),
        ({"mu": [0.5, np.nan]}, r"mu\[1\] is NaN"),
        ({"mu": 0.5, "torque_limit": [1.0, -1.0]}, "torque_limit must be >= 0"),
    ],
)
def test_bad_parameters_are_named(arguments, message):
    with pytest.raises(sf.ProblemError, match=message):
        sf.ForceDistributor(**arguments).solve(some_map(n=1), np.ones(6))


def test_bad_shapes_are_named():
    fixed = sf.ForceDistributor([0.5, 0.5, 0.5, 0.5])
    free = sf.ForceDistributor(0.5)
    A = some_map()
    with pytest.raises(sf.ProblemError, match=r"grasp_map must have shape \(6, 12\), got \(6, 9\)"):
        fixed.solve(A[:, :9], np.ones(6))
    with pytest.raises(sf.ProblemError, match=r"grasp_map must have shape \(6, 3n\), got \(6, 11\)"):
        free.solve(A[:, :11], np.ones(6))
    with pytest.raises(sf.ProblemError, match=r"wrench must have shape \(6,\), got \(5,\)"):
        free.solve(A, np.ones(5))
    with pytest.raises(sf.ProblemError, match="active must have shape"):
        fixed.solve(A, np.ones(6), active=[True])
    with pytest.raises(sf.ProblemError, match="reference must have shape"):
        fixed.solve(A, np.ones(6), reference=np.zeros(12))
    with pytest.raises(sf.ProblemError, match="without torque_limit"):
        fixed.solve(A, np.ones(6), jacobian=np.zeros((12, 3)))
    with pytest.raises(sf.ProblemError, match="must be arrays of numbers"):
        fixed.solve(A, ["a"] * 6)
    with pytest.raises(sf.ProblemError, match=r"rows must have shape \(k, 12\)"):
        fixed.solve_with_rows(A, np.ones(6), np.ones((2, 11)), [0.0, 0.0], [1.0, 1.0])
    with pytest.raises(sf.ProblemError, match="at contact 2"):
        fixed.set_bounds([0.0, 0.0, 3.0, 0.0], [1.0, 1.0, 2.0, 1.0])


def test_number_of_contacts_follows_the_grasp_map_of_scalar_parameters():
    distributor = sf.ForceDistributor(0.6, 0.0, 100.0, 1.0, 1e-3)
    for n in (4, 2, 8):
        assert distributor.solve(some_map(n, n), np.ones(6)).shape == (n, 3)
        assert distributor.status is SOLVED


def test_set_bounds_equals_a_new_distributor():
    instance = four_feet("near-boundary", 1)[0]
    distributor = distributor_of(instance)
    distributor.solve(instance.grasp_map, instance.wrench)
    low, high = np.array([0.0, 10.0, 0.0, 5.0]), np.array([40.0, 60.0, 0.0, 80.0])
    distributor.set_bounds(low, high)
    f = distributor.solve(instance.grasp_map, instance.wrench)
    fresh = sf.ForceDistributor(0.6, low, high, WRENCH_WEIGHTS, FORCE_WEIGHT)
    np.testing.assert_allclose(f, fresh.solve(instance.grasp_map, instance.wrench), atol=1e-6)
