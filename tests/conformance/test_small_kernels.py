"""Kernels of a few lines, of several rooms, against NumPy."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from surefoot.base.kernels import borrowed, keep, kernel, window


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
