"""The bench of walking stacks: what it measures, how it judges and counts, what it keeps when interrupted."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.stacks import bench as benches
from benchmarks.stacks.bench import TRIALS, Bench, measure
from benchmarks.stacks.judging import Trial
from benchmarks.stacks.measures import Measures, outside_cones, stance_slides
from benchmarks.stacks.setting import HARD, IDEAL, Setting
from benchmarks.stacks.table import rows
from benchmarks.stacks.tasks import TASKS, Bound, choose_tasks
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import CHANNELS, Log

GOOD = Measures(
    0.5, 0.0, 0.0, 0.002, 0.0, 0.5, 0.001, 1.0, 0.5, 0.7, 0.0, 0.0, 0.6, 0.0, 0.0, (), 0.003, 0.004
)  # fmt: skip


def trial(task: str = "speed-0.5", seed: int = 0, outcome: str = "done", **changed: Any) -> Trial:
    return Trial("surefoot", task, seed, outcome, "", replace(GOOD, **changed), 150.0, 300.0, 2.0, 8.0)


def synthetic(**arrays: Any) -> Log:
    """Return a log of one contact that weighs 10 N, at 1 ms."""
    T = len(next(iter(arrays.values())))
    full: dict[str, Any] = {
        "time": 1e-3 * np.arange(T),
        "q": np.zeros((T, 8)),
        "v": np.zeros((T, 7)),
    } | arrays
    facts = {"dt": 1e-3, "mass": 10.0 / GRAVITY, "contact_foot": [0], "feet": ["foot"]}
    return Log(full, facts, {name: CHANNELS[name] for name in full})


def test_cones_are_those_of_the_ground() -> None:
    forces = np.array([[[3.0, 4.0, 10.0]], [[3.0, 4.0, 10.2]], [[0.0, 0.0, 0.0]], [[0.1, 0.0, 0.0]]])
    log = synthetic(forces_commanded=forces, mu=np.full(4, 0.495))
    assert outside_cones(log, 0.01).tolist() == [True, False, False, True]


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"outcome": "fell"}, "fell"),
        ({"laws": ("penetration of 1.50 mm (limit 1)",)}, "law: penetration"),
        ({"velocity_error": 0.11}, "off course"),
        ({"heading": -16.0}, "off course"),
        ({"turn_error": 0.11}, "off course"),
        ({"velocity_error": math.nan}, "off course"),
    ],
)
def test_what_is_not_survived(changed: dict[str, Any], fault: str) -> None:
    asked = TASKS["speed-0.5"].asked
    one = trial(**changed)
    assert not one.survived(asked)
    assert one.faults(TASKS["speed-0.5"], asked)[0] == fault


def test_held_is_survived_within_the_bounds() -> None:
    task = TASKS["speed-0.5"]
    assert trial().held(task, task.asked)
    for changed in (
        {"slip": 0.011},
        {"velocity_error": 0.021},
        {"speed_use": 1.01},
        {"torque_use": math.nan},
    ):
        one = trial(**changed)
        assert one.survived(task.asked)
        assert not one.held(task, task.asked)
        assert [bound.measure for bound in one.missed(task)] == list(changed)
    slow = TASKS["real-time"]
    assert [str(bound) for bound in trial("real-time").missed(slow)] == ["real_time >= 4"]
    assert Bound("slip", 0.01).kept(0.01)


def test_rows_count_and_have_intervals() -> None:
    group = [trial(seed=k) for k in range(19)] + [trial(seed=19, outcome="fell")]
    (row,) = rows(group)
    assert (row.trials, row.falls, row.survived, row.held, row.holds) == (20, 1, 19, 19, True)
    assert (row.upright, row.on_course, row.lawful) == (19, 19, 19)
    # Wilson's interval of 19 of 20, from its definition: the roots of (p - x)² = z² x (1 - x) / n
    a, b, c = 1 + 1.959964**2 / 20, -(2 * 0.95 + 1.959964**2 / 20), 0.95**2
    root = math.sqrt(b * b - 4 * a * c)
    assert row.survival.low == pytest.approx((-b - root) / (2 * a), abs=1e-6)
    assert row.survival.high == pytest.approx((-b + root) / (2 * a), abs=1e-6)
    assert row.faults == {"fell": 1}
    assert (row.slip, row.step_us, row.real_time) == (0.001, 150.0, 2.0)
    (soft,) = rows([trial(laws=("penetration of 1.3 mm (limit 1)",)), trial(heading=20.0)])
    assert (soft.upright, soft.on_course, soft.lawful, soft.survived) == (2, 1, 1, 0)
    (worse,) = rows([*group[:18], trial(seed=18, slip=0.02), trial(seed=19, slip=0.03)])
    assert (worse.survived, worse.held, worse.holds, worse.slip) == (20, 18, False, 0.03)


class Still:
    """A stack that is never asked: its trials are made up."""

    name = "surefoot"

    def missing(self) -> str:
        return ""

    def walks(self, robot: str) -> bool:
        return robot == "go2"

    def version(self) -> str:
        return "1"

    def controller(self, job: Any) -> Any:
        raise AssertionError


def made_up(stack: Any, task: Any, seed: int, setting: Setting) -> Trial:
    return trial(task.name, seed, laws=(), estimate_drift=math.nan)


def small(seeds: int = 3, setting: Setting = HARD) -> Bench:
    return Bench((Still(),), choose_tasks(["ice", "delay", "g1-0"]), seeds, setting)


def test_an_interrupted_bench_goes_on_where_it_was(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    done: list[tuple[str, int]] = []

    def stop_at_four(stack: Any, task: Any, seed: int, setting: Setting) -> Trial:
        if len(done) == 4:
            raise KeyboardInterrupt
        done.append((task.name, seed))
        return made_up(stack, task, seed, setting)

    monkeypatch.setattr(benches, "carry_out", stop_at_four)
    first = measure(small(), tmp_path)
    assert done == [("ice", 0), ("delay", 0), ("ice", 1), ("delay", 1)], "G1 is not for this stack"
    assert len(first) == 4
    with (tmp_path / TRIALS).open("a") as file:
        file.write('{"stack": "surefoot", "ta')  # killed while it wrote
    told: list[tuple[int, int]] = []
    monkeypatch.setattr(benches, "carry_out", made_up)
    both = measure(small(), tmp_path, tell=lambda one, k, n: told.append((k, n)))
    assert told == [(5, 6), (6, 6)]
    assert [(t.task, t.seed) for t in both] == [(name, k) for k in range(3) for name in ("ice", "delay")]
    again = measure(small(), tmp_path, tell=lambda *_: pytest.fail("all trials are kept"))
    assert [t.as_dict() | {"measures": 0} for t in again] == [t.as_dict() | {"measures": 0} for t in both]
    assert all(math.isnan(t.measures.estimate_drift) for t in again)


def test_trials_of_another_setting_are_not_mixed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(benches, "carry_out", made_up)
    measure(small(1), tmp_path)
    with pytest.raises(ProblemError, match=r"measured with another setting: .*inekf.*truth"):
        measure(small(1, IDEAL), tmp_path)
    (tmp_path / TRIALS).write_text("nonsense\n")
    with pytest.raises(ProblemError, match="is no file of trials"):
        measure(small(1), tmp_path)


@pytest.mark.long
def test_a_real_trial_from_the_command_line(printed: Any, answer: Any, tmp_path: Path) -> None:
    words = ["bench", "stacks", "--stack", "surefoot", "--task", "speed-0.2", "--seeds", "1", "--ideal"]
    record = answer(*words, "--out", tmp_path)
    (row,) = record["rows"]
    assert (row["task"], row["held"], row["holds"], record["complete"]) == ("speed-0.2", 1, True, True)
    assert row["forward"] == pytest.approx(0.2, abs=0.01)
    assert 0.1 < row["cost_of_transport"] < 1.0
    assert 10.0 < row["step_us"] < row["step_p99_us"]
    assert row["hits"] is None, "feet alone touch in the kind world"
    assert record["setting"] == {"estimator": "truth", "actuators": "ideal", "collision": "feet"}
    (folder,) = tmp_path.iterdir()
    assert len((folder / TRIALS).read_text().splitlines()) == 2
    assert "speed-0.2*" in printed(*words, "--resume", folder)


def test_slides_of_stances_against_adding_up_one_by_one() -> None:
    random, T = np.random.default_rng(5), 4000
    loaded = np.repeat(random.random(40) < 0.5, 100)
    loaded[150:160] = False  # a bounce
    forces = np.zeros((T, 1, 3))
    forces[:, 0, 2] = np.where(loaded, 5.0, 0.0)
    velocity = random.normal(scale=0.2, size=(T, 1, 3)).cumsum(axis=0) * 0.05
    longest, place, free = 0.0, None, 99
    for k in range(T):
        if not loaded[k]:
            free += 1
            continue
        if place is None or free > 20:
            place = -1e-3 * velocity[k, 0, :2]  # the row of the touchdown counts for nothing
        free = 0
        place = place + 1e-3 * velocity[k, 0, :2]
        longest = max(longest, float(np.linalg.norm(place)))
    found = stance_slides(synthetic(forces=forces, contact_velocities=velocity))
    assert found == pytest.approx([longest], rel=1e-9)
    assert longest > 0.01
