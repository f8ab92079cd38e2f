"""Where a derivative along a step has all but vanished: false position, kept from crawling."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from surefoot.base.kernels import kernel, takes_kernels

Memory = TypeVar("Memory")
EVALUATIONS = 60
"""Bound on the evaluations of one search."""


@kernel
@takes_kernels
def search(
    derivative: Callable[[Memory, float], float], memory: Memory, at_0: float, at_1: float, share: float
) -> float:
    """Return a t in (0, 1) at which |derivative(memory, t)| is at most `share` of that at 0.

    The derivative rises from `at_0` < 0 at 0 to `at_1` > 0 at 1. False position with the Illinois rule (an
    end that stays counts half), and a bisection every third time because it may be almost a staircase.
    """
    left, right, f_left, f_right = 0.0, 1.0, at_0, at_1
    t, side = 1.0, 0
    for k in range(EVALUATIONS):
        t = (left * f_right - right * f_left) / (f_right - f_left)
        if k % 3 == 2:
            t = 0.5 * (left + right)
        f = derivative(memory, t)
        if abs(f) <= -share * at_0:
            break
        if f < 0.0:
            left, f_left = t, f
            f_right = 0.5 * f_right if side < 0 else f_right
            side = -1
        else:
            right, f_right = t, f
            f_left = 0.5 * f_left if side > 0 else f_left
            side = 1
    return t
