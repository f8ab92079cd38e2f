import numpy as np

from surefoot.base.numerics.phases import debounced, joined_runs, runs_of


def test_short_phases_are_none() -> None:
    time = 0.01 * np.arange(12)
    touch = np.array([0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1], dtype=bool)
    np.testing.assert_array_equal(debounced(time, touch, 0.015), [0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1])
    np.testing.assert_array_equal(debounced(time, touch, 0.005), touch)
    np.testing.assert_array_equal(debounced(time, ~touch, 0.015), [1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0])


def test_runs_with_short_gaps_are_joined() -> None:
    on = np.array([0, 1, 1, 0, 1, 0, 0, 0, 1], dtype=bool)
    assert joined_runs(on) == runs_of(on) == [(1, 3), (4, 5), (8, 9)]
    assert joined_runs(on, 2) == [(1, 5), (8, 9)]
    assert joined_runs(on, 3) == [(1, 5), (8, 9)], "a gap of three rows parts"
    assert joined_runs(on, 4) == [(1, 9)]
    assert joined_runs(np.zeros(4, dtype=bool), 9) == []
