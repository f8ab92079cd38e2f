"""`surefoot sweep`: an experiment over thousands of samples of what is not known, and what survives."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from surefoot.app.cli import options, parsing
from surefoot.app.cli.console import progress_bar, say, show, table
from surefoot.app.cli.extras import missing
from surefoot.app.cli.signals import ends_softly, say_interrupted
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.worlds.sweep import SweepConfig, SweepResult
    from surefoot.worlds.sweep.survival import Margin

SHOWN = 6
"""Parameters whose survival is printed, the strongest first; --json has all."""


def sweep(
    config: Annotated[Path, typer.Argument(help="A YAML file of experiment, ranges, samples, seed.")],
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the sweep; one of the same sweep goes on. Default runs/sweep-CONFIG."),
    ] = None,
    samples: Annotated[int | None, typer.Option(help="Number of samples; None for the file's.")] = None,
    seed: Annotated[int | None, typer.Option(help="Seed; None for the file's.")] = None,
    backend: Annotated[str, typer.Option(help="Where samples run: loky, ray, dask or serial.")] = "loky",
    workers: Annotated[int | None, typer.Option(help="Number of workers; None for one per core.")] = None,
    address: Annotated[str | None, typer.Option(help="Of a running Ray or Dask cluster.")] = None,
    part: Annotated[
        str | None, typer.Option(help="K:N: only samples K, K + N, ...; K from 0 to N - 1. None for all.")
    ] = None,
    merge: Annotated[
        list[Path] | None,
        typer.Option(help="Run nothing: take the rows of this folder, or of the parts' folders in it."),
    ] = None,
    allow_code: Annotated[
        bool, typer.Option("--allow-code", help="Let the file's experiment be a function, MODULE:FUNCTION.")
    ] = False,
    picture: options.Picture = True,
    as_json: options.AsJson = False,
) -> int:
    """Run an experiment over samples of ranges, write a Parquet table, and draw what survives.

    Interrupted or killed, the same command goes on where it was. Exit code 0 if every sample has its
    results, 1 if some ended with an error or crashed their worker or are not merged, 2 for wrong input.
    """
    from surefoot.worlds.sweep import merge_sweep, read_sweep, run_sweep

    if part and merge:
        raise ProblemError("--part runs samples, --merge runs none: one of the two")
    share = parsing.numbers("--part", part, "K:N", "3:20") if part else (0, 1)
    planned = read_sweep(config, allow_code).with_numbers(samples, seed)
    folder = Path("runs") / f"sweep-{config.stem}" if out is None else out
    with ends_softly() as stop, progress_bar(not as_json, planned.name, float(planned.samples)) as moved:
        try:
            result = merge_sweep(planned, folder, merge) if merge else run_sweep(
                planned, folder, backend=backend, workers=workers, address=address, part=share,
                tell=None if moved is None else lambda done: moved(float(done)),
            )  # fmt: skip
        except KeyboardInterrupt:
            return say_interrupted(stop, folder)
    facts, found = _facts(result)
    if picture and (error := missing(["matplotlib"])) is not None:
        facts["notes"].append(f"no picture: {error}")
    elif picture:
        from surefoot.app.viz.sweep_plots import draw_sweep

        drawn = draw_sweep(result.config, result.table, result.folder)
        facts["pictures"] = [str(path) for path in drawn]
    show(facts, as_json, partial(_print, config=result.config, found=found))
    return 1 if facts["errors"] or facts["crashed"] or (merge and facts["missing"]) else 0


def _facts(result: SweepResult) -> tuple[dict[str, Any], list[Margin]]:
    """Return what --json prints, and survival over each parameter."""
    from surefoot.worlds.sweep.survival import counts, margins, wilson

    config, number = result.config, counts(result.config, result.table)
    found = sorted(margins(config, result.table), key=lambda m: -m.effect())
    numbers = [name for name, kind in config.experiment.columns.items() if kind == "float"]
    rows = zip(*(result.table[name].to_pylist() for name in ("index", "status", "error")), strict=True)
    return {
        "experiment": config.name,
        "fingerprint": config.fingerprint(),
        "seed": config.space.seed,
        "samples": result.table.num_rows,
        "missing": config.samples - result.table.num_rows,
        "done": number["done"],
        "errors": number["error"],
        "crashed": number["crashed"],
        "first_error": next((f"sample {k}: {error}" for k, status, error in rows if status != "done"), ""),
        "goal": config.experiment.goal,
        "survived": number["survived"],
        "share": vars(wilson(number["survived"], number["done"])),
        "parameters": {
            m.name: [
                {"bin": name, "samples": int(n), **vars(share), "medians": middle}
                for name, n, share, middle in zip(m.labels, m.counts, m.shares(), m.medians, strict=True)
            ]
            for m in found
        },
        "results": {name: _quantiles(result.table, name) for name in numbers},
        **{name: getattr(result, name) for name in ("resumed", "lost_workers", "wall_time")},
        "folder": str(result.folder),
        "table": str(result.path),
        "pictures": [],
        "notes": [],
    }, found


def _quantiles(table: Any, name: str) -> dict[str, float] | None:
    """Return median, 5 % and 95 % of a result; None without one."""
    values = np.array([v for v in table[name].to_pylist() if v is not None], dtype=np.float64)
    if not values.size:
        return None
    low, middle, high = np.percentile(values, [5.0, 50.0, 95.0]).tolist()
    return {"median": middle, "p5": low, "p95": high}


def _print(console: Console, facts: dict[str, Any], config: SweepConfig, found: list[Margin]) -> None:
    for margin in found[:SHOWN]:
        rows = [
            (name, f"{count}", f"{share.value:.3f}", f"{share.low:.3f} to {share.high:.3f}")
            for name, count, share in zip(margin.labels, margin.counts, margin.shares(), strict=True)
        ]
        title = f"{facts['goal']} over {config.label(margin.name)}"
        console.print(table(("", "samples", "share", "95 % interval"), rows, title))
    results = [
        (name, *(f"{values[part]:.4g}" for part in ("median", "p5", "p95")))
        for name, values in facts["results"].items()
        if values is not None
    ]
    console.print(table(("", "median", "5 %", "95 %"), results, "Results"))
    say(console, *_lines(facts))


def _lines(facts: dict[str, Any]) -> list[str]:
    """Return what is said below the tables."""
    share, fresh = facts["share"], facts["samples"] - facts["resumed"]
    done = f"{facts['survived']} of {facts['done']} {facts['goal']}: {share['value']:.3f} "
    out = [
        f"{done}({share['low']:.3f} to {share['high']:.3f})" if facts["done"] else "no sample is done",
        f"{fresh} samples in {facts['wall_time']:.1f} s"
        + (f", {facts['resumed']} were there before" if facts["resumed"] else "")
        + (f", {facts['missing']} are not here" if facts["missing"] else "")
        + (f"; workers died {facts['lost_workers']} times" if facts["lost_workers"] else ""),
    ]
    if facts["errors"] or facts["crashed"]:
        out.append(f"{facts['errors']} errors, {facts['crashed']} crashed; {facts['first_error']}")
    return [*out, *facts["notes"], *(f"picture: {p}" for p in facts["pictures"]), f"table: {facts['table']}"]
