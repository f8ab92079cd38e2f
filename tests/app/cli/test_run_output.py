"""What a run's summary says: only what was found, and whether its times are its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from surefoot.app.cli.run_output import busy_line, law_table, load_lines
from surefoot.records.audit import WalkSummary
from surefoot.records.audit.laws import LawFigures
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


@pytest.mark.parametrize(("sinking", "stopping"), [(0.0, 0.0), (0.0004, 0.0077), (0.00104, 0.00777)])
def test_the_table_prints_the_limits_that_the_verdict_uses(sinking: float, stopping: float) -> None:
    """A hundredth less than each printed limit is lawful, a hundredth more is named with that limit."""

    def lines(share: float) -> list[str]:
        depth, way = share * max(1e-3, sinking), share * (1e-3 + stopping)
        return figures(depth, way).broken(100.0)

    def figures(depth: float, way: float) -> LawFigures:
        return LawFigures(
            depth, 0.0, 0.0, 0.0, 0.0, 0.0, free_slide_max=way, sinking=sinking, stopping=stopping
        )

    assert lines(0.99) == []
    told = [line.partition("(limit ")[2].rstrip(")") for line in lines(1.01)]
    table = law_table(SimpleNamespace(laws=figures(0.0, 0.0)))
    printed = {str(row[0]).partition(": ")[2]: str(row[2]).removesuffix(" mm") for row in table.rows}
    assert [printed["deepest penetration"], printed["slide without friction"]] == told
