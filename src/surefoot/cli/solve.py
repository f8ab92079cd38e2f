"""`surefoot solve`: contact and linear complementarity problems in files, solved and certified."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from surefoot.arrays import real_number
from surefoot.cli import options
from surefoot.cli.console import show

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
    json: options.AsJson = False,
) -> int:
    """Solve the problems in files, contacts or LCPs, and print a certificate for each.

    Exit code 1 if one of them is not solved.
    """
    from surefoot.contact.files import holds_lcp, read_lcp, read_problem
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
    show(records, json, partial(_print, tol=tol))
    return 0 if all(r["status"] == "solved" for r in records) else 1


def _contact(path: Path, problem: ContactProblem, solver: str, tol: float, max_time: float) -> dict[str, Any]:
    """Solve one contact problem; return its record."""
    from surefoot.contact import residuals
    from surefoot.contact.diagnosis import redundancy
    from surefoot.solvers.solver import solve as solve_problem

    found = solve_problem(problem, solver, tol, max_time=max_time)
    proof, rows = found.proof, redundancy(problem)
    given = None if problem.reference is None else residuals(problem, problem.reference).velocity_error
    return {
        "file": path.name,
        "kind": "contact",
        "contacts": problem.contacts,
        "rank": rows.rank,
        "rows": rows.size,
        "solver": found.solver,
        "status": found.status.value,
        "velocity_error": found.residuals.velocity_error,
        "rounding": found.residuals.rounding,
        "reference_velocity_error": given,
        "proof": None
        if proof is None
        else {key: getattr(proof, key) for key in ("direction", "reach", "work")},
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
    names = ("residual", "iterations", "message", "ray", "proof", "z", "w")
    return {
        "file": path.name,
        "kind": "lcp",
        "size": problem.size,
        "solver": found.solver,
        "status": found.status.value,
        "seconds": found.solve_time,
        **{name: getattr(found, name) for name in names},
    }


def _print(console: Console, records: list[dict[str, Any]], tol: float) -> None:
    """Print a table of contact problems and one of LCPs, and what there is to say of single ones."""
    contacts = [r for r in records if r["kind"] == "contact"]
    if contacts:
        table = _table("Contact", tol, ("n", "rank", "status", "velocity error"))
        for r in contacts:
            size = str(r["contacts"]), f"{r['rank']}/{r['rows']}"
            table.add_row(r["file"], *size, r["status"], f"{r['velocity_error']:.1e}", *_effort(r))
        console.print(table)
        _print_proofs(console, contacts)
    lcps = [r for r in records if r["kind"] == "lcp"]
    if lcps:
        table = _table("Linear complementarity", tol, ("size", "solver", "status", "residual"))
        for r in lcps:
            kept = str(r["size"]), r["solver"], r["status"]
            table.add_row(r["file"], *kept, f"{r['residual']:.1e}", *_effort(r))
        console.print(table)
        _print_rays(console, lcps)


def _table(kind: str, tol: float, columns: tuple[str, ...]) -> Table:
    """Return an empty table with one row per file to come, its effort last."""
    table = Table(title=f"{kind} problems, to be solved to {tol:g}", title_justify="left")
    table.add_column("file", overflow="fold", min_width=18)
    for name in (*columns, "steps", "ms"):
        table.add_column(name, justify="left" if name in ("solver", "status") else "right", no_wrap=True)
    return table


def _effort(record: dict[str, Any]) -> tuple[str, str]:
    """Return iterations and milliseconds."""
    return str(record["iterations"]), f"{1e3 * record['seconds']:.2f}"


def _print_rays(console: Console, records: list[dict[str, Any]]) -> None:
    """Print what there is to say of LCPs without a solution."""
    for r in records:
        if r["message"]:
            console.print(f"{r['file']}: {r['message']}")
        for name, words in (("proof", "proof v"), ("ray", "ray, which proves nothing,")):
            if r[name] is not None:
                console.print(f"{r['file']}: {words} {' '.join(f'{x:.6g}' for x in r[name])}")
                break


def _print_proofs(console: Console, records: list[dict[str, Any]]) -> None:
    """Print notes on contact problems, and the proofs that some have no solution."""
    for r in records:
        for note in r["notes"]:
            console.print(f"{r['file']}: {note}")
        if r["proof"] is not None:
            pushed = [k for k, d in enumerate(r["proof"]["direction"]) if any(d)]
            console.print(
                f"{r['file']}: no forces with a sum of norms below {r['proof']['reach']:.2g} N solve it: "
                f"contacts {', '.join(map(str, pushed))} close on each other (proof in --json)"
            )
