"""`surefoot bench contact`: every contact solver on every problem, against Pinocchio and Siconos."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.console import Console

from benchmarks.printing import table
from surefoot.app.cli import extras, parsing
from surefoot.app.cli.console import plain_console
from surefoot.app.cli.output import check_out, new_run_folder, to_json
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from benchmarks.contact.comparison import Comparison, FamilyRow, Kind
    from benchmarks.problems.contacts import NamedProblem

QUICK_COPIES, QUICK_CONTACTS, QUICK_FAMILIES, QUICK_TIMED = 0.01, 60, 6, 0.01
"""Of --quick: share of each family's problems (at least one), contacts of the largest, number of families,
and about how long the calls of a solver on a problem are timed [s]."""


def contact(
    folder: Annotated[Path | None, typer.Argument(help="Add the problems of the files in a folder.")] = None,
    scale: Annotated[str, typer.Option(help="robot (up to 25 contacts) or large (up to 600).")] = "robot",
    tol: Annotated[float | None, typer.Option(help="Residual to reach; 1e-9 (robot), 1e-6 (large).")] = None,
    solver: Annotated[
        list[str] | None, typer.Option(help="Ours to run; once for each. All by default.")
    ] = None,
    rivals: Annotated[bool, typer.Option(help="Run Pinocchio, and Siconos if installed.")] = True,
    copies: Annotated[float, typer.Option(min=0.01, max=1e3, help="Times the usual number of problems.")] = 1,
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="Only the smallest problem of each family, no huge ones, timed briefly."
        ),
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the generated problems.")] = 0,
    sequences: Annotated[
        bool, typer.Option("--sequences", help="Bodies on bodies, step after step, instead; CPU times.")
    ] = False,
    scene: Annotated[list[str] | None, typer.Option(help="Of --sequences; once for each.")] = None,
    picture: Annotated[
        bool, typer.Option("--picture", help="Of --sequences: draw accuracy over time, a line a method.")
    ] = False,
    out: Annotated[Path, typer.Option(help="Write JSON to a new folder here.")] = Path("runs"),
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Time every solver on every problem, and certify every answer.

    Two times each: one ready problem again and again, and a new G in every call, set-up included.

    Exit code 1 if the default solver left a problem of its scale unsolved.
    """
    from benchmarks.contact.comparison import OURS, ROBOT_SCALE, TIMED, compare, problems_in
    from benchmarks.problems.contacts import problem_set

    check_out(out)
    extras.require((["pin"] if rivals else []) + (["matplotlib"] if picture else []))
    if picture and not sequences:
        raise ProblemError("--picture is one of --sequences: accuracy over time, scene by scene")
    parsing.seed(seed)
    if tol is not None:
        real_number("--tol", tol, low=1e-15, high=1.0)
    if sequences:
        from benchmarks.commands.contact_sequences import print_sequences

        return print_sequences(scene, 1e-8 if tol is None else tol, rivals, quick, out, json, picture)
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
            problems, wanted, chosen, rivals, progress=lambda name: status.update(f"solving {name}"),
            budget=QUICK_TIMED if quick else TIMED,
        )  # fmt: skip
    if json:
        print(to_json(_record(found)))
    else:
        _print(console, found)
    target = new_run_folder(out, f"contact-{scale}")
    (target / "contact.json").write_text(to_json(_record(found)) + "\n", encoding="utf-8")
    if not json:
        console.print(f"written to {target}", soft_wrap=True)
    return 0 if np.isfinite(found.times()[chosen[0]]).all() else 1


def _smallest(problems: list[NamedProblem]) -> list[NamedProblem]:
    """Return the smallest problem of each of the `QUICK_FAMILIES` families with the smallest ones."""
    least: dict[str, NamedProblem] = {}
    for named in sorted(problems, key=lambda p: p.problem.contacts):
        if named.problem.contacts <= QUICK_CONTACTS:
            least.setdefault(named.family, named)
    return list(least.values())[:QUICK_FAMILIES]


def _rivals(found: Comparison) -> list[str]:
    """Return the names of Pinocchio's solvers in a comparison."""
    return [name for name in found.solvers if name.startswith("pinocchio")]


def _record(found: Comparison) -> dict[str, object]:
    names = _rivals(found)
    ratios = {kind: found.speed_up(names, who, kind) for kind, who in _kinds(found)} if names else {}
    return {"tol": found.tol, "speed_up": ratios, "runs": [asdict(r) for r in found.runs]}


def _kinds(found: Comparison) -> tuple[tuple[Kind, str], tuple[Kind, str]]:
    """Return both kinds of time, with who of ours stands for us in it."""
    return ("ready", found.solvers[0]), ("fresh", found.ours_fresh)


def _print(console: Console, found: Comparison) -> None:
    """Print both times of every solver, then ours by family against Pinocchio's best."""
    names = ("solver", "solved", "of", "ready: mean", "median", "p99", "new G: mean", "median", "p99")
    rows = []
    for name in found.solvers:
        ready, fresh = found.families(name, "ready")[-1], found.families(name, "fresh")[-1]
        rows.append((name, str(ready.solved), str(ready.problems), *_times(ready), *_times(fresh)))
    title = f"Contact problems solved to {found.tol:g}: one ready problem, and a new G each call [µs]; "
    console.print(table(names, rows, title + "mean: geometric"))
    for kind, who in _kinds(found) if _rivals(found) else ():
        _print_families(console, found, kind, who)


def _print_families(console: Console, found: Comparison, kind: Kind, who: str) -> None:
    """Print our times by family, and how many times longer Pinocchio's best takes."""
    what = "one ready problem" if kind == "ready" else "a new G each call, set-up included"
    ratios, rows = found.ratios(_rivals(found), who, kind), []
    ratios["all"] = [x for group in ratios.values() for x in group]
    for row in found.families(who, kind):
        own = ratios.get(row.family, [])
        ratio = (f"{np.exp(np.mean(np.log(own))):.2f}", f"{min(own):.2f}") if own else ("no rival", "")
        rows.append((row.family, str(row.solved), str(row.problems), *_times(row), *ratio))
    names = ("family", "solved", "of", "geometric mean", "median", "p99", "ratio", "least")
    title = f"{what}: {who} [µs], and the time of Pinocchio's best on each problem over it"
    console.print(table(names, rows, title))
    total = found.speed_up(_rivals(found), who, kind)
    missing = f"; on {total['no rival']:.0f} no rival reached {found.tol:g}" if total["no rival"] else ""
    console.print(f"Pinocchio's best is faster on {total['lost']:.0f} problems{missing}")


def _times(row: FamilyRow) -> tuple[str, ...]:
    """Return mean, median and 99th percentile in microseconds."""
    return tuple(f"{1e6 * x:.1f}" for x in (row.mean, row.median, row.p99))
