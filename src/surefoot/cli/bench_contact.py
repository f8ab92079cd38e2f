"""`surefoot bench contact`: every contact solver on every problem, against Pinocchio and Siconos."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from surefoot.arrays import real_number
from surefoot.cli import extras, parsing
from surefoot.cli.console import plain_console
from surefoot.cli.output import check_out, new_run_folder, to_json

if TYPE_CHECKING:
    from surefoot.bench.contact import Comparison
    from surefoot.bench.problems import NamedProblem

SCALES = ("robot", "large")
QUICK_COPIES, QUICK_CONTACTS = 0.01, 60
"""Of --quick: share of the problems of each family (one at least), and contacts of the largest one."""


def contact(
    folder: Annotated[Path | None, typer.Argument(help="Add the problems of the files in a folder.")] = None,
    scale: Annotated[str, typer.Option(help="robot (up to 25 contacts) or large (up to 600).")] = "robot",
    tol: Annotated[
        float | None, typer.Option(help="Natural map to reach; 1e-9 (robot), 1e-6 (large).")
    ] = None,
    solver: Annotated[
        list[str] | None, typer.Option(help="Ours to run; once for each. All by default.")
    ] = None,
    rivals: Annotated[bool, typer.Option(help="Run Pinocchio, and Siconos if installed.")] = True,
    copies: Annotated[float, typer.Option(min=0.01, help="Times the usual number of problems.")] = 1.0,
    quick: Annotated[
        bool, typer.Option("--quick", help="Only the smallest problem of each family, and no huge ones.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the generated problems.")] = 0,
    out: Annotated[Path, typer.Option(help="Write JSON and pictures to a new folder here.")] = Path("runs"),
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Time every solver on every problem, and certify every answer.

    Exit code 1 if the default solver left a problem of its scale unsolved.
    """
    from surefoot.bench.contact import OURS, RIVALS, ROBOT_SCALE, compare, problems_in
    from surefoot.bench.problems import problem_set

    check_out(out)
    extras.require(["pin"] if rivals else [])
    parsing.seed(seed)
    real_number("--copies", copies, low=0.01, high=1e3)
    if tol is not None:
        real_number("--tol", tol, low=1e-15, high=1.0)
    problems = problem_set(scale, seed, QUICK_COPIES if quick else copies)
    if folder is not None:
        given = problems_in(folder)
        problems += [p for p in given if (p.problem.contacts <= ROBOT_SCALE) == (scale == "robot")]
    if quick:
        problems = _smallest(problems)
    wanted = tol if tol is not None else (1e-9 if scale == "robot" else 1e-6)
    chosen = tuple(solver) if solver else OURS
    console = plain_console(stderr=json)
    with console.status("solving") as status:
        found = compare(
            problems, wanted, chosen, rivals, progress=lambda name: status.update(f"solving {name}")
        )
    names = [n for n in RIVALS if n in found.solvers]
    ratios = found.speed_up(names, chosen[0]) if names else {}
    if json:
        print(to_json(_record(found, ratios)))
    else:
        _print(console, found, ratios)
    target = new_run_folder(out, f"contact-{scale}")
    (target / "contact.json").write_text(to_json(_record(found, ratios)) + "\n", encoding="utf-8")
    error = extras.missing(["matplotlib"])
    if error is None:
        _draw(found, ratios, scale, target, chosen)
    if not json:
        note = "" if error is None else f"; no pictures: {error}"
        console.print(f"written to {target}{note}", soft_wrap=True)
    return 0 if np.isfinite(found.times()[chosen[0]]).all() else 1


def _smallest(problems: list[NamedProblem]) -> list[NamedProblem]:
    """Return the smallest problem of every family that has one of at most `QUICK_CONTACTS` contacts."""
    least: dict[str, NamedProblem] = {}
    for named in sorted(problems, key=lambda p: p.problem.contacts):
        if named.problem.contacts <= QUICK_CONTACTS:
            least.setdefault(named.family, named)
    return list(least.values())


def _record(found: Comparison, ratios: dict[str, float]) -> dict[str, object]:
    return {"tol": found.tol, "speed_up": ratios, "runs": [asdict(r) for r in found.runs]}


def _print(console: Console, found: Comparison, ratios: dict[str, float]) -> None:
    """Print one row per solver, and the speed-up by family."""
    times = found.times()
    table = Table(title=f"Contact problems solved to {found.tol:g}", title_justify="left")
    for name in ("solver", "solved", "of", "median [µs]", "geometric mean [µs]", "worst [µs]"):
        table.add_column(name, justify="left" if name == "solver" else "right")
    for name, seconds in times.items():
        done = seconds[np.isfinite(seconds)] * 1e6
        numbers = (np.median(done), np.exp(np.mean(np.log(done))), done.max()) if done.size else (np.nan,) * 3
        table.add_row(name, str(done.size), str(seconds.size), *(f"{x:.1f}" for x in numbers))
    console.print(table)
    if ratios:
        table = Table(title="Time of the best of Pinocchio's solvers over ours", title_justify="left")
        table.add_column("family")
        table.add_column("ratio", justify="right")
        for name, ratio in ratios.items():
            if name not in ("all", "least", "no rival"):
                table.add_row(name, f"{ratio:.2f}")
        table.add_row("all (geometric mean)", f"{ratios['all']:.2f}", style="bold")
        table.add_row("least", f"{ratios['least']:.2f}")
        console.print(table)
        if ratios["no rival"]:
            console.print(f"on {ratios['no rival']:.0f} problems no rival reached {found.tol:g}")


def _draw(
    found: Comparison, ratios: dict[str, float], scale: str, target: Path, ours: tuple[str, ...]
) -> None:
    from surefoot.bench.contact import performance_profile
    from surefoot.viz.contact_bench import draw_profile, draw_speed_up

    steps = np.logspace(0.0, 4.0, 200)
    count = len({r.problem for r in found.runs})
    profile = performance_profile(found.times(), steps)
    title = f"{count} {scale}-scale contact problems to {found.tol:g}"
    draw_profile(steps, profile, title, target / "profile.png", ours)
    if ratios:
        draw_speed_up(
            ratios, f"{ours[0]} against the best of Pinocchio's ADMM and PGS", target / "speed-up.png"
        )
