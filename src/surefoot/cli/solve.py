"""`surefoot solve`: contact problems in files, solved and certified."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from surefoot.cli.output import to_json


def solve(
    files: Annotated[
        list[Path], typer.Argument(help="FCLIB .hdf5, Siconos .dat or .npz files.", metavar="FILE...")
    ],
    solver: Annotated[str, typer.Option(help="Who solves; see `surefoot.solver_names`.")] = "auto",
    tol: Annotated[float, typer.Option(min=0.0, help="Natural map that counts as solved.")] = 1e-8,
    max_time: Annotated[float, typer.Option(min=0.0, help="Bound on each solve [s].")] = math.inf,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Solve the contact problems in files and print a certificate for each.

    Exit code 1 if one of them is not solved.
    """
    from surefoot.contact import read_problem, redundancy, residuals
    from surefoot.solvers import solve as solve_problem
    from surefoot.solvers.solver import find_solver

    problems = [(path, read_problem(path)) for path in files]
    for _, problem in problems:
        find_solver(solver, problem)  # bad names before long work
    records: list[dict[str, Any]] = []
    for path, problem in problems:
        found = solve_problem(problem, solver, tol, max_time=max_time)
        shared = redundancy(problem)
        given = None if problem.reference is None else residuals(problem, problem.reference).natural_map
        records.append(
            {
                "file": path.name,
                "contacts": problem.contacts,
                "rank": shared.rank,
                "rows": shared.size,
                "solver": found.solver,
                "status": found.status.value,
                "natural_map": found.residuals.natural_map,
                "reference_natural_map": given,
                "iterations": found.iterations,
                "seconds": found.solve_time,
                "notes": list(problem.notes),
                "forces": found.forces,
                "velocities": found.velocities,
            }
        )
    if json:
        print(to_json(records))
    else:
        _print(records, tol)
    return 0 if all(r["status"] == "solved" for r in records) else 1


def _print(records: list[dict[str, Any]], tol: float) -> None:
    console = Console()
    table = Table(title=f"Contact problems, to be solved to {tol:g}", title_justify="left")
    table.add_column("file", overflow="fold", min_width=18)
    for name in ("n", "rank", "status", "natural map", "steps", "ms"):
        table.add_column(name, justify="left" if name == "status" else "right", no_wrap=True)
    for r in records:
        table.add_row(
            r["file"],
            str(r["contacts"]),
            f"{r['rank']}/{r['rows']}",
            r["status"],
            f"{r['natural_map']:.1e}",
            str(r["iterations"]),
            f"{1e3 * r['seconds']:.2f}",
        )
    console.print(table)
    for r in records:
        for note in r["notes"]:
            console.print(f"{r['file']}: {note}")
