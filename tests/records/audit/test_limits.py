"""The limits of an audit: one value that judges, is kept in the report, and prints itself."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from benchmarks.limit_cases.verdict import Verdict
from benchmarks.limits import changed, limits_read, made_cases, values_away, vary
from benchmarks.problems.logged_runs import clean_runs
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import audit_log
from surefoot.records.audit.limits import LIMITS, LawLimits
from surefoot.records.log import Log


def pulled(share: float) -> Log:
    """Return a log in which the ground pulls with a share of the weight for some rows."""
    forces = np.zeros((100, 1, 3))
    forces[:, 0, 2] = GRAVITY * (1.0 + 1e-3 * np.sin(np.arange(100.0)))
    forces[40:50, 0, 2] = -share * GRAVITY
    return Log({"time": 1e-3 * np.arange(100), "forces": forces}, {"mass": 1.0, "dt": 1e-3})


def test_a_pull_is_judged_by_the_limits_that_are_given_and_the_report_keeps_them() -> None:
    log, patient = pulled(0.01), changed("laws.pull", 0.02)
    assert [v.law for v in audit_log(log).violations] == ["pull"]
    report = audit_log(log, limits=patient)
    assert not report.violations
    assert report.limits is patient
    assert "laws.pull = 0.02 m g: largest pull that counts as rounding" in report.limits.lines()
    assert "limits" not in report.as_dict()
    assert audit_log(log).limits is LIMITS


def test_a_limit_that_makes_no_sense_is_refused() -> None:
    with pytest.raises(ProblemError, match="pull must be a number >= 0, got -1"):
        LawLimits(pull=-1.0)
    with pytest.raises(ProblemError, match=r"brake_share must be a number between 0 and 1, got 1\.5"):
        replace(LIMITS.checks, brake_share=1.5)


def test_limits_are_varied_away_from_their_value_on_their_own_scale() -> None:
    for one in LIMITS.described():
        value = float(one.value or 0.0)
        for up in (False, True):
            tried = [abs(x - value) for x in values_away(one.name, value, one.info.whole, up)]
            assert tried == sorted(tried), one.name
            assert tried[0] > 0.0, one.name
    assert list(values_away("laws.cone", 1.001, False, True)) == pytest.approx([1.003, 1.03, 1.3, 4.0])
    assert list(values_away("laws.pull", 1e-3, False, False)) == pytest.approx(
        [1e-3 / 3.0, 1e-3 / 30.0, 1e-3 / 300.0, 1e-3 / 3000.0]
    )


@cache
def clean_log(number: int) -> Log:
    return clean_runs(number + 1)[number].make()


def test_every_made_case_is_right_and_says_where_its_size_is_from() -> None:
    made = list(made_cases(clean_log))
    assert not [one.name for one in made if not one.right(LIMITS)]
    assert all(one.why for one in made)
    assert len({one.name for one in made}) == len(made) > 100


def test_sources_that_name_the_command_name_limits_that_exist() -> None:
    known = {one.name for one in LIMITS.described()} | {one.name for one in fields(LIMITS)}
    sources = [one.info.source for one in LIMITS.described()]
    commands = [
        found for source in sources if (found := re.match(r"`python -m benchmarks\.limits ?([^`]*)`", source))
    ]
    assert len(commands) > 100
    assert {name for command in commands for name in command[1].split()} <= known
    assert not outside_their_range()


def outside_their_range() -> list[str]:
    """Return the limits whose ranges do not hold their own value."""
    out = []
    for one in LIMITS.described():
        span = re.search(r"from ([0-9.e+-]+) to ([0-9.e+-]+)", one.info.source)
        if span and not float(span[1]) * 0.999 <= float(one.value) <= float(span[2]) * 1.001:
            out.append(one.name)
    return out


@cache
def cases_with_limits() -> list[tuple[Verdict, set[str]]]:
    return [(case, limits_read(case)) for case in made_cases(clean_log)]


@pytest.mark.long
@pytest.mark.parametrize("group", ["times", "walk", "stand", "motors", "estimate"])
def test_the_choice_of_a_group_is_repeated_by_the_made_cases(group: str) -> None:
    for one in LIMITS.described():
        if one.name.startswith(f"{group}."):
            varied = vary(one.name, [case for case, read in cases_with_limits() if one.name in read])
            assert varied.decided, one.name
