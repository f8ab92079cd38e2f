"""Joint torque limits as exact rows."""

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.allocation_program import cone_rows, cone_violation, objective, program
from benchmarks.problems.allocations import FORCE_WEIGHT, WRENCH_WEIGHTS, Instance, four_feet
from surefoot.base.spatial import skew
from surefoot.contact.solvers.backends import ConeProgram, End, solve_program

SEVERITY = {"loose": 24.0, "tight": 12.0, "hopeless": 1.0}


def clarabel_with_rows(instance, T, low, high):
    """Return what Clarabel finds with rows low <= T f <= high."""
    p = program(instance)
    M, b = cone_rows(p)
    n = instance.mu.size
    rows = np.vstack([T, -T, M[: 2 * n]]), np.concatenate([high, -low, b[: 2 * n]])
    cones = M[2 * n :], b[2 * n :]
    return solve_program(ConeProgram.of(p.H, p.h, nonneg=rows, second_order=cones), tol=1e-11)


def legs(rng, n=4):
    """Return a block-diagonal (3n, 3n) Jacobian of three-joint legs and torque offsets."""
    J = np.zeros((3 * n, 3 * n))
    for k in range(n):
        J[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = rng.normal(size=(3, 3)) * 0.2
    return J, rng.normal(size=3 * n)


@pytest.mark.parametrize("severity", ["loose", "tight"])
@pytest.mark.parametrize("kind", ["easy", "near-boundary", "infeasible-wrench"])
def test_torque_limits_against_clarabel(kind, severity):
    rng = np.random.default_rng(5)
    bound = 0
    for instance in four_feet(kind, 40, seed=2):
        J, offset = legs(rng)
        limit = np.full(12, SEVERITY[severity])
        distributor = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=limit)
        f = distributor.solve(instance.grasp_map, instance.wrench, jacobian=J, torque_offset=offset)
        reference = clarabel_with_rows(instance, J.T, -limit - offset, limit - offset).solution()
        assert distributor.status is sf.Status.SOLVED
        excess = np.abs(J.T @ f.ravel() + offset).max() - limit[0]
        assert excess <= 1e-12
        assert excess == pytest.approx(distributor.torque_excess, abs=1e-9)
        assert cone_violation(instance, f) <= 1e-9
        p = program(instance)
        best = objective(p, reference)
        assert objective(p, f.ravel()) <= best * (1 + 1e-8)
        assert objective(p, f.ravel()) >= best * (1 - 1e-5)
        bound += excess > -1e-6
    assert bound > 10


def test_empty_set_is_told_and_violated_least():
    """Where Clarabel proves that no force fits, so do we, and no force has a smaller squared excess."""
    rng = np.random.default_rng(6)
    empty = kept = 0
    for k, instance in enumerate(four_feet("near-boundary", 90, seed=4)):
        J, offset = legs(rng)
        limit = np.full(12, SEVERITY["hopeless"] if k % 2 else 2.4)
        distributor = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=limit)
        f = distributor.solve(instance.grasp_map, instance.wrench, jacobian=J, torque_offset=offset)
        assert cone_violation(instance, f) <= 1e-9
        end = clarabel_with_rows(instance, J.T, -limit - offset, limit - offset).end
        assert (distributor.status is sf.Status.INFEASIBLE) == (end is End.INFEASIBLE)
        if end is not End.INFEASIBLE:  # barely possible: kept all the same
            assert distributor.torque_excess <= 1e-9
            kept += 1
            continue
        empty += 1

        def excess(x, J=J, offset=offset, limit=limit):
            return np.sum(np.maximum(np.abs(J.T @ x.ravel() + offset) - limit, 0.0) ** 2)

        cone = sf.ForceDistributor(0.6, 5.0, 250.0, 0.0, 1.0)
        for _ in range(20):
            near = f + rng.normal(size=(4, 3)) * 10.0 ** rng.uniform(-4, 1)
            other = cone.solve(instance.grasp_map, np.zeros(6), reference=near)
            assert excess(f) <= excess(other) * (1 + 1e-4)
    assert empty > 20
    assert kept > 10


def test_torque_limits_that_hold_by_themselves_change_nothing():
    instance = four_feet("easy", 1)[0]
    J, offset = legs(np.random.default_rng(0))
    free = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT)
    limited = sf.ForceDistributor(
        0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=np.full(12, 1e3)
    )
    f = limited.solve(instance.grasp_map, instance.wrench, jacobian=J, torque_offset=offset)
    assert np.array_equal(f, free.solve(instance.grasp_map, instance.wrench))
    assert limited.torque_excess < 0.0


