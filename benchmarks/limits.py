"""Vary the limits of an audit, one at a time, over logs with seeded faults, clean ones, and made cases.

Run: python -m benchmarks.limits [NAME...] [--runs 1] [--clean 20] [--keep FOLDER] [--json]. NAME is a limit
as `surefoot.records.audit.limits.LIMITS` has it ("laws.pull") or a group of them ("laws"); all without one.
FOLDER keeps the clean runs, which are simulated once. What the made cases are is in `benchmarks.limit_cases`.

Each limit is moved away from its value in both directions, further and further, until the audits do worse: a
fault is no longer found with its foot, time and cause (see `benchmarks.audit`), or a clean run is no longer
lawful without any symptom, finding about its command, or friction beside the ground's, or what is said of a
made case is wrong. Printed are the range
over which nothing changes, and what the first value beyond it costs. The choice of a limit is repeated if its
value does as well as any that was tried and at least one does worse; a limit that may take any value without
effect on these logs is not decided by them.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.audit import judge
from benchmarks.limit_cases.command_cases import command_cases
from benchmarks.limit_cases.consistency_cases import consistency_cases
from benchmarks.limit_cases.contact_time_cases import contact_time_cases
from benchmarks.limit_cases.friction_cases import friction_cases
from benchmarks.limit_cases.law_cases import law_cases
from benchmarks.limit_cases.measured_cases import measured_cases
from benchmarks.limit_cases.rival_cases import rival_cases
from benchmarks.limit_cases.robot_cases import robot_cases
from benchmarks.limit_cases.run_cases import run_cases
from benchmarks.limit_cases.symptom_cases import symptom_cases
from benchmarks.limit_cases.verdict import CleanLogs, Verdict
from benchmarks.problems.logged_runs import clean_runs
from surefoot.mechanics import load_robot
from surefoot.records.audit import AuditReport, audit_log, log_context
from surefoot.records.audit import rows as audit_rows
from surefoot.records.audit.fault_injection import FaultyLog
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.seeded_faults import LOG_FAULTS, LogFault
from surefoot.records.log import Log
from surefoot.records.log.reading import read_log

FACTORS = (3.0, 30.0, 300.0, 3000.0)
"""Steps away from a limit's value, each way."""
RANK_STEPS = (0.006, 0.1, 1.0)
"""Steps of a symptom's strength, each way."""
WHOLE_STEPS = (1, 4, 20)
"""Steps of a whole number, each way."""
MOST_BY_STEPS = 100
"""Whole numbers beyond this move by factors, as others do."""
OTHER_FRICTION = 0.05
"""Share by which an interval of friction may be beside the ground's own [-]."""


@dataclass(frozen=True)
class Case:
    """A log, and what is right to say about it: a fault, or nothing for a clean run."""

    name: str
    log: Log
    fault: LogFault | None = None
    faulty: FaultyLog | None = None

    def right(self, limits: AuditLimits) -> bool:
        """Return whether an audit with these limits says the right thing."""
        report = audit_log(self.log, limits=limits)
        if self.fault is not None and self.faulty is not None:
            return all(judge(self.fault, self.faulty, report))
        return report.lawful and not report.symptoms and not report.command and self._friction_fits(report)

    def _friction_fits(self, report: AuditReport) -> bool:
        low, high = (float(f(self.log["mu"])) for f in (np.min, np.max))
        return all(
            one.low <= (1.0 + OTHER_FRICTION) * high and one.high >= (1.0 - OTHER_FRICTION) * low
            for one in report.friction
        )


@dataclass(frozen=True)
class Varied:
    """What came of varying one limit.

    Attributes
    ----------
    name, value, unit
        Of the limit.
    low, high
        Least and largest value tried that does as well as its own.
    below, above
        The first case that goes wrong with the next value down and up; empty where none of the values tried
        does worse.
    worse_below, worse_above
        Those next values; None where none does worse.
    reads
        Number of cases whose audit reads the limit.
    """

    name: str
    value: float
    unit: str
    low: float
    high: float
    below: str
    above: str
    worse_below: float | None
    worse_above: float | None
    reads: int

    @property
    def decided(self) -> bool:
        """Whether a value that was tried does worse: none can do better than all right."""
        return bool(self.below or self.above)


def cases(runs: int, clean: int, keep: Path | None) -> list[Case | Verdict]:
    """Return made cases, logs with so many faults of each kind, and clean ones: all that are judged right."""
    logs = [_kept(run, keep) for run in clean_runs(max(clean, 20))]
    names = [run.name for run in clean_runs(max(clean, 20))]
    out: list[Case | Verdict] = list(made_cases(logs.__getitem__))
    for fault in LOG_FAULTS:
        found = 0
        for seed, (name, log) in enumerate(zip(names, logs, strict=True)):
            faulty = fault.apply(log, seed) if found < runs else None
            if faulty is not None:
                found += 1
                out.append(Case(f"{fault.name} in {name}", faulty.log, fault, faulty))
    out += [Case(name, log) for name, log in zip(names[:clean], logs[:clean], strict=True)]
    return [case for case in out if case.right(LIMITS)]


def made_cases(logs: CleanLogs) -> Iterator[Verdict]:
    """Yield the cases of `benchmarks.limit_cases`, from the clean runs by number."""
    yield from run_cases(logs)
    for some in (
        contact_time_cases, law_cases, consistency_cases, friction_cases, command_cases, symptom_cases,
        rival_cases,
    ):  # fmt: skip
        yield from some()
    yield from robot_cases(logs)
    yield from measured_cases(logs)


