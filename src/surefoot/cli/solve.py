"""`surefoot solve`: contact and linear complementarity problems in files, solved and certified."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from surefoot.arrays import real_number
from surefoot.cli.console import plain_console
from surefoot.cli.output import to_json

if TYPE_CHECKING:  # the other commands need no compiled code
    from surefoot.contact.lcp import LCP
    from surefoot.contact.problem import ContactProblem


def solve(
    files: Annotated[
        list[Path],
        typer.Argument(help="FCLIB .hdf5, Siconos .dat (contact or LCP) or .npz files.", metavar="FILE..."),
    ],
    solver: Annotated[
        str, typer.Option(help="Who solves; LCPs: lemke (auto), pgs, newton, qp, interior_point.")
    ] = "auto",
    tol: Annotated[
        float,
        typer.Option(
            min=0.0, help="Velocity error that counts as solved, relative to the problem's own speeds."
        ),
    ] = 1e-8,
    max_time: Annotated[float, typer.Option(min=0.0, help="Bound on each solve [s].")] = math.inf,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Solve the problems in files, contacts or LCPs, and print a certificate for each.

    Exit code 1 if one of them is not solved.
    """
    from surefoot.contact import read_problem
    from surefoot.contact.files import holds_lcp, read_lcp
    from surefoot.contact.lcp import LCP
    from surefoot.errors import ProblemError, SolverNotFound, unknown_name
    from surefoot.solvers.lcp import lcp_solver_names
    from surefoot.solvers.solver import find_solver

    real_number("--tol", tol, low=0.0, high=1.0)
    problems = []
    for path in files:
        try:
            problems.append((path, read_lcp(path) if holds_lcp(path) else read_problem(path)))
        except EOFError as error:
            raise ProblemError(f"{path} ends before there is a problem in it") from error
    pivoting = "lemke" if solver == "auto" else solver
    for _, problem in problems:  # bad names before long work
        if not isinstance(problem, LCP):
            find_solver(solver, problem)
        elif pivoting not in lcp_solver_names():
            raise SolverNotFound(unknown_name("LCP solver", solver, ("auto", *lcp_solver_names())))
    records = [
        _complementarity(path, problem, pivoting, tol, max_time)
        if isinstance(problem, LCP)
        else _contact(path, problem, solver, tol, max_time)
        for path, problem in problems
    ]
    if json:
        print(to_json(records))
    else:
        _print([r for r in records if r["kind"] == "contact"], tol)
        _print_lcp([r for r in records if r["kind"] == "lcp"], tol)
    return 0 if all(r["status"] == "solved" for r in records) else 1


def _contact(path: Path, problem: ContactProblem, solver: str, tol: float, max_time: float) -> dict[str, Any]:
    """Solve one contact problem; return its record."""
    from surefoot.contact import redundancy, residuals
    from surefoot.solvers import solve as solve_problem

    found = solve_problem(problem, solver, tol, max_time=max_time)
    shared = redundancy(problem)
    given = None if problem.reference is None else residuals(problem, problem.reference).velocity_error
    return {
        "file": path.name,
        "kind": "contact",
        "contacts": problem.contacts,
        "rank": shared.rank,
        "rows": shared.size,
        "solver": found.solver,
        "status": found.status.value,
        "velocity_error": found.residuals.velocity_error,
        "rounding": found.residuals.rounding,
        "natural_map": found.residuals.velocity_error,  # the old name, for one release
        "reference_velocity_error": given,
        "proof": None
        if found.proof is None
        else {
            "direction": found.proof.direction,
            "reach": found.proof.reach,
            "work": found.proof.work,
        },
        "iterations": found.iterations,
        "seconds": found.solve_time,
        "notes": list(problem.notes),
        "forces": found.forces,
        "velocities": found.velocities,
    }


def _complementarity(path: Path, problem: LCP, solver: str, tol: float, max_time: float) -> dict[str, Any]:
    """Solve one LCP; return its record."""
    from surefoot.solvers.lcp import solve_lcp

    found = solve_lcp(problem, solver, tol, max_time=max_time)
    return {
        "file": path.name,
        "kind": "lcp",
        "size": problem.size,
        "solver": found.solver,
        "status": found.status.value,
        "residual": found.residual,
        "iterations": found.iterations,
        "seconds": found.solve_time,
        "message": found.message,
        "ray": found.ray,
        "proof": found.proof,
        "z": found.z,
        "w": found.w,
    }


def _table(kind: str, tol: float, columns: tuple[str, ...]) -> Table:
    """Return an empty table with one row per file to come."""
    table = Table(title=f"{kind} problems, to be solved to {tol:g}", title_justify="left")
    table.add_column("file", overflow="fold", min_width=18)
    for name in columns:
        table.add_column(name, justify="left" if name in ("solver", "status") else "right", no_wrap=True)
    return table


def _print_lcp(records: list[dict[str, Any]], tol: float) -> None:
    """Print one row per LCP, and what there is to say of those without a solution."""
    if not records:
        return
    console = plain_console()
    table = _table("Linear complementarity", tol, ("size", "solver", "status", "residual", "steps", "ms"))
    for r in records:
        table.add_row(
            r["file"],
            str(r["size"]),
            r["solver"],
            r["status"],
            f"{r['residual']:.1e}",
            str(r["iterations"]),
            f"{1e3 * r['seconds']:.2f}",
        )
    console.print(table)
    for r in records:
        if r["message"]:
            console.print(f"{r['file']}: {r['message']}")
        for name, words in (("proof", "proof v"), ("ray", "ray, which proves nothing,")):
            if r[name] is not None:
                console.print(f"{r['file']}: {words} {' '.join(f'{x:.6g}' for x in r[name])}")
                break


def _print(records: list[dict[str, Any]], tol: float) -> None:
    if not records:
        return
    console = plain_console()
    table = _table("Contact", tol, ("n", "rank", "status", "velocity error", "steps", "ms"))
    for r in records:
        table.add_row(
            r["file"],
            str(r["contacts"]),
            f"{r['rank']}/{r['rows']}",
            r["status"],
            f"{r['velocity_error']:.1e}",
            str(r["iterations"]),
            f"{1e3 * r['seconds']:.2f}",
        )
    console.print(table)
    for r in records:
        for note in r["notes"]:
            console.print(f"{r['file']}: {note}")
        if r["proof"] is not None:
            pushed = [k for k, d in enumerate(r["proof"]["direction"]) if any(d)]
            console.print(
                f"{r['file']}: no forces with a sum of norms below {r['proof']['reach']:.2g} N solve it: "
                f"contacts {', '.join(map(str, pushed))} close on each other (proof in --json)"
            )
