"""Ablations of walking: comparisons tell loss from noise, parts name what there is, changes take effect."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from benchmarks.ablation.changes import Changes
from benchmarks.ablation.comparing import compare, difference, sign_test
from benchmarks.ablation.parts import CLASS_TASKS, PARTS, TASKS, USUAL_TASKS, choose_parts
from benchmarks.ablation.trials import Change, Trials, run_trials
from benchmarks.ablation.varying import Setting, Tried, find_settings, known_settings, try_values, verdict
from benchmarks.ablation.walked import behaviour_name
from surefoot.base.errors import ProblemError
from surefoot.base.settings import Settings, setting
from surefoot.motion.walking.behaviours import BEHAVIOURS


def records(done: list[bool], cost: list[float]) -> list[dict[str, Any]]:
    """Return records of one task, seed after seed."""
    more = {"error": 0.01, "friction": 0.5, "load": 1.0, "hits": 0.0}
    return [
        {"task": "walk", "seed": k, "done": d, "cost": c, **more}
        for k, (d, c) in enumerate(zip(done, cost, strict=True))
    ]


def test_a_loss_is_told_from_noise_seed_by_seed() -> None:
    rng = np.random.default_rng(3)
    base = 0.4 + 0.1 * rng.standard_normal(8)  # seeds differ by far more than the loss
    up = [True] * 8
    lost = compare("walk", records(up, base.tolist()), records(up, (1.05 * base).tolist()))
    assert lost.worse
    assert not lost.better
    (cost,) = (one for one in lost.differences if one.measure == "cost")
    assert cost.size == pytest.approx(0.05)
    noise = (base + 0.05 * np.tile([1.0, -1.0], 4)).tolist()
    same = compare("walk", records(up, base.tolist()), records(up, noise))
    assert not same.worse
    assert not same.better
    gained = compare("walk", records(up, (1.05 * base).tolist()), records(up, base.tolist()))
    assert gained.better
    assert not gained.worse


def test_survival_is_lost_only_beyond_chance() -> None:
    cost = [0.4] * 8
    before = records([True] * 8, cost)
    few = compare("walk", before, records([False] * 3 + [True] * 5, cost))
    assert (few.before, few.after, few.worse) == (8, 5, False)
    many = compare("walk", before, records([False] * 6 + [True] * 2, cost))
    assert many.worse
    assert many.chance == pytest.approx(2.0 / 2**6)
    assert sign_test(3, 3) == 1.0
    assert difference("cost", [1.0, 1.0], [2.0, 2.0]) is None, "two seeds say nothing of noise"


def test_only_seeds_of_both_are_compared() -> None:
    found = compare("walk", records([True] * 5, [0.4] * 5), records([True] * 3, [0.5] * 3))
    assert found.trials == 3


@pytest.mark.parametrize("part", PARTS.values(), ids=str)
def test_parts_name_behaviours_settings_and_tasks_that_there_are(part: Any) -> None:
    assert set(part.tasks) <= set(TASKS)
    assert bool(part.without) != bool(part.changes)
    assert not part.without or part.without in {behaviour_name(make) for make in BEHAVIOURS}
    for name, value in part.changes.items():
        assert find_settings(name)[0].value != value


def test_every_behaviour_is_a_part() -> None:
    assert {behaviour_name(make) for make in BEHAVIOURS} == {p.without for p in PARTS.values()} - {""}
    for names in (*CLASS_TASKS.values(), USUAL_TASKS):
        assert set(names) <= set(TASKS)


def test_wrong_names_are_refused() -> None:
    with pytest.raises(ProblemError, match=r"unknown part of walking 'brisc'; valid names: brisk"):
        choose_parts(["brisc"])
    with pytest.raises(ProblemError, match=r"WalkSettings\.ease"):
        find_settings("WalkSettings.eas")
    with pytest.raises(ProblemError, match="several numbers: try --factor"):
        find_settings("MpcWeights.position")[0].values([3.0])


def the(name: str) -> Setting:
    """Return one setting."""
    (found,) = find_settings(name)
    return found


def test_values_stay_within_the_limits_of_a_setting() -> None:
    assert the("WalkSettings.friction_share").values() == [0.45, 1.0]
    assert the("WalkSettings.horizon").values() == [5, 20]
    assert the("WalkSettings.horizon").values(factors=[20.0]) == [1, 200]
    assert the("StairPhaseSettings.used").values() == [False]
    assert the("WalkSettings.ease").values([0.9, 0.55, 0.1]) == [0.1, 0.9]
    tried = the("WalkSettings.clearance").values(factors=[2.0, 10.0])
    assert tried == pytest.approx([0.022, 0.11, 0.44, 2.2])


def test_several_numbers_are_varied_by_one_factor() -> None:
    assert the("MpcWeights.position").values(factors=[10.0]) == [(1.0, 1.0, 10.0), (100.0, 100.0, 1000.0)]


def test_a_class_names_all_its_settings() -> None:
    names = [one.name for one in find_settings("TaskWeights")]
    assert names == [f"TaskWeights.{n}" for n in ("linear", "angular", "swing", "joints", "body", "force")]


def test_a_choice_is_repeated_if_no_value_is_better_and_one_is_worse() -> None:
    base, up = [0.4, 0.5, 0.6], [True] * 3
    worse = compare("walk", records(up, base), records(up, [1.1 * c for c in base]))
    better = compare("walk", records(up, base), records(up, [0.9 * c for c in base]))
    same = compare("walk", records(up, base), records(up, base))
    ease = the("WalkSettings.ease")
    assert verdict(ease, [Tried(0.3, (same,)), Tried(0.9, (worse,))]) == "as good from 0.3 to 0.55"
    assert verdict(ease, [Tried(0.3, (better, worse)), Tried(0.9, (same,))]) == "as good from 0.55 to 0.9"
    assert verdict(ease, [Tried(0.3, (better,)), Tried(0.9, (worse,))]) == "better: 0.3"
    assert verdict(ease, [Tried(0.3, (same,)), Tried(0.9, (same,))]).startswith("not decided")
    swing = the("BipedSettings.sole_damping")  # 16, 40
    found = [Tried((8.0, 20.0), (same,)), Tried((32.0, 80.0), (worse,))]
    assert verdict(swing, found) == "as good from 8, 20 to 16, 40"


def test_a_value_that_is_worse_ends_its_tasks_and_the_values_beyond(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, str]] = []

    def carried_out(
        change: Change, tasks: list[str], seeds: range, longest: float | None
    ) -> Generator[dict[str, Any], None, None]:
        assert longest is None
        (value,) = change.changes.values() or (0.22,)
        for task in tasks:
            for seed in seeds:
                asked.append((change.name, task))
                cost = 0.8 if value > 0.4 else 0.5
                yield records([True] * 4, [cost + 0.01 * k for k in range(4)])[seed] | {"task": task}

    monkeypatch.setattr("benchmarks.ablation.trials.run_trials", carried_out)
    clearance, trials = the("WalkSettings.clearance"), Trials(range(3), 1, lambda *_: None)
    values = clearance.values(factors=[1.5, 2.0, 5.0])
    found = try_values(clearance, values, trials, ["trot", "turn"])
    assert verdict(clearance, found) == "as good from 0.044 to 0.33"
    tried = dict.fromkeys(asked)  # in order
    assert ("WalkSettings.clearance=0.33", "turn") in tried
    assert ("WalkSettings.clearance=0.44", "trot") in tried
    assert ("WalkSettings.clearance=0.44", "turn") not in tried
    assert not any("=1.1" in name for name, _ in tried)


@pytest.fixture
def _settings_as_they_were() -> Iterator[None]:
    yield
    del Settings.__init_subclass__


@pytest.mark.usefixtures("_settings_as_they_were")
def test_changes_reach_classes_that_are_made_afterwards() -> None:
    changes = Changes({"Gains.stiffness": 3.0})
    with pytest.raises(LookupError, match="stiffness"):
        changes.check()

    @dataclass(frozen=True)
    class Gains(Settings):
        stiffness: float = setting(2.0, "-", "stiffness")
        damping: float = setting(1.0, "-", "damping")

    changes.check()
    assert (Gains().stiffness, Gains().damping) == (3.0, 1.0)


@pytest.mark.long
def test_a_process_of_trials_can_change_every_setting_that_the_page_counts() -> None:
    from docs.settings import rows_of, settings_classes

    owners = [one for one in settings_classes() if one.__module__.startswith("surefoot.motion.")]
    counted = {f"{owner.__name__}.{name}" for owner in owners for name, _, _ in rows_of(owner)}
    known = known_settings()
    assert set(known) == counted
    changes = {name: one.value for name, one in known.items() if not isinstance(one.value, str)}
    assert list(run_trials(Change("all as they are", changes=changes), [], [])) == []


@pytest.mark.long
def test_a_trot_without_brisk_steps_takes_more_work() -> None:
    change = Change("brisk", changes={"SpeedLimitSettings.brisk": 0.0})
    (before,), (after,) = (run_trials(one, ["speed-1"], [1000]) for one in (Change(""), change))
    assert before["done"]
    assert after["done"]
    assert after["cost"] > 1.1 * before["cost"]
