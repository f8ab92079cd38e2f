"""How many seeded faults an audit finds, and how often it cries wolf: the table of docs/reports/audit.md.

Run: python -m benchmarks.audit [--clean 100] [--json]. A fault counts as
found if the first symptom that the audit tells of it has the right name, the right foot, and begins and ends
within 50 ms of it; a fault of the log itself (NaN, clock) if the log is not lawful, at the right time.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from benchmarks.problems.logged_runs import clean_runs
from surefoot.records.audit import AuditReport, audit_log
from surefoot.records.audit.fault_injection import FaultyLog
from surefoot.records.audit.seeded_faults import LOG_FAULTS, LogFault
from surefoot.records.log import Log

NEAR = 0.05
"""A fault is found in time within this [s]."""


@dataclass(frozen=True)
class FaultScore:
    """What came out for one kind of fault: trials, and how many were found with each thing right.

    `wrong` holds the first sentence of each audit that was not fully right.
    """

    fault: LogFault
    trials: int
    noticed: int
    foot: int
    time: int
    cause: int
    found: int
    wrong: tuple[str, ...]

    @property
    def record(self) -> dict[str, object]:
        """What ``--json`` prints of it."""
        fault = {
            name: getattr(self.fault, name) for name in ("name", "title", "amplitude", "unit", "symptom")
        }
        return fault | {name: value for name, value in vars(self).items() if name != "fault"}


def judge(fault: LogFault, spoilt: FaultyLog, report: AuditReport) -> tuple[bool, bool, bool, bool]:
    """Return whether an audit is not "lawful" (or tells a symptom), and has foot, time and cause right."""
    noticed = not report.lawful or bool(report.symptoms)
    if not fault.symptom:
        feet = [v for v in report.violations if v.law in ("finite", "clock")]
        where = any(v.contact == spoilt.contact for v in feet)
        when = any(abs(v.start - spoilt.start) <= NEAR for v in feet)
        return noticed and not report.lawful, where, when, bool(feet)
    if not report.symptoms:
        return noticed, False, False, False
    first = report.symptoms[0]
    foot = first.contact == spoilt.contact or (
        fault.name == "swap" and any(s.contact == spoilt.contact for s in report.symptoms)
    )
    length = spoilt.end - spoilt.start
    if length > 0.5:  # from end to end: it must be told somewhere in it
        when = first.start >= spoilt.start - NEAR and first.end <= spoilt.end + NEAR
    elif fault.name == "blow":
        when = spoilt.start - NEAR <= first.start and first.end <= spoilt.end + NEAR
    elif fault.name == "clipped":
        when = any(
            s.name == first.name and s.start < spoilt.end and spoilt.start < s.end for s in report.symptoms
        )
    else:
        when = abs(first.start - spoilt.start) <= NEAR and abs(first.end - spoilt.end) <= NEAR
    return noticed, foot, when, first.name == fault.symptom


def faulty_logs(fault: LogFault, logs: Iterator[Log], count: int = 8) -> Iterator[FaultyLog]:
    """Yield `count` faulty logs, of the first runs that suit the fault."""
    suitable = (fault.apply(log, seed) for seed, log in enumerate(logs))
    return islice((faulty for faulty in suitable if faulty is not None), count)


def score(fault: LogFault, logs: Iterator[Log], runs: int = 8) -> FaultScore:
    """Spoil `runs` logs that suit and audit them."""
    rows, wrong = [], list[str]()
    for spoilt in faulty_logs(fault, logs, runs):
        report = audit_log(spoilt.log)
        right = judge(fault, spoilt, report)
        rows.append((*right, all(right)))
        if not all(right):
            wrong.append(f"{spoilt.contact} {spoilt.start:.3f}..{spoilt.end:.3f}: {report.sentence}")
    counts = {
        name: sum(row[k] for row in rows)
        for k, name in enumerate(("noticed", "foot", "time", "cause", "found"))
    }
    return FaultScore(fault, len(rows), wrong=tuple(wrong), **counts)


def measure(count: int, runs: int = 8) -> Iterator[FaultScore]:
    """Yield the score of every kind of fault over so many clean runs."""
    kept: dict[int, Log] = {}
    chosen = clean_runs(count)

    def logs() -> Iterator[Log]:
        for k, run in enumerate(chosen):
            if k not in kept:
                kept[k] = run.make()
            yield kept[k]

    for fault in LOG_FAULTS:
        yield score(fault, logs(), runs)


def false_alarms(count: int) -> list[str]:
    """Return a line for each clean run that is not told to be lawful, or has a symptom."""
    out = []
    for run in clean_runs(count):
        report = audit_log(run.make())
        if not report.lawful or report.symptoms:
            out.append(f"{run.name}: {report.sentence}")
    return out


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clean", type=int, default=100)
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    if given.json:
        faults = [s.record for s in measure(given.clean)]
        alarms = false_alarms(given.clean)
        print(json.dumps({"faults": faults, "clean": given.clean, "alarms": alarms}, ensure_ascii=False))
        return
    heads = ("trials", "noticed", "foot", "time", "cause", "all")
    print(f"{'fault':12} {'amplitude':>14}" + "".join(f"{head:>8}" for head in heads))
    total = found = 0
    for s in measure(given.clean):
        size = f"{s.fault.amplitude:.3g} {s.fault.unit}"
        print(
            f"{s.fault.name:12} {size:>14}"
            + "".join(f"{n:8}" for n in (s.trials, s.noticed, s.foot, s.time, s.cause, s.found)),
            flush=True,
        )
        for line in s.wrong:
            print("    " + line[:330])
        total, found = total + s.trials, found + s.found
    print(f"{found} of {total} found with foot, time and cause ({100 * found / max(total, 1):.1f} %)")
    alarms = false_alarms(given.clean)
    print(f"{len(alarms)} false alarms on {given.clean} clean runs")
    for line in alarms:
        print("    " + line[:250])


if __name__ == "__main__":
    main()
