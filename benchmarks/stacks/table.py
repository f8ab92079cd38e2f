"""From trials to rows: rates with intervals, medians and worst values, and what went wrong how often."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.stacks.judging import Trial
from benchmarks.stacks.tasks import TASKS
from benchmarks.stacks.trial import asked_velocity
from surefoot.worlds.sweep.survival import Share, wilson

HOLDS = 0.95
"""A task is held if at least this share of its trials is: 19 of 20."""


@dataclass(frozen=True)
class Row:
    """What a stack came to in a task.

    Attributes
    ----------
    stack, task, title, must
        Which, and whether it is one that has to be held.
    asked
        (forward, left, yaw rate) [m/s, rad/s].
    trials, falls
        Counts: all, and those that fell.
    upright, on_course, lawful
        Of those that were on their feet to the end, went where they should, broke no law of contact.
    survived, held
        Of those that were all three, and within the task's bounds as well.
    survival, holding
        The last two as shares with Wilson's 95 % intervals.
    forward
        Mean of the mean forward velocities [m/s].
    velocity_error, slip, tilt, torque_use, speed_use, over_speed, beyond_curve, hits, cone_violations
        Worst of all trials that did not end early, see `Measures`.
    cost_of_transport, step_us, step_p99_us, real_time
        Medians of them.
    estimate_velocity, estimate_drift
        Worst of them.
    faults
        What was wrong, each with how often.
    """

    stack: str
    task: str
    title: str
    must: bool
    asked: tuple[float, float, float]
    trials: int
    falls: int
    upright: int
    on_course: int
    lawful: int
    survived: int
    held: int
    survival: Share
    holding: Share
    forward: float
    velocity_error: float
    slip: float
    tilt: float
    torque_use: float
    speed_use: float
    over_speed: float
    beyond_curve: float
    hits: float
    cone_violations: float
    cost_of_transport: float
    step_us: float
    step_p99_us: float
    real_time: float
    estimate_velocity: float
    estimate_drift: float
    load: float
    faults: dict[str, int]

    @property
    def holds(self) -> bool:
        """Whether at least 19 of 20 trials were held."""
        return self.trials > 0 and self.held >= math.ceil(HOLDS * self.trials - 1e-9)

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, for JSON."""
        return asdict(self) | {"holds": self.holds}


def rows(trials: Sequence[Trial]) -> list[Row]:
    """Return a row for each stack and task, in the order of the trials."""
    groups: dict[tuple[str, str], list[Trial]] = {}
    for trial in trials:
        groups.setdefault((trial.task, trial.stack), []).append(trial)
    return [_row(group) for group in groups.values()]


def _row(group: Sequence[Trial]) -> Row:
    task, count = TASKS[group[0].task], len(group)
    asked = asked_velocity(task)
    survived = sum(trial.survived(asked) for trial in group)
    held = sum(trial.held(task, asked) for trial in group)
    whole = [trial for trial in group if trial.upright]

    def over(name: str, how: Callable[[list[float]], Any]) -> float:
        values = [float(getattr(t if name in _CLOCKS else t.measures, name)) for t in whole]
        known = [value for value in values if not math.isnan(value)]
        return float(how(known)) if known else math.nan

    worst = {name: over(name, np.max) for name in _WORST}
    median = {name: over(name, np.median) for name in _MEDIAN}
    faults = Counter(fault for trial in group for fault in trial.faults(task, asked))
    return Row(
        group[0].stack, task.name, task.title, task.must, asked, count,
        sum(trial.outcome == "fell" for trial in group), len(whole),
        sum(trial.on_course(asked) for trial in group), sum(trial.lawful for trial in group), survived, held,
        wilson(survived, count), wilson(held, count), over("forward", np.mean),
        faults=dict(faults.most_common()), **worst, **median,
    )  # fmt: skip


def fastest_held(found: Sequence[Row]) -> dict[str, float]:
    """Return the highest speed of the ladder up to which each stack holds every one [m/s]; 0 for none."""
    out: dict[str, float] = {}
    broken: set[str] = set()
    for row in sorted((r for r in found if r.task.startswith("speed-")), key=lambda r: r.asked[0]):
        broken |= set() if row.holds else {row.stack}
        best = out.setdefault(row.stack, 0.0)
        out[row.stack] = best if row.stack in broken else row.asked[0]
    return out


_WORST = (
    "velocity_error", "slip", "tilt", "torque_use", "speed_use", "over_speed", "beyond_curve", "hits",
    "cone_violations", "estimate_velocity", "estimate_drift", "load",
)  # fmt: skip
_MEDIAN = ("cost_of_transport", "step_us", "step_p99_us", "real_time")
_CLOCKS = ("step_us", "step_p99_us", "real_time")
"""Fields of a trial itself; the others are its measures'."""
