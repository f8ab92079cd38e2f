"""The memory of the force distribution: what goes in and comes out, against NumPy."""

import numpy as np
import pytest

from surefoot.kernels import kernel
from surefoot.solvers.dual_newton import work as layout

N = 4


@pytest.fixture
def memory():
    """Return a work space full of numbers, the third contact off."""
    rng = np.random.default_rng(0)
    work = rng.normal(size=layout.new_work(N).shape)
    work[:N, [layout.TANGENT, layout.NORMAL]] = rng.uniform(0.5, 2.0, (N, 2))
    work[:N, layout.MU] = 0.6
    low, high = np.array([1.0, 2.0, 3.0, 0.0]), np.array([50.0, 60.0, 70.0, np.inf])
    layout.set_limits(work, low, high, np.array([True, True, False, True]))
    return work


def block(work, k):
    return work[k, layout.BLOCK : layout.BLOCK + 18].reshape(3, 6).T


@kernel
def run_store(work, k, at, six, three):
    layout.store(work, k, at, six)
    layout.store_vector(work, k, at + 6, three)
    return layout.column(work, k, at), layout.vector(work, k, at + 6), layout.combine(work, k, three)


def test_rows_hold_what_is_stored(memory):
    six, three = np.arange(6.0), np.array([7.0, -8.0, 9.0])
    column, vector, wrench = run_store(memory, 1, layout.POINT, tuple(six), tuple(three))
    assert column == tuple(six) == tuple(memory[1, layout.POINT : layout.POINT + 6])
    assert vector == tuple(three) == tuple(memory[1, layout.POINT + 6 : layout.POINT + 9])
    np.testing.assert_allclose(wrench, block(memory, 1) @ three, rtol=1e-12)


def test_a_grasp_map_is_loaded_in_scaled_units(memory):
    rng = np.random.default_rng(1)
    A, w = rng.normal(size=(6, 3 * N)), rng.normal(size=6)
    roots, on = memory[N, layout.ROOT : layout.ROOT + 6], memory[:N, layout.HIGH] > 0.0
    norm, check = layout.load(A, memory, N)
    total = 0.0
    for k in range(N):
        units = np.array([memory[k, layout.TANGENT]] * 2 + [memory[k, layout.NORMAL]])
        expected = roots[:, None] * A[:, 3 * k : 3 * k + 3] * units * on[k]
        np.testing.assert_allclose(block(memory, k), expected, rtol=1e-12, atol=1e-15)
        total += np.sum(expected**2)
        pull, drag = memory[k, layout.PULL :][:2], memory[k, layout.DRAG :][:2]
        reference, last = memory[k, layout.REFERENCE :][:3], memory[k, layout.LAST :][:3]
        np.testing.assert_allclose(
            memory[k, layout.CENTRE :][:3], pull[[0, 0, 1]] * reference + drag[[0, 0, 1]] * last, rtol=1e-12
        )
    assert (norm, check) == (pytest.approx(total), 0.0)
    np.testing.assert_allclose(layout.weigh(w, memory, N), roots * w, rtol=1e-12)
    A[2, 4] = np.nan
    assert np.isnan(layout.load(A, memory, N)[1])


def test_forces_leave_in_newtons_and_within_their_bounds(memory):
    forces = np.full((N, 3), np.nan)
    memory[0, layout.FORCE + 2] = 1e6
    layout.unload(memory, N, forces)
    units = memory[:N, [layout.TANGENT, layout.TANGENT, layout.NORMAL]]
    expected = memory[:N, layout.FORCE : layout.FORCE + 3] * units
    expected[:, 2] = np.clip(expected[:, 2], memory[:N, layout.FLOOR], memory[:N, layout.CEILING])
    expected[2] = 0.0
    np.testing.assert_allclose(forces, expected, rtol=1e-12)
    np.testing.assert_array_equal(memory[:N, layout.LAST : layout.LAST + 3], forces)


@pytest.mark.parametrize("known", [True, False])
def test_holding_brings_the_last_command_into_the_cones(memory, known):
    memory[N + 1, layout.HAS_LAST] = float(known)
    memory[:N, layout.MU] = 0.6 * memory[:N, layout.NORMAL] / memory[:N, layout.TANGENT]
    forces = np.full((N, 3), np.nan)
    layout.hold(memory, N, forces)
    for k in range(N):
        low, high = memory[k, layout.FLOOR], memory[k, layout.CEILING]
        assert low - 1e-12 <= forces[k, 2] <= high
        assert np.hypot(*forces[k, :2]) <= 0.6 * forces[k, 2] + 1e-12
        if not known:
            np.testing.assert_allclose(forces[k], [0.0, 0.0, low], atol=1e-12)
    assert np.isinf(memory[N + 1, [layout.GAP, layout.FORCE_ERROR, layout.WRENCH_ERROR]]).all()
    inside = tuple(np.array([0.1, 0.0, 0.5 * (memory[0, layout.LOW] + memory[0, layout.HIGH])]))
    assert layout.project(memory, 0, inside) == inside


def test_what_is_left_of_the_wrench(memory):
    b = np.random.default_rng(2).normal(size=6)
    left = layout.remainder(memory, N, tuple(b))
    forces = memory[:N, layout.FORCE : layout.FORCE + 3]
    expected = sum(block(memory, k) @ forces[k] for k in (0, 1, 3)) - b
    np.testing.assert_allclose(left, expected, rtol=1e-12, atol=1e-12)
    assert layout.measure(memory, N, left, 0.09) == pytest.approx(expected @ expected)
    widest = memory[:N, [layout.TANGENT, layout.NORMAL]].max()
    results = memory[N + 1, [layout.GAP, layout.FORCE_ERROR, layout.WRENCH_ERROR]]
    np.testing.assert_allclose(results, [0.045, 0.3 * widest, np.linalg.norm(expected)], rtol=1e-12)