def _kept(run: Any, keep: Path | None) -> Log:
    if keep is None:
        made: Log = run.make()
        return made
    path = keep / f"{run.name}.npz"
    if not path.exists():
        run.make().save(path)
    return read_log(path)


def limits_read(case: Case | Verdict) -> set[str]:
    """Return the dotted names of the limits that are read to judge a case."""
    read: set[str] = set()

    def noting(group: str, part: Any) -> Any:
        names = {one.name for one in fields(part)}

        def get(self: Any, name: str) -> Any:
            if name in names:
                read.add(f"{group}.{name}")
            return object.__getattribute__(self, name)

        kind = type(f"Noted{type(part).__name__}", (type(part),), {"__getattribute__": get})
        return kind(**asdict(part))

    noted = AuditLimits(**{one.name: noting(one.name, getattr(LIMITS, one.name)) for one in fields(LIMITS)})
    read.clear()
    case.right(noted)
    return read


def values_away(
    name: str, value: float, whole: bool, up: bool, factors: Sequence[float] = FACTORS
) -> Iterator[float]:
    """Yield values further and further from a limit's own, in one direction.

    Strengths move by steps; numbers near one by their distance from it; others by factors.
    """
    sign = 1.0 if up else -1.0
    if whole and value <= MOST_BY_STEPS:
        yield from (value + sign * step for step in WHOLE_STEPS)
    elif name.startswith("ranks."):
        yield from (value + sign * step for step in RANK_STEPS)
    elif 0.8 < value < 1.2 and value != 1.0:
        away = value - 1.0
        yield from (1.0 + away * (f if up == (away > 0.0) else 1.0 / f) for f in factors)
    else:
        yield from (value * (f if up else 1.0 / f) for f in factors)


def vary(name: str, tried: Sequence[Case | Verdict]) -> Varied:
    """Return what comes of varying a limit over the cases whose audits read it."""
    one = next(d for d in LIMITS.described() if d.name == name)
    value, queue = float(one.value or 0.0), list(tried)
    ends, wrong = [value, value], ["", ""]
    next_values: list[float | None] = [None, None]
    for way in (0, 1):
        for new in values_away(name, value, one.info.whole, bool(way)):
            low = -math.inf if one.info.low is None else one.info.low
            high = math.inf if one.info.high is None else one.info.high
            clipped = min(max(new, low), high)
            if clipped == ends[way]:
                break
            limits = changed(name, int(clipped) if one.info.whole else clipped)
            failed = next((case for case in queue if not case.right(limits)), None)
            if failed is not None:
                wrong[way], next_values[way] = failed.name, clipped
                queue.remove(failed)
                queue.insert(0, failed)  # what is sensitive to this limit is looked at first
                break
            ends[way] = clipped
    return Varied(
        name,
        value,
        one.info.unit,
        ends[0],
        ends[1],
        wrong[0],
        wrong[1],
        next_values[0],
        next_values[1],
        len(tried),
    )


def changed(name: str, value: float) -> AuditLimits:
    """Return the limits with one of them changed, by its dotted name."""
    group, _, field = name.partition(".")
    return replace(LIMITS, **{group: replace(getattr(LIMITS, group), **{field: value})})


def remember_motion() -> None:
    """Let audits share robots, and what the motion of the same rows leaves unexplained."""
    vars(log_context)["load_robot"] = cache(load_robot)
    known: dict[bytes, Any] = {}

    def remembered(function: Callable[..., Any], robot: Any, log: Log, *more: Any) -> Any:
        digest = hashlib.blake2b(repr((function.__name__, robot.name, sorted(log.facts))).encode())
        for part in (*(log.arrays[name] for name in sorted(log.arrays)), *more):
            digest.update(np.ascontiguousarray(0.0 if part is None else part, dtype=np.float64).tobytes())
        key = digest.digest()
        if key not in known:
            known[key] = function(robot, log, *more)
        return known[key]

    for name in ("unexplained", "balanced_forces"):
        setattr(audit_rows, name, partial(remembered, getattr(audit_rows, name)))


def measure(names: Sequence[str], runs: int, clean: int, keep: Path | None) -> Iterator[Varied]:
    """Yield what comes of varying each of the named limits, or those of the named groups."""
    remember_motion()
    every = cases(runs, clean, keep)
    read = [limits_read(case) for case in every]
    for one in LIMITS.described():
        group = one.name.partition(".")[0]
        if not names or one.name in names or group in names:
            yield vary(
                one.name,
                [case for case, names_read in zip(every, read, strict=True) if one.name in names_read],
            )


def main() -> None:
    """Print a line for each limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="limits or groups of them (default: all)")
    parser.add_argument("--runs", type=int, default=1, help="logs of each kind of fault")
    parser.add_argument("--clean", type=int, default=20, help="clean runs")
    parser.add_argument("--keep", type=Path, help="folder of the clean runs")
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    found = []
    for one in measure(given.names, given.runs, given.clean, given.keep):
        found.append(asdict(one) | {"decided": one.decided})
        if not given.json:
            below, above = (
                f"{at:g}: {case}" if at is not None else "none worse"
                for at, case in ((one.worse_below, one.below), (one.worse_above, one.above))
            )
            print(
                f"{one.name:32} {one.value:10.4g} {one.unit:8} same from {one.low:.4g} to {one.high:.4g}; "
                f"{'decided' if one.decided else 'not decided'} ({one.reads} logs read it)\n"
                f"{'':32} below: {below}; above: {above}",
                flush=True,
            )
    if given.json:
        print(json.dumps(found))
    else:
        print(f"{sum(bool(one['decided']) for one in found)} of {len(found)} limits decided")


if __name__ == "__main__":
    main()
