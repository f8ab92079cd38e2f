"""`surefoot bench contact --sequences`: bodies on bodies, step after step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli.console import plain_console
from surefoot.app.cli.output import new_run_folder, to_json
from surefoot.base.errors import ProblemError, unknown_name

if TYPE_CHECKING:
    from benchmarks.contact.sequences import SequenceRow

STEPS, SAMPLED = 100, 5
"""Steps of a scene, and how many of them are given to rivals."""
QUICK_SCENES, QUICK_STEPS, QUICK_SAMPLED = ("box", "stack of 3"), 10, 1
"""The same of --quick, and its scenes."""
ACCURACIES = (1e-2, 1e-4, 1e-6, 1e-8)


def print_sequences(
    scenes: Sequence[str] | None, tol: float, rivals: bool, quick: bool, out: Path, json: bool,
    picture: bool = False,
) -> int:  # fmt: skip
    """Time every step of the scenes, print or write the rows; 1 if our solver left a step unsolved.

    A picture shows the accuracy over time of every method on one step of each scene.
    """
    from benchmarks.contact.accuracy import AccuracyPath, accuracy_paths, draw_accuracy
    from benchmarks.contact.sequences import SequenceRow, race
    from benchmarks.problems.stacked_scenes import SCENES, steps

    names = scenes or (QUICK_SCENES if quick else tuple(SCENES))
    for name in names:
        if name not in SCENES:
            raise ProblemError(unknown_name("scene", name, SCENES))
    count, sampled = (QUICK_STEPS, QUICK_SAMPLED) if quick else (STEPS, SAMPLED)
    console, rows = plain_console(stderr=json), list[SequenceRow]()
    paths = list[AccuracyPath]()
    target = new_run_folder(out, "contact-sequences")
    try:
        with console.status("stepping") as status:
            for name in names:
                rows += race(name, SCENES[name], count, sampled if rivals else 0, tol, status.update)
                if picture:
                    status.update(f"{name}: accuracy over time")
                    *_, step = steps(SCENES[name], count // 2)
                    paths += accuracy_paths(name, step.problem, rivals)
    finally:  # an interrupted run keeps what it has
        facts = {"tol": tol, "rows": [asdict(row) for row in rows], "paths": [asdict(one) for one in paths]}
        record = to_json(facts)
        (target / "contact.json").write_text(record + "\n", encoding="utf-8")
    if paths:
        draw_accuracy(paths, target / "accuracy.png")
    if json:
        print(record)
    else:
        _print(console, rows, tol)
        console.print(f"written to {target}", soft_wrap=True)
    ours = [row for row in rows if row.solver.startswith("auto")]
    return int(any(row.solved(tol) < row.errors.size for row in ours))


def _print(console: Console, rows: Sequence[SequenceRow], tol: float) -> None:
    """Print times, and how many steps are solved to each accuracy."""
    cells = []
    for row in rows:
        done = row.seconds[np.isfinite(row.seconds)]
        numbers = (np.median(done), np.percentile(done, 99), done.max()) if done.size else ()
        times = [f"{1e6 * seconds:.0f}" for seconds in numbers] or [""] * 3
        judged = not np.isnan(row.errors).any()
        shares = [f"{row.solved(level)}" if judged else "" for level in ACCURACIES]
        cells.append((row.scene, str(row.contacts), row.solver, *times, str(row.errors.size), *shares))
    levels = (f"to {level:g}" for level in ACCURACIES)
    heads = ("scene", "contacts", "solver", "median", "p99", "largest", "steps", *levels)
    console.print(table(heads, cells, f"Bodies on bodies to {tol:g}, set-up included [µs of CPU]"))
