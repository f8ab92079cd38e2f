"""Loops of strangers succeed without a fault and fail with one; scores count which causes are named."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.foreign import race
from benchmarks.foreign.causes import CAUSES
from benchmarks.foreign.loops import LOOPS, OTHERS, failed
from benchmarks.foreign.simulation import Loop
from surefoot.app.cli.main import main

ABLE = {loop.name: loop for loop in LOOPS}
PAIRS = [(loop.name, cause) for loop in LOOPS for cause in loop.faults]
SHORT = [("pd quadruped", "weak actuator"), ("hopper", "delayed control"), ("pd humanoid", "delayed control")]
"""Failures that come within a second or two of the run."""


@pytest.mark.parametrize("loop", [*LOOPS, *OTHERS], ids=lambda loop: loop.name)
@pytest.mark.sampled(2)
def test_a_loop_without_a_fault_attains_its_task(loop: Loop) -> None:
    run = loop.lawful(0)
    assert run.failure == ""
    assert run.fault is None
    assert np.isfinite(run.log["q"]).all()


@pytest.mark.long
@pytest.mark.parametrize("loop", LOOPS, ids=lambda loop: loop.name)
def test_all_controls_attain_their_task(loop: Loop) -> None:
    assert [loop.lawful(seed).failure for seed in range(race.LAWFUL)] == [""] * race.LAWFUL


def fails(loop: str, cause: str) -> None:
    run = ABLE[loop].failed(cause, 0)
    assert run.failure
    assert run.fault is not None
    assert run.fault.cause == cause
    assert run.onset is None or 0.0 <= run.onset <= run.failed_at
    known = {str(name) for name in run.fault.places}
    assert "" not in known


@pytest.mark.parametrize(("loop", "cause"), SHORT)
def test_a_fault_makes_its_loop_fail(loop: str, cause: str) -> None:
    fails(loop, cause)


@pytest.mark.long
@pytest.mark.parametrize(("loop", "cause"), [pair for pair in PAIRS if pair not in SHORT])
def test_every_fault_makes_its_loop_fail(loop: str, cause: str) -> None:
    fails(loop, cause)


@pytest.mark.long
@pytest.mark.parametrize(
    ("loop", "cause"),
    [pytest.param(loop, cause, id=f"{loop.name}-{cause}") for loop in OTHERS for cause in loop.faults],
)
def test_every_fault_makes_another_robot_fail(loop: Loop, cause: str) -> None:
    run = loop.failed(cause, 0)
    assert run.failure
    assert run.fault is not None
    assert run.fault.cause == cause


def test_other_robots_are_of_no_half() -> None:
    tasks = race.plan_of_others(range(2))
    assert {loop for loop, _, _ in tasks} == {loop.name for loop in OTHERS}
    assert len(tasks) == 2 * sum(len(loop.faults) + 1 for loop in OTHERS)
    assert not set(tasks) & set(race.plan(range(race.HELD_BACK), race.LAWFUL))
    assert {cause for _, cause, _ in race.plan_of_others([0], ["push"])} == {"push", ""}


@pytest.mark.long
def test_a_seed_is_one_run() -> None:
    one, other = (ABLE["hopper"].failed("delayed control", 0).log for _ in range(2))
    assert set(one) == set(other)
    for name in one:
        np.testing.assert_array_equal(one[name], other[name])
    assert len(ABLE["hopper"].failed("delayed control", 1).log) != len(one)


def test_every_cause_is_of_two_loops_and_there_are_twelve() -> None:
    names = {cause.name for cause in CAUSES}
    assert names == {cause for _, cause in PAIRS}
    assert len(names) >= 12
    assert all(sum(cause in loop.faults for loop in LOOPS) >= 2 for cause in names)


def test_the_plan_holds_half_of_the_seeds_back() -> None:
    tuning = race.plan(range(race.TUNING), 15)
    held_back = race.plan(range(race.TUNING, race.HELD_BACK), 0)
    assert len(tuning) == 10 * len(CAUSES) + 60
    assert not set(tuning) & set(held_back)


def test_a_cause_is_right_in_name_place_and_time() -> None:
    run = failed("push", 0)
    assert run.fault is not None
    assert run.onset is not None
    place = run.fault.places[0]
    assert race.is_right(run, "push", place, run.onset + 0.14)
    assert not race.is_right(run, "push", place, run.onset + 0.16)
    assert not race.is_right(run, "push", place, None)
    assert not race.is_right(run, "push", "toe_nw", run.onset)
    assert not race.is_right(run, "payload", place, run.onset)


def test_scores_count_the_first_and_the_first_two(monkeypatch: pytest.MonkeyPatch) -> None:
    run = failed("push", 0)
    assert run.fault is not None
    right = SimpleNamespace(name="push", where=run.fault.places[0], time=run.onset)
    wrong = SimpleNamespace(name="payload", where="", time=0.0)
    for causes, first, second in (
        ((), False, False), ((right, wrong), True, True), ((wrong, right), False, True),
        ((wrong, wrong, right), False, False),
    ):  # fmt: skip
        told = SimpleNamespace(causes=causes, laws_broken=("motion",) if causes else ())
        monkeypatch.setattr(race.sf, "audit_log", lambda log, told=told: told)
        trial = race.judged(run)
        assert (trial.first, trial.second) == (first, second)
        record = race.summary([trial])
        assert record["total"]["first"] == int(first)
        assert record["confusion"] == {"push": {causes[0].name if causes else race.NOTHING: 1}}
        assert (
            record["broken"] == {"runs": 1, "broken": 1, "motion": 1} if causes else {"runs": 1, "broken": 0}
        )


@pytest.mark.long
def test_the_command_prints_the_confusion(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "audit", "--foreign", "--quick", "--cause", "push", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["total"]["trials"] == 1
    assert record["controls"] == len(LOOPS)


def test_an_interrupted_run_tells_what_it_has(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    trial = race.Trial("hopper", "push", 0, "", "", (), None, (("push", "drum", 1.0),), True, True, 0.0)

    def interrupted(tasks: object) -> object:
        yield trial
        raise KeyboardInterrupt

    monkeypatch.setattr(race, "trials", interrupted)
    assert main(["bench", "audit", "--foreign", "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["total"] == {"name": "all", "trials": 1, "first": 1, "second": 1}
    assert "interrupted: 1 of" in told.err


def test_an_unknown_cause_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "audit", "--foreign", "--cause", "pushed"]) == 2
    assert "pushed" in capsys.readouterr().err


def test_gymnasium_s_runs_are_skipped_with_a_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", "audit", "--gymnasium", "--assets", str(tmp_path)]) == 0
    assert "skipped:" in (said := capsys.readouterr().err)
    assert "has no model of Ant, Hopper, Walker2d, Humanoid" in said
