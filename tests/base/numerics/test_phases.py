import numpy as np

from surefoot.base.numerics.phases import debounced


def test_short_phases_are_none() -> None:
    time = 0.01 * np.arange(12)
    touch = np.array([0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1], dtype=bool)
    np.testing.assert_array_equal(debounced(time, touch, 0.015), [0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1])
    np.testing.assert_array_equal(debounced(time, touch, 0.005), touch)
    np.testing.assert_array_equal(debounced(time, ~touch, 0.015), [1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0])
