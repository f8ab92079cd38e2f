"""The same work for many tasks: results as they come, here or in processes, and an end that ends all."""

from __future__ import annotations

import math
import time

import pytest

from surefoot.app.cli import processes
from surefoot.app.cli.processes import results_of

TASKS = [(float(k),) for k in range(5)]


@pytest.mark.parametrize("jobs", [1, 2, None])
def test_every_task_is_done_once(jobs: int | None) -> None:
    assert sorted(results_of(math.exp, TASKS, jobs)) == [(k, math.exp(k)) for k in range(5)]
    assert list(results_of(math.exp, [], jobs)) == []


def test_a_single_process_is_this_one_and_goes_in_order() -> None:
    seen: list[float] = []
    assert list(results_of(seen.append, TASKS, 1)) == [(k, None) for k in range(5)]
    assert seen == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_who_waits_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "TICK", 0.05)
    idle: list[None] = []
    list(results_of(time.sleep, [(0.5,), (0.5,)], 2, lambda: idle.append(None)))
    assert idle


def test_a_task_that_fails_ends_the_others() -> None:
    begin = time.monotonic()
    with pytest.raises(TypeError):
        list(results_of(time.sleep, [(300.0,), ("no time",)], 2))
    assert time.monotonic() - begin < 200.0
