"""`surefoot bench forces`: accuracy against time of force distribution, exact cones and facets."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from surefoot.cli.output import new_run_folder, to_json

WIDTH = 118
"""Columns that the table needs; a narrower terminal wraps its lines."""
WEIGHTS = (1e-1, 1e-2, 1e-4)
"""Force weights of the check against Clarabel."""


def forces(
    out: Annotated[Path | None, typer.Option(help="Write a picture to a new folder below this one.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A fifth of the instances.")] = False,
    count: Annotated[int, typer.Option("--count", min=2, help="Allocations of each class.")] = 200,
    instances: Annotated[int, typer.Option(min=0, help="Random instances checked against Clarabel.")] = 300,
    log: Annotated[
        Path | None, typer.Option(help="A log.npz; its busiest stretch is the trajectory.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Compare exact force distribution with cone solvers, and with QP solvers on 4, 8 and 16 facets."""
    from surefoot.bench.forces import run_all
    from surefoot.bench.forces_accuracy import measure_accuracy
    from surefoot.bench.forces_instances import busiest, random_instances, read_log
    from surefoot.bench.forces_torques import time_torque_limits

    count = max(2, count // 5) if quick else count
    progress = Console(stderr=True)
    logged = None if log is None else busiest(read_log(log), 5 * count // 2)
    with progress.status("timing") as status:
        rows = run_all(count, 5 * count // 2, logged, lambda text: status.update(text))
        torques = time_torque_limits(count)
        status.update("checking against Clarabel")
        checks = {
            weight: measure_accuracy(random_instances(instances), weight) if instances else None
            for weight in WEIGHTS
        }
    if json:
        found = {str(w): None if a is None else asdict(a) for w, a in checks.items()}
        rows_found = {"rows": [asdict(row) for row in rows], "torques": [asdict(row) for row in torques]}
        print(to_json({**rows_found, "accuracy": found}))
    else:
        console = Console()
        console = console if console.width >= WIDTH else Console(width=WIDTH)
        _print(console, rows, checks)
        _print_torques(console, torques)
    if out is not None:
        from surefoot.viz.forces_bench import plot_accuracy

        path = plot_accuracy(rows, new_run_folder(out, "bench-forces"))
        typer.echo(f"picture: {path}", err=True)


def _print(console: Console, rows: list[Any], checks: dict[float, Any]) -> None:
    """Print one table per class of instances, then the check against Clarabel."""
    for kind in dict.fromkeys(row.instances for row in rows):
        table = Table(
            "cone", "solver", "median [µs]", "p99", "worst", "solved", "off the cone [N]", "lost friction",
            "from exact [N]", "worst", "wrench error", title=kind, title_justify="left",
        )  # fmt: skip
        for row in rows:
            if row.instances == kind:
                t = row.timing
                table.add_row(
                    row.cone, row.solver + (" warm" if row.warm else ""),
                    *(f"{1e6 * s:.1f}" for s in (t.median, t.p99, t.worst)),
                    f"{row.solved:.0%}", f"{row.cone_violation:.1e}", f"{row.lost_friction:+.1%}",
                    f"{row.distance:.1e}", f"{row.distance_worst:.1e}", f"{row.shortfall:+.1e}",
                )  # fmt: skip
        console.print(table)
    for weight, found in checks.items():
        if found is not None:
            apart, mine, its = (
                " / ".join(f"{v:.1e}" for v in values)
                for values in (found.force_distance, found.error, found.error_clarabel)
            )
            console.print(
                f"{found.instances} random instances, force weight {weight:g}: {found.not_solved} unsolved; "
                f"objective above Clarabel's by at most {found.objective_excess:.1e} (relative); "
                f"forces apart by {apart} N (median, p99, worst), more than 1e-5 N in {found.far}; "
                f"from the optimum in fifty digits {mine} N, Clarabel's {its} N; "
                f"off the cone by at most {found.cone_violation:.1e} N"
            )


def _print_torques(console: Console, rows: list[Any]) -> None:
    """Print what torque limits cost, a line per limit."""
    for row in rows:
        console.print(
            f"torque limit {row.limit:g} N·m: binds in {row.binding:.0%}, solved {row.solved:.0%}, "
            f"worst excess {row.excess:.1e} N·m, {1e6 * row.timing.median:.1f} µs median, "
            f"{1e6 * row.timing.p99:.1f} µs p99"
        )
