"""Outside solvers behind one conic program: one file each, and a table.

HPIPM is not among them: it takes the stages of a horizon, not one program; see `benchmarks/walk/hpipm.py`.
"""

from __future__ import annotations

import importlib.util

from surefoot.base.errors import SolverNotFound
from surefoot.contact.solvers.backends.backend import Backend as Backend
from surefoot.contact.solvers.backends.backend import Options as Options
from surefoot.contact.solvers.backends.clarabel import Clarabel
from surefoot.contact.solvers.backends.daqp import Daqp
from surefoot.contact.solvers.backends.ecos import Ecos
from surefoot.contact.solvers.backends.program import ConeProgram as ConeProgram
from surefoot.contact.solvers.backends.program import End as End
from surefoot.contact.solvers.backends.program import Outcome as Outcome
from surefoot.contact.solvers.backends.proxqp import ProxQp
from surefoot.contact.solvers.backends.qp import Highs, Osqp, Piqp, Quadprog
from surefoot.contact.solvers.backends.scs import Scs

BACKENDS: dict[str, type[Backend]] = {
    kind.name: kind for kind in (Clarabel, Ecos, Scs, Osqp, ProxQp, Piqp, Daqp, Quadprog, Highs)
}


def backend(name: str, options: Options | None = None) -> Backend:
    """Return an outside solver by its name, ready to be given programs.

    Raises
    ------
    SolverNotFound
        If there is none of that name.
    MissingExtra
        If its package is not installed.
    """
    if name not in BACKENDS:
        raise SolverNotFound(f"unknown backend {name!r}; valid names: {', '.join(BACKENDS)}")
    return BACKENDS[name](options)


def installed(name: str) -> bool:
    """Tell whether a backend's package can be imported."""
    packages = {"highspy" if name == "highs" else name, "qpsolvers"}
    if BACKENDS[name].package != "qpsolvers":
        packages = {BACKENDS[name].package}
    return all(importlib.util.find_spec(package) is not None for package in packages)


def solve_program(program: ConeProgram, name: str = "clarabel", tol: float | None = 1e-9) -> Outcome:
    """Solve one program by an outside solver, from nothing.

    Parameters
    ----------
    program
        Its cones must be among those that the solver takes.
    name
        One of `BACKENDS`.
    tol
        Of the solver's own stopping test; None for its default.

    Raises
    ------
    SolverNotFound, MissingExtra, ProblemError
        For an unknown name, a package that is not installed, cones that the solver does not take.
    """
    return backend(name, Options(tol=tol)).solve(program)
