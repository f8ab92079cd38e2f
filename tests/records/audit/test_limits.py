"""The limits of an audit: one value that judges, is kept in the report, and prints itself."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from benchmarks.limit_cases.made import DT, Made
from benchmarks.limit_cases.verdict import Verdict
from benchmarks.limits import changed, limits_read, made_cases, values_away, vary
from benchmarks.problems.logged_runs import clean_runs
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit import audit_log, log_laws
from surefoot.records.audit.limits import LIMITS, AuditLimits, LawLimits
from surefoot.records.audit.log_context import setting_of
from surefoot.records.audit.summary.run_summary import RunSummary
from surefoot.records.audit.summary.stand_summary import summarise_stand
from surefoot.records.audit.summary.walk_summary import summarise_walk
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


@pytest.mark.parametrize(("summarise", "run"), [(summarise_stand, 11), (summarise_walk, 10)])
def test_a_summary_judges_laws_slips_and_motors_by_the_limits_that_it_is_given(
    summarise: Callable[[Log, AuditLimits], RunSummary], run: int
) -> None:
    clean = clean_log(run)
    arrays = {name: np.array(array) for name, array in clean.arrays.items()}
    arrays["forces"][200:210, 0, 2] = -0.01 * float(clean.fact("mass")) * GRAVITY
    fastest = np.abs(arrays["v"][:, 6:]).max() / 1.01
    facts = {"speed_limits": np.full(12, fastest), "actuators": "curve"}
    log = Log(arrays, {**clean.facts, **facts}, channels=clean.channels)
    usual = summarise(log, LIMITS)
    assert "a pull of" in " ".join(usual.laws_broken)
    assert "a pull of" not in " ".join(summarise(log, changed("laws.pull", 0.02)).laws_broken)
    assert usual.motors is not None
    assert usual.motors.over_speed_share > 0.0
    patient = summarise(log, changed("motors.over_speed", 1.02))
    assert patient.motors is not None
    assert patient.motors.over_speed_share == 0.0
    assert usual.limits_broken
    assert not patient.limits_broken
    slow = summarise(log, changed("laws.loaded", 0.5))
    assert usual.feet[1].slip > slow.feet[1].slip


def test_figures_of_laws_are_taken_by_the_limits_that_are_given() -> None:
    made = Made(400, mu=0.0)
    made.forces[:, 0, 0] = 1e-4 * made.forces[:, 0, 2]
    made.velocities[:, 1, 0] = 5e-3
    log = made.log()
    patient = changed("laws.least_friction", 2e-4)
    assert log_laws(log).cone_use_max == pytest.approx(1.0)
    assert log_laws(log, patient).cone_use_max == pytest.approx(0.5)
    made.mu[:] = 0.6
    assert log_laws(made.log()).dissipation_max == 0.0
    assert log_laws(made.log(), changed("laws.sliding_speed", 1e-3)).dissipation_max == pytest.approx(
        0.15, 0.01
    )


@pytest.mark.parametrize("after", [True, False])
def test_gaps_that_jump_at_edges_tell_nothing_of_whose_velocities_a_row_has(after: bool) -> None:
    """A swing to and fro over stairs of 6 cm: its gap jumps sixty times as far as it moves in a row."""
    made = Made(2000, feet=1)
    speed = 0.3 * np.sin(2.0 * np.pi * 2.0 * made.time)
    way = np.cumsum(DT * speed)
    made.gaps[:, 0] = 0.1 + (way - DT * speed if after else way)
    made.gaps[np.arange(2000) % 200 >= 100, 0] += 0.06
    made.velocities[:, 0, 2] = speed
    assert setting_of(made.log(), None).after is after


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


@pytest.mark.long
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
    assert len(commands) == len(sources)
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
@pytest.mark.parametrize(
    "group",
    [
        "times", "walk", "stand", "motors", "estimate", "ranks.unconverged_solver", "ranks.pyramid_bias",
        "ranks.deep_contact", "ranks.energy_gain", "ranks.clipped_flat", "ranks.joint_stop",
        "measured.explained", "measured.stop_share", "measured.bias_flies",
        "continuity.velocity_share", "episodes.sideways",
    ],
)  # fmt: skip
def test_the_choice_of_a_group_is_repeated_by_the_made_cases(group: str) -> None:
    for one in LIMITS.described():
        if one.name == group or one.name.startswith(f"{group}."):
            varied = vary(one.name, [case for case, read in cases_with_limits() if one.name in read])
            assert varied.decided, one.name
