"""Kernels of a few lines, of several rooms, against NumPy."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import surefoot as sf
from surefoot.kernels import borrowed, keep, kernel, window
from surefoot.solvers import nsgs


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
