"""What a run's summary says: only what was found, and whether its times are its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from surefoot.app.cli.run_output import busy_line, load_lines
from surefoot.records.audit import WalkSummary
from surefoot.records.log import Log


def summary(mass: float, force: tuple[float, ...] = (0.0, 0.0, -0.1), place: Any = None) -> WalkSummary:
    """Return what a walk of a robot of 15 kg found."""
    load = SimpleNamespace(mass=mass, place=place, force=force, moment=(0.0, 0.01, 0.0))
    return cast(WalkSummary, SimpleNamespace(mass=15.0, load=load))


def test_a_load_is_told_where_one_was_found() -> None:
    assert load_lines(summary(-0.004)) == []
    assert load_lines(summary(5.0, place=(0.1, 0.08))) == [
        "estimated: the base carries 5.00 kg at (0.100, 0.080) m from its origin"
    ]
    assert load_lines(summary(0.01, (30.0, -0.01, 0.0))) == [
        "estimated: the base is pulled by (30.0 0.0 0.0) N"
    ]


@pytest.mark.parametrize(("cpu", "lines"), [(1.9, 0), (1.0, 1)])
def test_times_of_a_busy_machine_are_told(cpu: float, lines: int) -> None:
    log = Log({"time": np.zeros(3)}, {"wall_time": 2.0, "cpu_time": cpu})
    assert len(busy_line(log)) == lines
    assert busy_line(Log({"time": np.zeros(3)})) == []
