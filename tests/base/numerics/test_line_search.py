"""The search along a step, on derivatives of every shape."""

import numpy as np
import pytest

from surefoot.base.kernels import kernel
from surefoot.base.numerics.line_search import search


@kernel
def stairs(memory, t):
    steps, heights, slope = memory
    total = slope * t
    for k in range(steps.size):
        if t > steps[k]:
            total += heights[k]
    return total - 1.0


@kernel
def cubic(memory, t):
    return memory[0] * t**3 - memory[1]


@kernel
def run_stairs(memory, at_0, at_1, share):
    return search(stairs, memory, at_0, at_1, share)


@kernel
def run_cubic(memory, at_0, at_1, share):
    return search(cubic, memory, at_0, at_1, share)


@pytest.mark.parametrize("share", [0.1, 1e-6])
def test_smooth_derivatives_end_as_near_as_asked(share):
    for top in (1.001, 2.0, 1e4):
        t = run_cubic((top, 1.0), -1.0, top - 1.0, share)
        assert abs(top * t**3 - 1.0) <= share
        assert t == pytest.approx(top ** (-1.0 / 3.0), abs=share)


@pytest.mark.parametrize("seed", range(20))
def test_a_staircase_ends_at_the_step_that_crosses_zero(seed):
    rng = np.random.default_rng(seed)
    steps, heights = np.sort(rng.uniform(0.05, 0.95, 4)), rng.uniform(0.5, 2.0, 4)
    values = 1e-9 - 1.0 + np.concatenate([[0.0], np.cumsum(heights)])
    if values[-1] <= 0.0:
        heights *= 4.0
        values = -1.0 + np.concatenate([[0.0], np.cumsum(heights)])
    crossing = steps[np.flatnonzero(values > 0.0)[0] - 1]
    memory = steps, heights, 1e-9
    t = run_stairs(memory, stairs(memory, 0.0), stairs(memory, 1.0), 1e-3)
    assert t == pytest.approx(crossing, abs=1e-5)
