"""Kernels of a few lines, of several rooms, against NumPy."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact import blocks
from surefoot.kernels import borrowed, keep, kernel, window
from surefoot.solvers import admm, nsgs, stopping
from surefoot.stepping import arithmetic


@kernel
def _sums_of_windows(given: np.ndarray, sums: np.ndarray) -> float:
    """Read windows of an array and write through one of local memory, many times over: nothing is counted."""
    memory, total = np.zeros(40), 0.0
    for turn in range(1000):
        part, out = window(given, turn % 7, 3, 4), window(memory, 5, 4, 5)
        for i in range(3):
            for j in range(4):
                out[i, j] = part[i, j]
        total += borrowed(out)[2][3]
    for i in range(sums.size):
        sums[i] = memory[i]
    keep(memory)
    return total


def test_windows_and_borrowed_arrays() -> None:
    """Against slices and reshapes; the arrays that lent their memory are counted as before."""
    given, sums = np.random.default_rng(5).normal(size=(4, 6)), np.empty(40)
    held = sys.getrefcount(given)
    total = _sums_of_windows(given, sums)
    assert sys.getrefcount(given) == held
    flat = given.ravel()
    assert total == pytest.approx(sum(flat[turn % 7 + 11] for turn in range(1000)))
    expected = np.zeros((4, 5))
    expected[:3, :4] = flat[999 % 7 : 999 % 7 + 12].reshape(3, 4)
    assert np.array_equal(sums[5:25], expected.ravel())
    assert not sums[:5].any()
    assert not sums[25:].any()


def test_block_determinant() -> None:
    G = np.random.default_rng(0).normal(size=(9, 9))
    G = G + G.T
    for i in (0, 3, 6):
        expected = np.linalg.det(G[i : i + 3, i : i + 3] + 0.7 * np.eye(3))
        assert blocks.block_determinant(G, i, 0.7) == pytest.approx(expected)


def test_vectors_fit() -> None:
    fine = np.array([np.zeros(6), [0.5, 0.0, 0.0, 1.0, np.inf, 1.0]])
    assert blocks.vectors_fit(fine)
    wrong = [(0, 1, np.nan), (0, 1, np.inf)]
    wrong += [(1, 1, -0.1), (1, 1, np.inf), (1, 1, np.nan)]  # mu
    wrong += [(1, 3, -1.0), (1, 3, 2.0), (1, 3, np.nan)]  # normal_min
    wrong += [(1, 5, 0.5), (1, 5, np.nan)]  # normal_max
    for row, column, value in wrong:
        vectors = fine.copy()
        vectors[row, column] = value
        assert not blocks.vectors_fit(vectors)


def test_contacts_without_speed_rest_at_their_least_force() -> None:
    scales, forces = np.array([[1.0, 1.0, 0.0], [0.0, 2.0, 0.0]]), np.arange(9.0)
    stopping.settle(np.array([0.3, 0.3, -np.inf]), scales, forces)
    np.testing.assert_array_equal(forces, [0.0, 0.0, 0.3, 3.0, 4.0, 5.0, 0.0, 0.0, 0.0])
    measure = np.full((3, 2), np.nan)
    stopping.fill_measure(scales, measure)
    np.testing.assert_allclose(measure, [[1.0, 0.0], [1.0, 0.25], [1.0, 0.0]])


@kernel
def run_relaxation(gaps: np.ndarray) -> tuple[float, float, int]:
    relax, best, since = 1.0, np.inf, 0
    for gap in gaps:
        relax, best, since = nsgs.relaxation(gap, relax, best, since)
    return relax, best, since


def test_relaxation_halves_where_sweeps_go_in_circles() -> None:
    assert run_relaxation(np.array([1.0, 0.5, 0.2])) == (1.0, 0.2, 0)
    circle = np.ones(nsgs.CIRCLE + 2)
    assert run_relaxation(circle) == (0.5, 10.0, 0)
    assert run_relaxation(np.ones(200 * (nsgs.CIRCLE + 2)))[0] == 0.05


@pytest.mark.parametrize("law", ["coulomb", "convex"])
def test_sweeps_end_where_projected_steps_end(law: str) -> None:
    """Dense and block form, against projected fixed-point steps in NumPy on a well-conditioned problem."""
    rng = np.random.default_rng(3)
    J = rng.normal(size=(12, 40))
    p = sf.ContactProblem(J @ J.T / 40.0 + np.eye(12), rng.normal(size=12), np.full(4, 0.4), law=law)  # type: ignore[arg-type]
    expected, cone, step = np.zeros((4, 3)), sf.FrictionCone(0.4), 0.5 / np.linalg.norm(p.G, 2)
    for _ in range(3000):
        u = (p.G @ expected.ravel() + p.g).reshape(4, 3)
        u[:, 2] += 0.4 * np.hypot(u[:, 0], u[:, 1]) * (law == "coulomb")
        expected = cone.project(expected - step * u)
    b, laws = p.blocks, (p.mu, p.normal_min, p.normal_max, law == "convex", 1e-12, 500)
    for sparse in (False, True):
        forces, state = np.zeros(12), np.array([1.0, np.inf, 0.0])
        if sparse:
            local = nsgs.prepare_blocks(b.starts, b.columns, b.values, p.scales)
            count, done = nsgs.run_blocks(b.starts, b.columns, b.values, p.g, *laws, local, forces, state)
        else:
            local = nsgs.prepare_dense(p.G, p.scales)
            count, done = nsgs.run_dense(p.G, p.g, *laws, local, forces, state)
        assert done
        assert count < 500
        np.testing.assert_allclose(forces.reshape(4, 3), expected, atol=1e-10)


def test_mean_work_and_swerves() -> None:
    rng = np.random.default_rng(1)
    impulses, arriving, leaving = rng.normal(size=(3, 4, 3))
    impulses[:, 2] = [1.0, 2.0, 0.0, 3.0]  # the third touches nothing
    work, push = arithmetic.mean_work(impulses, arriving, leaving)
    assert work == pytest.approx(0.5 * np.sum(impulses * (arriving + leaving)))
    assert push == pytest.approx(6.0)
    J, v, foot = rng.normal(size=(12, 7)), rng.normal(size=7), np.array([0, 0, 0, 1])
    frames = np.linalg.qr(rng.normal(size=(4, 3, 3)))[0]
    found = arithmetic.swerves(J, v, leaving, impulses, foot, frames, 0.0)
    assert found is not None
    u = (J @ v).reshape(4, 3)
    world = np.einsum("cij,cj->ci", frames, 0.5 * (u - leaving))
    expected = np.zeros((4, 3))
    for c, mates in ((0, [0, 1]), (1, [0, 1]), (3, [3])):
        expected[c] = frames[c].T @ world[mates].mean(axis=0)
    np.testing.assert_allclose(found[0], u, atol=1e-13)
    np.testing.assert_allclose(found[1], expected, atol=1e-13)
    assert arithmetic.swerves(J, v, leaving, impulses, foot, frames, 1e9) is None


def test_the_penalty_follows_the_relative_residuals() -> None:
    """Boyd et al. 2011, section 3.4.1: times the root of their quotient, by ten at most, within bounds."""
    z, y = np.array([0.5, -2.0, 1.0]), np.array([0.25, 0.0, -0.5])
    for primal, dual, factor in ((1.0, 1.0, None), (8.0, 0.5, 2.0), (0.2, 0.8, 0.25), (4e9, 1.0, 10.0)):
        ratio = (primal / 2.0) / (dual / 0.5)
        expected = 3.0 if 1 / 3 <= ratio <= 3.0 else 3.0 * min(max(np.sqrt(ratio), 0.1), 10.0)
        found = admm.next_penalty(3.0, 3.0, primal, dual, z, y, 1.0)
        assert found == pytest.approx(expected, rel=1e-15)
        assert factor is None or found == pytest.approx(3.0 * factor)
    assert admm.next_penalty(1e6, 1e6, 1e9, 1.0, z, y, 1.0) == 1e6  # the upper bound, 1e6 of the largest
    assert admm.next_penalty(2.0, 1.9, 1.0, 1e-30, z, y, 1e-7) == pytest.approx(0.1)
