"""Logs are values: compared, cut into pieces, put together again; arrays as people have them are taken."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError

ROWS = 100
FORCES = np.tile([2.0, 0.0, 40.0], (ROWS, 4, 1))
TIME = 0.002 * np.arange(ROWS)


def recorded(mass: float = 16.3, **more: Any) -> sf.Log:
    return sf.log_from_arrays({"time": TIME, "forces": FORCES, **more}, facts={"mass": mass, "mu": 0.6})


def test_logs_are_equal_where_every_entry_is() -> None:
    log = recorded()
    assert log == recorded()
    assert log != recorded(mass=16.4)
    assert log != recorded(gaps=np.zeros((ROWS, 4)))
    assert log != "log"
    other = sf.Log(dict(log.arrays), dict(log.facts))
    other.arrays["forces"] = np.where(np.arange(ROWS)[:, None, None] == 7, np.nan, FORCES)
    assert log != other
    assert other == sf.Log(dict(other.arrays), dict(other.facts))  # NaN is where NaN is


def test_pieces_are_logs_and_make_the_whole_again() -> None:
    log = recorded()
    assert len(log[10:20]) == 10
    assert len(log[np.array([1, 5])]) == 2
    assert log[:30] + log[30:] == log
    assert log[:30] + log[30:60] + log[60:] == log


def test_runs_one_after_the_other_are_episodes() -> None:
    log = recorded()
    both = log + log + log
    assert len(both) == 3 * ROWS
    assert both.facts["episode_rows"] == [0, ROWS, 2 * ROWS]
    np.testing.assert_allclose(np.diff(both["time"]), 0.002, rtol=1e-9)
    assert [len(one) for one in both.episodes] == [ROWS] * 3
    np.testing.assert_array_equal(log["time"], TIME)  # the pieces are as they were


@pytest.mark.parametrize(
    ("join", "words"),
    [
        (lambda log: log + recorded(gaps=np.zeros((ROWS, 4))), "only one has gaps"),
        (lambda log: log + recorded(mass=20.0), "different facts cannot be joined: .*mass"),
        (lambda log: log[:1] + log[5:], "rising times, or the fact dt"),
        (lambda log: log["tme"], r"unknown channel 'tme'; valid names: .*; did you mean time\?"),
        (lambda log: log[500:][[3]], "rows must be a slice"),
    ],
)
def test_what_does_not_fit_is_refused(join: Callable[[sf.Log], Any], words: str) -> None:
    log = recorded()
    log.facts.pop("dt", None)
    with pytest.raises(ProblemError, match=words):
        join(log)


def test_forces_mass_and_friction_alone_judge_what_they_can() -> None:
    report = sf.audit_log(recorded())
    assert report.verdict == "cannot tell"
    assert set(report.judged) == {"pull", "friction"}
    assert "; 2 laws judged, both hold: pull, friction; 17 not: penetration, distance, " in report.sentence
    slipping = sf.log_from_arrays(
        {"time": TIME, "forces": np.tile([30.0, 0.0, 40.0], (ROWS, 4, 1))}, facts={"mass": 16.3, "mu": 0.6}
    )
    assert sf.audit_log(slipping).laws_broken == ("friction",)


def test_friction_is_a_number_or_one_a_contact() -> None:
    each = sf.log_from_arrays({"time": TIME, "forces": FORCES}, facts={"mu": [0.2, 0.6, 0.6, 0.6]})
    np.testing.assert_array_equal(each["contact_friction"][5], [0.2, 0.6, 0.6, 0.6])
    rows = sf.log_from_arrays({"time": TIME, "forces": FORCES, "mu": np.full((ROWS, 4), 0.5)})
    assert rows["contact_friction"].shape == (ROWS, 4)
    normal = sf.log_from_arrays({"time": TIME, "forces": FORCES[..., 2]})
    assert normal["foot_sensors"].shape == (ROWS, 4)
    with pytest.raises(ProblemError, match="one for each of 4 contacts"):
        sf.log_from_arrays({"time": TIME, "forces": FORCES}, facts={"mu": [0.5] * 3})
    with pytest.raises(ProblemError, match="as an array and as a fact"):
        sf.log_from_arrays({"time": TIME, "forces": FORCES, "mu": np.full(ROWS, 0.5)}, facts={"mu": 0.6})


def test_a_fact_that_nothing_reads_is_doubted() -> None:
    log = sf.log_from_arrays({"time": TIME, "forces": FORCES}, facts={"masss": 16.3, "my_run": 3})
    assert "nothing reads the fact masss (did you mean mass?)" in log.doubts
    assert "nothing reads the fact my_run" in log.doubts
    assert log.facts["my_run"] == 3
