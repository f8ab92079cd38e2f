"""`surefoot bench stacks`: walking stacks in one world, task by task, with rates and intervals."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
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
    from benchmarks.stacks.judging import Trial
    from benchmarks.stacks.table import Row

WIDTH = 210
"""Columns that the table needs."""
MEANINGS = (
    "survived: up, on course, lawful. held: within the task's bounds as well (* where that has to "
    "be, in 19 of 20). m/s, error: mean velocity forward, worst distance from the asked one. slip: "
    "longest sliding of one stance, worst. force: largest of a foot in m g. CoT: positive mechanical "
    "work over m g times the way. torque, speed: highest use of a joint's limit. hits: share of steps "
    "with other links touching. cones: share of steps with a commanded force outside the true cone. "
    "CPU: of a step, mean and 99th percentile. x real: simulated over CPU time of the whole loop."
)
Checkout = Annotated[
    Path | None, typer.Option(help="Checkout of it; else the environment variable, see docs/stacks.md.")
]


def stacks(
    stack: Annotated[list[str] | None, typer.Option(help="Only this stack; may be repeated.")] = None,
    task: Annotated[
        list[str] | None,
        typer.Option(help="Only this task, or all that begin with NAME- ; may be repeated."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Trials of each task.")] = 20,
    workers: Annotated[int, typer.Option(min=1, max=256, help="Processes.")] = 1,
    ideal: Annotated[
        bool, typer.Option("--ideal", help="The kind world: true state, ideal motors, feet alone touch.")
    ] = False,
    estimator: Annotated[str | None, typer.Option(help="inekf or truth.")] = None,
    actuators: Annotated[str | None, typer.Option(help="real or ideal.")] = None,
    collision: Annotated[str | None, typer.Option(help="full or feet.")] = None,
    go2_convex_mpc: Checkout = None,
    policy: Annotated[
        list[Path] | None, typer.Option(help="A learned policy's network, a stack more; may be repeated.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Two tasks, one seed, no longer than 5 s.")] = False,
    resume: Annotated[Path | None, typer.Option(help="Folder of an interrupted bench to go on with.")] = None,
    out: Annotated[Path | None, typer.Option(help="Keep every trial in a new folder below this one.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> int:
    """Let walking stacks do the same tasks in the same world; print who survives, how well, at what cost.

    Survived: upright, on course and lawful. Held: within the task's bounds as well.
    """
    from benchmarks.stacks.bench import Bench, measure
    from benchmarks.stacks.setting import HARD, IDEAL, Setting
    from benchmarks.stacks.stacks import choose_stacks
    from benchmarks.stacks.table import fastest_held, rows
    from benchmarks.stacks.tasks import QUICK, QUICK_TIME, choose_tasks

    check_out(out)
    extras.require((*extras.robot_packages("go2"), "mujoco"))
    base = IDEAL if ideal else HARD
    setting = Setting(estimator or base.estimator, actuators or base.actuators, collision or base.collision)
    tasks = choose_tasks(task or (QUICK if quick else None))
    if quick:
        tasks, seeds = tuple(replace(t, duration=min(t.duration, QUICK_TIME)) for t in tasks[:2]), 1
    chosen = choose_stacks(stack, {"go2-convex-mpc": go2_convex_mpc}, policy or ())
    bench = Bench(chosen.stacks, tasks, seeds, setting)
    folder = _folder(out, resume)
    quiet = not sys.stderr.isatty()
    with ends_softly() as stop, progress_bar(not as_json, "bench stacks", 1.0) as show:

        def tell(trial: Trial, done: int, count: int) -> None:
            if show is not None:
                show(done / count)
            elif quiet and not as_json:
                typer.echo(f"{done}/{count} {_said(trial)}", err=True)

        trials = measure(bench, folder, workers, tell)
    found = rows(trials)
    complete = len(trials) == len(bench.trials())
    record = {
        **bench.header(), "absent": chosen.absent, "seeds": seeds, "complete": complete,
        "fastest_held": fastest_held(found), "rows": [row.as_dict() for row in found],
    }  # fmt: skip
    report(record, as_json, lambda console: _print(console, found, record), WIDTH)
    if folder is not None:
        (folder / "stacks.json").write_text(to_json(record) + "\n", encoding="utf-8")
        typer.echo(f"written: {folder / 'stacks.json'}", err=True)
    if not complete:
        typer.echo(f"interrupted: {len(trials)} of {len(bench.trials())} trials", err=True)
        return stop.code
    return 0


def _folder(out: Path | None, resume: Path | None) -> Path | None:
    """Return where trials are kept."""
    if resume is None:
        return None if out is None else new_run_folder(out, "bench-stacks")
    if out is not None:
        raise ProblemError("--resume goes on in its own folder: leave out --out")
    if not (resume / "trials.jsonl").is_file():
        raise ProblemError(f"--resume {resume}: no trials.jsonl there")
    return resume


def _said(trial: Trial) -> str:
    from benchmarks.stacks.tasks import TASKS
    from benchmarks.stacks.trial import asked_velocity

    task = TASKS[trial.task]
    faults = trial.faults(task, asked_velocity(task))
    return f"{trial.stack} {trial.task} seed {trial.seed}: {'; '.join(faults) or 'held'}"


def _print(console: Console, found: list[Row], record: dict[str, Any]) -> None:
    columns = (
        "task", "stack", "up", "course", "lawful", "survived", "interval", "held", "m/s", "error",
        "slip [mm]", "force", "CoT", "torque", "speed", "hits", "cones", "CPU [us]", "p99", "x real",
        "what was wrong",
    )  # fmt: skip
    title = f"up to {record['seeds']} seeds each; intervals of 95 %"
    console.print(table(columns, map(_cells, found), title, 2, columns[-1:]))
    for name, why in record["absent"].items():
        console.print(f"{name}: not here: {why}", soft_wrap=True)
    for name, speed in record["fastest_held"].items():
        console.print(f"{name}: holds the ladder of speeds up to {speed:g} m/s", soft_wrap=True)
    missed = [row for row in found if row.must and not row.holds]
    console.print(
        f"{MEANINGS} Not held of what has to be: {len(missed)} of {sum(row.must for row in found)}.",
        soft_wrap=True,
    )


def _cells(row: Row) -> list[str]:
    def number(value: float, form: str, factor: float = 1.0) -> str:
        return "-" if math.isnan(value) else format(factor * value, form)

    low, high = row.survival.low, row.survival.high
    wrong = "; ".join(f"{count} x {fault}" for fault, count in row.faults.items())
    return [
        f"{row.task}{'*' if row.must else ''}", row.stack,
        str(row.upright), str(row.on_course), str(row.lawful), f"{row.survived}/{row.trials}",
        f"{100 * low:.0f} to {100 * high:.0f} %", f"{row.held}/{row.trials}", number(row.forward, ".3f"),
        number(row.velocity_error, ".3f"), number(row.slip, ".1f", 1e3), number(row.load, ".1f"),
        number(row.cost_of_transport, ".2f"),
        number(row.torque_use, ".2f"), number(row.speed_use, ".2f"), number(row.hits, ".1%"),
        number(row.cone_violations, ".0%"),
        number(row.step_us, ".0f"), number(row.step_p99_us, ".0f"), number(row.real_time, ".1f"),
        wrong or "nothing",
    ]  # fmt: skip
