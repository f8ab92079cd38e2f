"""Ranges of axes: no smaller than what means something, and nothing is left out silently."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.viz.ranges import at_least, mark_worst, most_of
from surefoot.viz.style import new_axis

TIME = np.linspace(0.0, 1.0, 11)


def test_a_flat_curve_gets_the_least_range() -> None:
    _, axis = new_axis((3.0, 2.0))
    at_least(axis, 1e-9 * TIME, 0.1)
    low, high = axis.get_ylim()
    assert high - low == pytest.approx(0.1 * 1.16)
    assert low < 0.0 < high
    at_least(axis, np.array([-2.0, 3.0]), 0.1)
    assert axis.get_ylim()[0] < -2.0
    assert axis.get_ylim()[1] > 3.0


def test_what_is_beyond_the_range_is_marked_with_its_value() -> None:
    _, axis = new_axis((3.0, 2.0))
    curve = np.sin(6.0 * TIME)
    curve[4], curve[8] = 70.0, -50.0
    most_of(axis, TIME, curve, -2.0, 2.0, "N")
    assert axis.get_ylim() == (-2.0, 2.0)
    assert sorted(text.get_text() for text in axis.texts) == ["-50 N", "70 N"]
    assert [line.get_xdata()[0] for line in axis.lines] == pytest.approx([0.4, 0.8])


def test_what_fits_gets_no_mark() -> None:
    _, axis = new_axis((3.0, 2.0))
    most_of(axis, TIME, np.column_stack([TIME, -TIME]), -2.0, 2.0)
    assert not axis.texts
    mark_worst(axis, 0.9, 0.5, "here")
    assert [text.get_text() for text in axis.texts] == ["here"]
