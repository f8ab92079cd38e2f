"""`surefoot bench forces`: accuracy against time of force distribution, exact cones and facets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras
from surefoot.app.cli.console import plain_console
from surefoot.base.errors import MissingExtra

WIDTH = 126
"""Columns that the table needs; a narrower terminal wraps its lines."""
QUICK_COUNT, QUICK_INSTANCES, QUICK_STAND = 4, 2, 1.0
"""Of --quick: allocations of each class, instances checked, length of the stand [s]."""
WEIGHTS = (1e-1, 1e-2, 1e-4)
"""Force weights of the check in fifty digits."""


def forces(
    quick: Annotated[bool, typer.Option("--quick", help="Few instances, one short stand: seconds.")] = False,
    count: Annotated[int, typer.Option("--count", min=2, help="Allocations of each class.")] = 200,
    instances: Annotated[int, typer.Option(min=1, help="Random instances checked in fifty digits.")] = 300,
    stands: Annotated[
        bool, typer.Option("--stands/--no-stands", help="Simulate stands, to time warm starts along them.")
    ] = True,
    json: Annotated[bool, typer.Option("--json", help="Print JSON only.")] = False,
) -> None:
    """Compare exact force distribution with cone solvers, and with QP solvers on 4, 8 and 16 facets."""
    from benchmarks.forces.accuracy import measure_accuracy
    from benchmarks.forces.race import run_all
    from benchmarks.forces.warm import measure_all
    from benchmarks.problems.allocations import random_instances

    extras.require(["pin", "clarabel", "qpsolvers"])
    if quick:
        count, instances = min(count, QUICK_COUNT), min(instances, QUICK_INSTANCES)
    steps = 5 * count // 2
    progress = plain_console(stderr=True)
    with progress.status("timing") as status:
        rows = run_all(count, steps, status.update)
        warm = list(measure_all(_trajectories(steps, stands, quick, progress), status.update))
        status.update("checking in fifty digits")
        checks = {weight: measure_accuracy(random_instances(instances), weight) for weight in WEIGHTS}

    def in_words(console: Console) -> None:
        _print(console, rows, checks)
        _print_warm(console, warm)

    tables: dict[str, list[Any]] = {"rows": rows, "warm": warm}
    record: dict[str, Any] = {name: [asdict(row) for row in own] for name, own in tables.items()}
    record["accuracy"] = {str(w): asdict(a) for w, a in checks.items()}
    report(record, json, in_words, WIDTH)


def _trajectories(
    steps: int, stands: bool, quick: bool, progress: Console
) -> Iterator[tuple[str, list[Any]]]:
    """Yield the made trajectory and the busiest stretches of simulated stands."""
    from benchmarks.problems.allocations import busiest, pushed_stance
    from benchmarks.problems.trajectories import SCENES, simulate

    yield "made", pushed_stance(steps, 1.0 / steps)
    for scene in SCENES[: 1 if quick else None] if stands else ():
        try:
            yield scene.name, busiest(simulate(scene, QUICK_STAND) if quick else simulate(scene), steps)
        except MissingExtra as error:
            progress.print(f"no simulated stands: {error}")
            return


def _print(console: Console, rows: list[Any], checks: dict[float, Any]) -> None:
    """Print one table per class of instances, then the check in fifty digits."""
    names = (
        "cone", "solver", "tol", "median [µs]", "p99", "worst", "solved", "off the cone [N]",
        "lost friction", "from exact [N]", "worst", "wrench error",
    )  # fmt: skip
    for kind in dict.fromkeys(row.instances for row in rows):
        cells = [
            (
                row.cone, row.solver + (" warm" if row.warm else ""),
                f"{row.tolerance:.0e}" if row.tolerance == row.tolerance else "",
                *(f"{1e6 * s:.1f}" for s in (row.timing.median, row.timing.p99, row.timing.worst)),
                f"{row.solved:.0%}", f"{row.cone_violation:.1e}", f"{row.lost_friction:+.1%}",
                f"{row.distance:.1e}", f"{row.distance_worst:.1e}", f"{row.shortfall:+.1e}",
            )
            for row in rows if row.instances == kind
        ]  # fmt: skip
        console.print(table(names, cells, kind, left=2))
    for weight, found in checks.items():
        error = " / ".join(f"{value:.1e}" for value in found.error)
        console.print(
            f"{found.instances} random instances, force weight {weight:g}: {found.not_solved} unsolved; "
            f"from the optimum in fifty digits {error} N (median, p99, worst); "
            f"off the cone by at most {found.cone_violation:.1e} N"
        )


def _print_warm(console: Console, rows: list[Any]) -> None:
    """Print what a warm start is worth, a line per trajectory."""
    names = (
        "trajectory", "active", "iterations", "cold", "warm", "ratio", "loop cold", "loop warm", "ratio",
        "DAQP cold", "DAQP warm",
    )  # fmt: skip
    cells = [
        (
            row.trajectory, f"{row.active:.0%}", f"{row.iterations_cold:.1f}→{row.iterations_warm:.1f}",
            _times(row.cold), _times(row.warm), f"{row.warm.median / row.cold.median:.2f}",
            _times(row.loop_cold), _times(row.loop_warm),
            f"{row.loop_warm.median / row.loop_cold.median:.2f}",
            *("-" if t is None else _times(t) for t in (row.daqp_cold, row.daqp_warm)),
        )
        for row in rows
    ]  # fmt: skip
    console.print(table(names, cells, "warm starts: median/99th percentile [µs]; DAQP with 8 inner facets"))


def _times(timing: Any) -> str:
    """Return median and 99th percentile in microseconds."""
    return f"{1e6 * timing.median:.2f}/{1e6 * timing.p99:.2f}"
