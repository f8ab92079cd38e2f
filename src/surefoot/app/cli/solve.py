"""`surefoot solve`: contact and linear complementarity problems in files, solved and certified."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import options
from surefoot.app.cli.console import show, table
from surefoot.base.arrays import real_number

if TYPE_CHECKING:  # the other commands need no compiled code
    from surefoot.contact import ContactProblem
    from surefoot.contact.problem.lcp import LCP


def solve(
    files: Annotated[
        list[Path],
        typer.Argument(help="FCLIB .hdf5, Siconos .dat (contact or LCP) or .npz files.", metavar="FILE..."),
    ],
    solver: Annotated[str, typer.Option(help="Who solves; LCPs: lemke (auto), interior_point.")] = "auto",
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
    from surefoot.base.errors import ProblemError, SolverNotFound, unknown_name
    from surefoot.contact.files.formats import holds_lcp, read_lcp, read_problem
    from surefoot.contact.problem.lcp import LCP
    from surefoot.contact.solvers.solver import find_solver

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
        else:
            from surefoot.contact.solvers.lcp_solver import METHODS

            if pivoting not in METHODS:
                raise SolverNotFound(unknown_name("LCP solver", solver, ("auto", *METHODS)))
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
    from surefoot.contact import solve as solve_problem
    from surefoot.contact.problem import residuals
    from surefoot.contact.problem.redundancy import redundancy

    found = solve_problem(problem, solver, tol, max_time=max_time)
    rows, proof, names = redundancy(problem), found.proof, ("direction", "reach", "work")
    own = ("solver", "iterations", "forces", "velocities")
    given = None if problem.reference is None else residuals(problem, problem.reference).velocity_error
    return {
        "file": path.name,
        "kind": "contact",
        "contacts": problem.contacts,
        "rank": rows.rank,
        "rows": rows.size,
        "status": found.status.value,
        "velocity_error": found.residuals.velocity_error,
        "rounding": found.residuals.rounding,
        "reference_velocity_error": given,
        "proof": None if proof is None else {name: getattr(proof, name) for name in names},
        "seconds": found.solve_time,
        "notes": list(problem.notes),
        **{name: getattr(found, name) for name in own},
    }


def _complementarity(path: Path, problem: LCP, solver: str, tol: float, max_time: float) -> dict[str, Any]:
    """Solve one LCP; return its record."""
    from surefoot.contact.solvers.lcp_solver import solve_lcp

    found = solve_lcp(problem, solver, tol, max_time=max_time)
    names = ("solver", "residual", "iterations", "message", "ray", "proof", "z", "w")
    return {
        "file": path.name,
        "kind": "lcp",
        "size": problem.size,
        "status": found.status.value,
        "seconds": found.solve_time,
        **{name: getattr(found, name) for name in names},
    }


def _print(console: Console, records: list[dict[str, Any]], tol: float) -> None:
    """Print a table of contact problems and one of LCPs, and what there is to say of single ones."""
    kinds = (
        ("contact", "Contact", ("n", "rank", "status", "velocity error"), _contact_cells, _contact_lines),
        ("lcp", "Linear complementarity", ("size", "solver", "status", "residual"), _lcp_cells, _lcp_lines),
    )
    for kind, title, columns, cells, lines in kinds:
        chosen = [r for r in records if r["kind"] == kind]
        if not chosen:
            continue
        header = ("file", *columns, "steps", "ms")
        rows = [(r["file"], *cells(r), str(r["iterations"]), f"{1e3 * r['seconds']:.2f}") for r in chosen]
        title = f"{title} problems, to be solved to {tol:g}"
        listed = table(header, rows, title, left=("file", "solver", "status"), whole=header[1:])
        listed.columns[0].overflow, listed.columns[0].min_width = "fold", 18
        console.print(listed)
        for r in chosen:
            for line in lines(r):
                console.print(f"{r['file']}: {line}")


def _contact_cells(r: dict[str, Any]) -> tuple[str, ...]:
    return str(r["contacts"]), f"{r['rank']}/{r['rows']}", r["status"], f"{r['velocity_error']:.1e}"


def _lcp_cells(r: dict[str, Any]) -> tuple[str, ...]:
    return str(r["size"]), r["solver"], r["status"], f"{r['residual']:.1e}"


def _contact_lines(r: dict[str, Any]) -> list[str]:
    """Return notes on a contact problem, and the proof that it has no solution."""
    if r["proof"] is None:
        return list(r["notes"])
    pushed = [k for k, d in enumerate(r["proof"]["direction"]) if any(d)]
    said = f"no forces with a sum of norms below {r['proof']['reach']:.2g} N solve it: contacts "
    return [*r["notes"], f"{said}{', '.join(map(str, pushed))} close on each other (proof in --json)"]


def _lcp_lines(r: dict[str, Any]) -> list[str]:
    """Return what there is to say of an LCP without a solution."""
    ways = (("proof", "proof v"), ("ray", "ray, which proves nothing,"))
    found = [
        f"{words} {' '.join(f'{x:.6g}' for x in r[name])}" for name, words in ways if r[name] is not None
    ]
    return [*([r["message"]] if r["message"] else []), *found[:1]]
