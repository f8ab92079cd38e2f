"""Runs all seeds of all causes, audits their logs, and counts which causes are named.

A cause is named right if its name is, its place is among the names that the failure allows, and it is dated
within 0.15 s of the onset; a failure without a place allows any, one that is there from the start any time.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import surefoot as sf
from benchmarks.foreign.causes import CAUSES
from benchmarks.foreign.fault import Run
from benchmarks.foreign.loops import LOOPS, OTHERS, failed

NEAR = 0.15
"""A cause is dated right within this [s]."""
TUNING, HELD_BACK = 10, 20
"""Seeds below the first may be looked at; from there to below the second they are held back."""
LAWFUL = 15
"""Lawful controls of a loop."""
WRONG_FRAME = "wrong contact frame"
"""The cause whose logs are spoilt."""
NOTHING = "none"
"""What stands for an audit that names no cause."""


@dataclass(frozen=True)
class Trial:
    """One run, its truth, and what the audit said.

    Attributes
    ----------
    loop, cause, seed
        Which run; the cause is empty for a lawful control.
    detail, failure
        What was injected, and how it failed.
    places, onset
        Names that count as right, and when it began [s].
    named
        (name, place, time) of the causes, likeliest first.
    first, second
        Whether the first cause is right, or one of the first two.
    seconds
        CPU time of the audit [s].
    broken
        Laws that it called broken.
    """

    loop: str
    cause: str
    seed: int
    detail: str
    failure: str
    places: tuple[str, ...]
    onset: float | None
    named: tuple[tuple[str, str, float | None], ...]
    first: bool
    second: bool
    seconds: float
    broken: tuple[str, ...] = ()


def judged(run: Run) -> Trial:
    """Audit a run's log and compare what is said with the truth."""
    begin = time.process_time()
    report = sf.audit_log(run.log)
    seconds = time.process_time() - begin
    named = tuple((c.name, str(c.where), _number(c.time)) for c in getattr(report, "causes", ()))
    cause = "" if run.fault is None else run.fault.cause
    right = [is_right(run, *one) for one in named[:2]]
    return Trial(
        run.loop, cause, run.seed,
        "" if run.fault is None else run.fault.detail, run.failure,
        () if run.fault is None else run.fault.places, run.onset, named,
        any(right[:1]), any(right), seconds, report.laws_broken,
    )  # fmt: skip


def _number(value: Any) -> float | None:
    return None if value is None else float(value)


def is_right(run: Run, name: str, where: str, when: float | None) -> bool:
    """Return whether a cause that was named is the one that was injected.

    Where several places are named, the first counts.
    """
    if run.fault is None or name != run.fault.cause:
        return False
    if run.fault.places and where.split(", ")[0] not in run.fault.places:
        return False
    return run.onset is None or (when is not None and abs(when - run.onset) <= NEAR)


def plan(seeds: Sequence[int], lawful: int, causes: Sequence[str] = ()) -> list[tuple[str, str, int]]:
    """Return what to run: (loop, cause, seed), without a loop for failures, without a cause for controls."""
    names = [cause.name for cause in CAUSES if not causes or cause.name in causes]
    out = [("", name, seed) for name in names for seed in seeds]
    return out + [(loop.name, "", seed) for loop in LOOPS for seed in range(lawful)]


def plan_of_others(seeds: Sequence[int], causes: Sequence[str] = ()) -> list[tuple[str, str, int]]:
    """Return what to run of the loops that came after the rules: their failures, and as many controls."""
    failures = [(loop.name, c, seed) for loop in OTHERS for c in loop.faults for seed in seeds]
    controls = [(loop.name, "", seed) for loop in OTHERS for seed in seeds]
    return [one for one in failures if not causes or one[1] in causes] + controls


def trials(tasks: Sequence[tuple[str, str, int]]) -> Iterator[Trial]:
    """Yield a trial for each of the tasks."""
    loops = {loop.name: loop for loop in (*LOOPS, *OTHERS)}
    for loop, cause, seed in tasks:
        if loop:
            yield judged(loops[loop].failed(cause, seed) if cause else loops[loop].lawful(seed))
        else:
            yield judged(failed(cause, seed))


@dataclass(frozen=True)
class Score:
    """What came out for one cause or one loop.

    Attributes
    ----------
    name
        Of the cause or loop.
    trials, first, second
        Failures, and those of which the first cause is right, or one of the first two.
    """

    name: str
    trials: int
    first: int
    second: int


def score(name: str, of: Sequence[Trial]) -> Score:
    """Count."""
    return Score(name, len(of), sum(t.first for t in of), sum(t.second for t in of))


def summary(of: Sequence[Trial]) -> dict[str, Any]:
    """Return what `--json` prints: scores by cause and loop, the confusion, false causes, every trial."""
    faulty = [t for t in of if t.cause]
    lawful = [t for t in of if not t.cause]
    causes = list(dict.fromkeys(t.cause for t in faulty))
    loops = list(dict.fromkeys(t.loop for t in faulty))
    return {
        "total": vars(score("all", faulty)),
        "causes": [vars(score(c, [t for t in faulty if t.cause == c])) for c in causes],
        "loops": [vars(score(one, [t for t in faulty if t.loop == one])) for one in loops],
        "confusion": {c: confusion([t for t in faulty if t.cause == c]) for c in causes},
        "controls": len(lawful),
        "false": [vars(t) for t in lawful if t.named],
        "broken": law_counts(t for t in of if t.cause != WRONG_FRAME),
        "trials": [vars(t) for t in of],
    }


def law_counts(of: Iterable[Trial]) -> dict[str, int]:
    """Return how many runs break each law: MuJoCo made them, and nobody spoilt their logs."""
    out = {"runs": 0, "broken": 0}
    for trial in of:
        out["runs"] += 1
        out["broken"] += bool(trial.broken)
        for law in trial.broken:
            out[law] = out.get(law, 0) + 1
    return out


def confusion(of: Sequence[Trial]) -> dict[str, int]:
    """Return how often each name came first."""
    out: dict[str, int] = {}
    for trial in of:
        name = trial.named[0][0] if trial.named else NOTHING
        out[name] = out.get(name, 0) + 1
    return out