def test_warm_torque_limits_agree_with_cold():
    rng = np.random.default_rng(8)
    instance = four_feet("near-boundary", 1)[0]
    J, offset = legs(rng)
    limit = np.full(12, 12.0)
    warm = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=limit)
    for k in range(40):
        w = instance.wrench * (1.0 + 0.1 * np.sin(0.2 * k))
        cold = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=limit)
        f = warm.solve(instance.grasp_map, w, jacobian=J, torque_offset=offset)
        g = cold.solve(instance.grasp_map, w, jacobian=J, torque_offset=offset)
        assert warm.status is cold.status is sf.Status.SOLVED
        np.testing.assert_allclose(f, g, atol=1e-5)


def test_rows_and_torques_take_turns():
    """Another number of rows gets its own work space, and neither disturbs the other."""
    instance = four_feet("near-boundary", 1)[0]
    J, offset = legs(np.random.default_rng(1))
    limit = np.full(12, 12.0)
    distributor = sf.ForceDistributor(0.6, 5.0, 250.0, WRENCH_WEIGHTS, FORCE_WEIGHT, torque_limit=limit)
    A, w = instance.grasp_map, instance.wrench
    total = np.zeros((1, 12))
    total[0, 2::3] = 1.0
    first = distributor.solve(A, w, jacobian=J, torque_offset=offset)
    bound = 0.8 * first[:, 2].sum()
    for _ in range(3):
        f = distributor.solve_with_rows(A, w, total, [0.0], [bound])
        assert f[:, 2].sum() == pytest.approx(bound, abs=1e-6)
        again = distributor.solve(A, w, jacobian=J, torque_offset=offset)
        np.testing.assert_allclose(again, first, atol=1e-5)


def limbs(rng, joints=7):
    """Return an allocation: three to eight points a limb, endless normal forces, and torque rows they share.

    Three joints of the trunk move every point, the other joints those of their own limb.
    """
    count = rng.integers(1, 5)
    sizes = rng.integers(3, 9, count)
    owner = np.repeat(np.arange(count), sizes)
    arms = rng.uniform(-0.7, 0.7, (count, 3))[owner] + rng.uniform(-0.1, 0.1, (owner.size, 3))
    n = owner.size
    A = np.hstack([np.vstack([np.eye(3), skew(arm)]) for arm in arms])
    J = np.zeros((3 * n, 3 + joints * count))
    for j in range(J.shape[1]):
        axis, place = rng.normal(size=3), rng.uniform(-0.5, 0.5, 3)
        axis /= np.linalg.norm(axis)
        moved = owner == (j - 3) // joints if j >= 3 else np.ones(n, dtype=bool)
        J[:, j] = (np.cross(axis, arms - place) * moved[:, None]).ravel()
    instance = Instance(
        A, np.array([0.0, 0, 330, 0, 0, 0]) + rng.normal(size=6) * [100, 100, 150, 30, 30, 10],
        np.full(n, 0.8), np.zeros(n), np.full(n, np.inf),
    )  # fmt: skip
    return instance, J, 25.0 * rng.normal(size=J.shape[1])


@pytest.mark.parametrize("seed", range(3))
def test_many_points_that_share_joints_against_clarabel(seed):
    """Soles, hands and knees of a humanoid: solved, or proven empty, as Clarabel says; nothing between."""
    rng = np.random.default_rng(seed)
    ends = {True: 0, False: 0}
    for _ in range(60):
        instance, J, offset = limbs(rng)
        limit = np.full(J.shape[1], rng.choice([80.0, 55.0, 40.0]))
        distributor = sf.ForceDistributor(
            0.8, 0.0, wrench_weights=WRENCH_WEIGHTS, force_weight=FORCE_WEIGHT, torque_limit=limit
        )
        f = distributor.solve(instance.grasp_map, instance.wrench, jacobian=J, torque_offset=offset)
        found = clarabel_with_rows(instance, J.T, -limit - offset, limit - offset)
        empty = found.end is End.INFEASIBLE
        ends[empty] += 1
        assert distributor.status is (sf.Status.INFEASIBLE if empty else sf.Status.SOLVED)
        assert cone_violation(instance, f) <= 1e-9
        if not empty:
            assert distributor.torque_excess <= 1e-9
            p = program(instance)
            best = objective(p, found.solution())
            assert abs(objective(p, f.ravel()) - best) <= 1e-6 * max(1.0, abs(best))
    assert ends[True] >= 5
    assert ends[False] >= 30
