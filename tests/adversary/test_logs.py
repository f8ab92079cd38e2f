"""Attempts to make a summary fail with a traceback, or call good what is not, by spoiling a good log."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.records.audit import RunSummary, summarise_stand, summarise_walk
from surefoot.records.log import FACTS, Log
from surefoot.records.log.reading import read_log

DATA = Path(__file__).resolve().parents[1] / "records" / "log" / "data"
LOGS = {
    "stand": (read_log(DATA / "stand.npz"), summarise_stand),
    "walk": (read_log(DATA / "walk.npz"), summarise_walk),
}
MEASURED = ("q", "v", "torques", "forces", "gaps", "contact_velocities", "contact_positions")


def attempt(name: str, arrays: dict[str, Any], facts: dict[str, Any]) -> RunSummary | None:
    """Return the summary of a log, or None where it is refused."""
    try:
        with np.errstate(all="ignore"):
            return LOGS[name][1](Log(arrays, facts))
    except ProblemError:
        return None


@pytest.mark.parametrize("name", LOGS)
@pytest.mark.parametrize("bad", [None, "x", np.nan, -1, 0, [], [1.0], {"a": 1}, "missing"], ids=repr)
def test_spoilt_facts_are_refused_or_change_nothing(name: str, bad: Any) -> None:
    log = LOGS[name][0]
    for fact in (set(log.facts) | {"error"}) & set(FACTS):
        facts = {key: value for key, value in log.facts.items() if key != fact}
        summary = attempt(name, log.arrays, facts if bad == "missing" else {**facts, fact: bad})
        if fact in ("mass", "dt", "feet", "joints", "contact_foot", "effort_limits", "outcome"):
            assert summary is None or (isinstance(bad, str) and fact == "robot"), (fact, bad)


@pytest.mark.parametrize("name", LOGS)
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_none_is_never_good(name: str, bad: float) -> None:
    log = LOGS[name][0]
    for channel in MEASURED:
        arrays = {key: np.array(value) for key, value in log.arrays.items()}
        arrays[channel].flat[arrays[channel].size // 2] = bad
        summary = attempt(name, arrays, log.facts)
        assert summary is not None
        assert summary.outcome == "invalid", channel
        assert not summary.good


@pytest.mark.parametrize("name", LOGS)
def test_a_missing_channel_is_refused_by_name(name: str) -> None:
    log, summarise = LOGS[name]
    for channel in (
        *MEASURED,
        "mu",
        "active",
        "attained",
        "saturated",
        "controller_time",
        "forces_commanded",
    ):
        if (name, channel) == ("stand", "forces_commanded"):
            continue  # a stand is judged by what was measured
        arrays = {key: value for key, value in log.arrays.items() if key != channel}
        with pytest.raises(ProblemError, match=f"unknown channel '{channel}'"):
            summarise(Log(arrays, log.facts))
    with pytest.raises(ProblemError, match="the log has no rows"):
        summarise(log.rows(slice(0, 0)))
