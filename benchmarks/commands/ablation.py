"""`surefoot bench ablation`: what walking loses without each behaviour and heuristic; values of a setting."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras
from surefoot.app.cli.console import progress_bar
from surefoot.app.cli.output import check_out, new_run_folder, to_json
from surefoot.app.cli.signals import ends_softly
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from benchmarks.ablation.comparing import Comparison

WIDTH = 170
"""Columns that the table needs."""
QUICK = 1.0
"""Length of a walk of --quick [s]."""
MEANINGS = (
    "done: survived, or upright where a robot should stop, before and after. chance: of so unequal a split "
    "if nothing is lost. Differences: means over seeds done both ways, 95 % intervals; * worse, + better, "
    "beyond noise and by enough to matter. hits: share of the steps at which other links touch."
)


def ablation(
    only: Annotated[list[str] | None, typer.Option(help="Only this part; may be repeated.")] = None,
    vary: Annotated[
        str | None,
        typer.Option(
            help="Try values of this setting, or of all of a class: Class.setting, see docs/settings.md."
        ),
    ] = None,
    value: Annotated[list[float] | None, typer.Option(help="A value to try; may be repeated.")] = None,
    factor: Annotated[
        list[float] | None,
        typer.Option(
            min=1.001, help="Try values over the setting's own, and it over them; may be repeated. Default 2."
        ),
    ] = None,
    task: Annotated[list[str] | None, typer.Option(help="Only this task; may be repeated.")] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Trials of each task.")] = 6,
    quick: Annotated[bool, typer.Option("--quick", help="One part, one task, one seed, one second.")] = False,
    out: Annotated[Path | None, typer.Option(help="Keep every trial in a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> int:
    """Leave out each behaviour and heuristic of walking in turn, or try values of a setting."""
    from benchmarks.ablation.parts import FIRST_SEED, TASKS, choose_parts
    from benchmarks.ablation.trials import Trials
    from surefoot.base.errors import unknown_name

    check_out(out)
    extras.require((*extras.robot_packages("go2"), "mujoco"))
    for name in task or ():
        if name not in TASKS:
            raise ProblemError(unknown_name("task", name, tuple(TASKS)))
    if vary is not None and only:
        raise ProblemError("--vary tries values of a setting: leave out --only")
    if (value or factor) and vary is None:
        raise ProblemError(f"--{'value' if value else 'factor'} is for --vary")
    if value and factor:
        raise ProblemError("give --value or --factor")
    parts = choose_parts(only or (["brisk"] if quick else None))
    folder = None if out is None else new_run_folder(out, "bench-ablation")
    given = range(FIRST_SEED, FIRST_SEED + (1 if quick else seeds))
    rows: list[tuple[str, Comparison]] = []
    record: dict[str, Any] = {"seeds": list(given), "complete": False}
    quiet = not sys.stderr.isatty() and not as_json
    with ends_softly() as stop, progress_bar(not as_json, "bench ablation", 1.0) as show:

        def tell(line: str, done: int, count: int) -> None:
            if show is not None:
                show(done / count)
            elif quiet:
                typer.echo(f"{done}/{count} {line}", err=True)

        def make(total: int) -> Trials:
            return Trials(given, total, tell, keep, QUICK if quick else None)

        keep = None if folder is None else folder / "trials.jsonl"
        try:
            if vary is not None:
                _vary(vary, (value, factor), task, quick, record, rows, make)
            else:
                _leave_out(parts, task, quick, rows, make)
            record["complete"] = True
        except KeyboardInterrupt:
            pass  # what there is so far is the answer
    record["rows"] = [{"change": name, "worse": c.worse, "better": c.better, **asdict(c)} for name, c in rows]
    report(record, as_json, lambda console: _print(console, rows, record), WIDTH)
    if folder is not None:
        (folder / "ablation.json").write_text(to_json(record) + "\n", encoding="utf-8")
        typer.echo(f"written: {folder / 'ablation.json'}", err=True)
    return 0 if record["complete"] else stop.code


def _leave_out(parts: Any, task: list[str] | None, quick: bool, rows: Any, make: Any) -> None:
    """Append a comparison to the rows for each task of each part that is left out."""
    from benchmarks.ablation.comparing import compare
    from benchmarks.ablation.trials import Change

    chosen = {p.name: [t for t in p.tasks if not task or t in task][: 1 if quick else None] for p in parts}
    first = {name for names in chosen.values() for name in names}
    trials = make(1)
    trials.total = len(trials.seeds) * (len(first) + sum(len(names) for names in chosen.values()))
    for part in parts:
        if chosen[part.name]:
            before = trials.of(Change("everything"), chosen[part.name])
            change = Change(part.name, part.without, part.changes)
            after = trials.of(change, chosen[part.name])
            rows += [(part.name, compare(name, before, after)) for name in chosen[part.name]]


def _vary(
    name: str, tried: tuple[list[float] | None, list[float] | None], task: list[str] | None, quick: bool,
    record: dict[str, Any], rows: Any, make: Any,
) -> None:  # fmt: skip
    """Append a comparison to the rows for each task and value of each setting, and note the verdicts."""
    from benchmarks.ablation.varying import find_settings, shown, try_values, verdict

    given, factors = tried
    settings = find_settings(name)[: 1 if quick else None]
    tasks = {one.name: list(task or one.tasks)[: 1 if quick else None] for one in settings}
    values = {one.name: one.values(given, factors)[: 1 if quick else None] for one in settings}
    first = {name for names in tasks.values() for name in names}
    trials = make(1)
    count = len(first) + sum(len(tasks[one.name]) * len(values[one.name]) for one in settings)
    trials.total = len(trials.seeds) * count
    record["settings"] = []
    for one in settings:
        found = try_values(one, values[one.name], trials, tasks[one.name], outwards=not given)
        rows += [(f"{one.name}={shown(other.value)}", c) for other in found for c in other.comparisons]
        said = {"setting": one.name, "value": one.value, "verdict": verdict(one, found)}
        record["settings"].append(said)


def _print(console: Console, rows: list[tuple[str, Comparison]], record: dict[str, Any]) -> None:
    from benchmarks.ablation.comparing import MEASURES
    from benchmarks.ablation.varying import shown

    columns = ("change", "task", "done", "chance", *MEASURES.values())
    cells = [
        (name, c.task, f"{c.before} -> {c.after} of {c.trials}", f"{c.chance:.2g}", *_cells(c))
        for name, c in rows
    ]
    console.print(table(columns, cells, f"{len(record['seeds'])} seeds from {record['seeds'][0]}", 2))
    console.print(MEANINGS, soft_wrap=True)
    for one in record.get("settings", ()):
        console.print(f"{one['setting']} = {shown(one['value'])}: {one['verdict']}", soft_wrap=True)


def _cells(c: Comparison) -> list[str]:
    """Return the differences of a comparison, a cell for each measure."""
    from benchmarks.ablation.comparing import MEASURES

    by_name = {one.measure: one for one in c.differences}
    out = []
    for name in MEASURES:
        d = by_name.get(name)
        if d is None:
            out.append("-")
            continue
        mark = "*" if d.worse else "+" if d.better else ""
        out.append(f"{d.before:.3g} {d.after - d.before:+.2g} ({d.low:+.2g} to {d.high:+.2g}){mark}")
    return out
