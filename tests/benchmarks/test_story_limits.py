"""Limits of stories are varied over runs of known causes; a rule that does not read a limit is kept."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import pytest

from benchmarks import story_limits
from benchmarks.limit_choice import Choice
from benchmarks.story_limits import Told, told_runs, vary_limit
from surefoot.base.settings import describe
from surefoot.records.audit.story.story import story_of
from surefoot.records.audit.story.story_limits import STORY_LIMITS, StoryLimits

RUNS = [("", "weak actuator", 0), ("hopper", "", 0)]
"""A failure of which the cause is plain, and a lawful control."""


@pytest.fixture(scope="module")
def runs() -> list[Told]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(story_limits, "plan", lambda seeds, lawful, causes: RUNS)
        return list(told_runs(1, 1, None))


@pytest.mark.long
def test_the_story_of_a_told_run_is_that_of_its_audit(runs: list[Told]) -> None:
    assert [run.right(STORY_LIMITS, "") for run in runs] == [True, True]
    for name, value in (("weaker", 0.05), ("loaded", 0.4), ("lag_better", 1.0), ("brief", 0.5)):
        limits = replace(STORY_LIMITS, **{name: value})
        for run in runs:
            causes = story_of(*run.given, limits).causes
            alone = replace(run, known={rule: ({name}, found) for rule, (_, found) in run.known.items()})
            assert run.right(limits, name) == alone.right(limits, name), "every rule reads it anew"
            if run.run.fault is None:
                assert run.right(limits, name) == (not causes)


class Weakened:
    """A run that is told right with a limit in a range."""

    def right(self, limits: StoryLimits, changed: str) -> bool:
        """See `Told.right`."""
        return 0.7 < limits.weaker < 0.96


def test_a_limit_is_decided_where_a_value_tells_fewer_runs_right() -> None:
    every = {one.name: one for one in describe(STORY_LIMITS)}
    runs = cast("list[Told]", [Weakened(), Weakened()])
    found = vary_limit(every["weaker"], runs)
    assert found.verdict == "as good from 0.8 to 0.95"
    values = [value for value, _ in found.tried]
    assert values == pytest.approx([0.6, 0.8, 0.85, 0.9, 1.4 / 1.5, 0.95, 0.975])
    assert [right for _, right in found.tried] == [0, 2, 2, 2, 2, 2, 0]
    assert vary_limit(every["slippery"], runs).verdict == "not decided: all values tried do as well"


def test_a_better_value_is_said() -> None:
    found = Choice("push", 1.0, 5, 1, 1.0, 2.0, ((0.5, 4), (1.0, 5), (1.5, 6), (2.0, 7)))
    assert found.verdict == "better: 2", "one run more is a matter of a seed"
    assert replace(found, tried=found.tried[:3]).verdict.startswith("not decided")
