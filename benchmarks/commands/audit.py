"""`surefoot bench audit`: seeded faults of logs, or failures of strangers' loops, as an audit tells them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras
from surefoot.app.cli.console import plain_console
from surefoot.app.cli.output import check_out

if TYPE_CHECKING:
    from benchmarks.foreign.race import Trial

QUICK_CAUSES = ("push", "weak actuator", "slope too steep")
"""What `--quick` runs of the strangers' failures."""
SHORT = 5
"""Letters of a cause's name over a column of the confusion."""
WIDTH = 150
"""Columns that the confusion needs; a narrower terminal wraps its lines."""


def audit(
    foreign: Annotated[
        bool, typer.Option("--foreign", help="Failures of plain MuJoCo loops, and their causes.")
    ] = False,
    price: Annotated[
        bool, typer.Option("--price", help="What sf.record costs beside mj_step, and nothing else.")
    ] = False,
    batch: Annotated[
        bool, typer.Option("--batch", help="Thousands of environments at once, beside one after another.")
    ] = False,
    spoils: Annotated[
        bool, typer.Option("--spoils", help="Contradictions between the channels of lawful logs.")
    ] = False,
    gymnasium: Annotated[
        bool, typer.Option("--gymnasium", help="24 runs of gymnasium's robots that nobody trained.")
    ] = False,
    assets: Annotated[
        Path | None, typer.Option(help="Folder of gymnasium's models, where it is not installed.")
    ] = None,
    seeds: Annotated[
        int, typer.Option(min=1, max=10, help="Seeds per cause of --foreign, of each half.")
    ] = 10,
    held_back: Annotated[
        bool,
        typer.Option("--held-back", help="The half of the seeds of --foreign that rules are not tuned on."),
    ] = False,
    others: Annotated[
        bool, typer.Option("--others", help="Loops of --foreign of other robots, which came after the rules.")
    ] = False,
    cause: Annotated[list[str] | None, typer.Option(help="Only this cause; may be repeated.")] = None,
    clean: Annotated[int, typer.Option(min=1, help="Clean runs that seeded faults are put into.")] = 100,
    quick: Annotated[bool, typer.Option("--quick", help="A few runs only.")] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Put faults into logs, or let strangers' MuJoCo loops fail, and count what the audit tells of it."""
    check_out(out)
    extras.require(["mujoco"])
    if price:
        _price(quick, out, as_json)
    elif batch:
        _batch(quick, out, as_json)
    elif spoils:
        _spoils(quick, out, as_json)
    elif gymnasium:
        _gymnasium(assets, quick, out, as_json)
    elif foreign:
        _foreign(seeds, held_back, others, cause, quick, out, as_json)
    else:
        _seeded(4 if quick else clean, quick, out, as_json)


def _price(quick: bool, out: Path | None, as_json: bool) -> None:
    from benchmarks.record_price import ROUNDS, measure

    rows = list(measure(200 if quick else 2000))
    record = {"models": [{**asdict(row), "ratio": row.ratio} for row in rows]}

    def in_words(console: Console) -> None:
        heads = ("model", "mj_step", "recorded", "ratio", "reading a row", "contacts")
        cells = [
            (r.name, f"{r.step:.1f}", f"{r.recorded:.1f}", f"{r.ratio:.2f}", f"{r.read:.0f}", str(r.contacts))
            for r in rows
        ]
        title = f"sf.record beside mj_step, CPU microseconds a step, best of {ROUNDS}"
        console.print(table(heads, cells, title))

    report(record, as_json, in_words, out=out, name="audit-price")


def _batch(quick: bool, out: Path | None, as_json: bool) -> None:
    from benchmarks.batch_audit import measure

    found = measure(quick)

    def in_words(console: Console) -> None:
        size = f"{found.environments:,} environments of {found.rows:,} rows"
        rows = [
            (f"{size} at once", f"{found.cpu:.3g} s ({found.seconds:.3g} s by the clock)"),
            (f"one after another (from {found.compared} of them)", f"{found.alone:.3g} s"),
            ("of those judged otherwise", f"{found.differ}"),
            ("sf.StepLaws, a step of all: costs alone", f"{found.step:.0f} µs"),
            ("sf.StepLaws, a step of all: rows kept and judged", f"{found.step_kept:.0f} µs"),
        ]
        console.print(table(("audit", "CPU"), rows, "many environments, every second one spoilt"))

    report(asdict(found), as_json, in_words, out=out, name="audit-batch")


def _spoils(quick: bool, out: Path | None, as_json: bool) -> None:
    from benchmarks.spoils import measure

    told = list(measure(3 if quick else None))
    alarms, scores = [x for x in told if isinstance(x, str)], [x for x in told if not isinstance(x, str)]
    record = {"alarms": alarms, "spoils": [asdict(s) for s in scores]}

    def in_words(console: Console) -> None:
        heads = ("spoil", "logs", "beyond the tolerance", "found", "below it", "found all the same")
        cells = [(s.name, *(str(n) for n in (s.logs, s.exceed, s.found, s.below, s.seen))) for s in scores]
        console.print(table(heads, cells, "contradictions between the channels of lawful logs"))
        found, exceed = sum(s.found for s in scores), sum(s.exceed for s in scores)
        console.print(f"{found} of {exceed} that exceed the tolerance found")
        console.print(f"{len(alarms)} alarms on lawful logs")

    report(record, as_json, in_words, out=out, name="audit-spoils")


def _gymnasium(folder: Path | None, quick: bool, out: Path | None, as_json: bool) -> None:
    from benchmarks.gymnasium_runs import assets, measure

    found = assets(folder)
    if isinstance(found, str):
        typer.echo(f"skipped: {found}", err=True)
        return
    rows = list(measure(found, quick))
    record = {"runs": [asdict(row) for row in rows]}

    def in_words(console: Console) -> None:
        heads = ("robot", "actions", "seed", "verdict", "why", "first finding")
        cells = [(r.name, r.actions, str(r.seed), r.verdict, r.why[:60], r.finding[:60]) for r in rows]
        console.print(table(heads, cells, "gymnasium's robots, which nobody trained"))
        counts = {v: sum(r.verdict == v for r in rows) for v in ("lawful", "cannot tell", "broken")}
        console.print(", ".join(f"{n} {v}" for v, n in counts.items()) + f" of {len(rows)}")

    report(record, as_json, in_words, WIDTH, out, "audit-gymnasium")


def _foreign(
    seeds: int, held_back: bool, others: bool, causes: list[str] | None, quick: bool, out: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    from benchmarks.foreign.causes import CAUSES
    from benchmarks.foreign.race import LAWFUL, TUNING, plan, plan_of_others, summary, trials
    from surefoot.base.errors import ProblemError, unknown_name

    known = [one.name for one in CAUSES]
    for name in causes or ():
        if name not in known:
            raise ProblemError(unknown_name("cause", name, known))
    if quick:
        causes, seeds = causes or list(QUICK_CAUSES), 1
    first = TUNING if held_back else 0
    if others:
        tasks = plan_of_others(range(first, first + seeds), causes or ())
    else:
        tasks = plan(range(first, first + seeds), 1 if quick else LAWFUL, causes or ())
    rows: list[Trial] = []
    with plain_console(stderr=True).status("audit") as status:
        try:
            for trial in trials(tasks):
                rows.append(trial)
                status.update(f"{len(rows)} of {len(tasks)}: {trial.loop}, {trial.cause or 'lawful'}")
        except KeyboardInterrupt:
            typer.echo(f"interrupted: {len(rows)} of {len(tasks)} runs are told", err=True)
    half = ("held back" if held_back else "for tuning") + (", other robots" if others else "")
    record = {"seeds": seeds, "half": half, "planned": len(tasks), **summary(rows)}
    title = f"causes of strangers' failures, {seeds} seeds each, {half}"
    report(record, as_json, lambda console: _print(console, title, record, rows), WIDTH, out, "audit-foreign")


def _print(console: Console, title: str, record: dict[str, Any], rows: Sequence[Trial]) -> None:
    """Print the confusion, the loops' shares and what was wrong."""
    from benchmarks.foreign.causes import CAUSES

    counts = record["confusion"]
    others = dict.fromkeys(name for row in counts.values() for name in row)
    columns = [c.name for c in CAUSES if c.name in others]
    columns += [name for name in others if name not in columns]
    heads = [_short(name) for name in columns]
    cells = []
    for one in record["causes"]:
        told = counts[one["name"]]
        shares = [f"{one['first']}/{one['trials']}", f"{one['second']}/{one['trials']}"]
        cells.append((one["name"], *shares, *(str(told.get(name, "")) for name in columns)))
    console.print(table(("cause", "first", "in two", *heads), cells, title))
    of_loops = [
        (one["name"], str(one["trials"]), _share(one, "first"), _share(one, "second"))
        for one in (*record["loops"], record["total"])
    ]
    console.print(table(("loop", "failures", "first right", "among two"), of_loops, "by loop"))
    console.print(f"{len(record['false'])} false causes on {record['controls']} lawful controls")
    laws = dict(record["broken"])
    count, broken = laws.pop("runs"), laws.pop("broken")
    by_law = ", ".join(f"{law} {n}" for law, n in laws.items())
    console.print(f"{broken} of {count} runs are called broken that nobody spoilt{': ' * bool(laws)}{by_law}")
    for trial in rows:
        if (trial.cause and not trial.first) or (not trial.cause and trial.named):
            said = "; ".join(f"{name} at {where}, {when}" for name, where, when in trial.named[:2]) or "none"
            when = "start" if trial.onset is None else f"{trial.onset:.2f} s"
            console.print(f"    {trial.loop}, {trial.cause or 'lawful'} {trial.seed} ({when}): {said}"[:250])


def _short(name: str) -> str:
    """Return a cause's name as a narrow column's head has it."""
    return "\n".join(word[:SHORT] for word in name.split())


def _share(one: dict[str, Any], key: str) -> str:
    return f"{one[key]} ({100.0 * one[key] / max(one['trials'], 1):.1f} %)"


def _seeded(clean: int, quick: bool, out: Path | None, as_json: bool) -> None:
    from benchmarks.audit import FaultScore, false_alarms, measure

    rows: list[FaultScore] = []
    with plain_console(stderr=True).status("audit") as status:
        try:
            for row in measure(clean, 1 if quick else 8):
                rows.append(row)
                status.update(f"{len(rows)} kinds of faults: {row.fault.name}")
        except KeyboardInterrupt:
            typer.echo(f"interrupted: {len(rows)} kinds of faults are told", err=True)
    alarms = false_alarms(clean)
    record = {"faults": [row.record for row in rows], "clean": clean, "alarms": alarms}

    def in_words(console: Console) -> None:
        heads = ("fault", "trials", "noticed", "foot", "time", "cause", "all")
        cells = [
            (r.fault.name, *(str(n) for n in (r.trials, r.noticed, r.foot, r.time, r.cause, r.found)))
            for r in rows
        ]
        console.print(table(heads, cells, "seeded faults of logs"))
        found, total = sum(r.found for r in rows), sum(r.trials for r in rows)
        console.print(f"{found} of {total} found with foot, time and cause")
        console.print(f"{len(alarms)} false alarms on {clean} clean runs")

    report(record, as_json, in_words, out=out, name="audit")
