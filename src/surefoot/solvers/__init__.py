"""Solvers for contact problems: one algorithm per file, joined by `solve`."""

from surefoot.solvers.contact_solver import ContactForces, ContactSolver
from surefoot.solvers.lcp import LcpSolution, lcp_solver_names, solve_lcp
from surefoot.solvers.minimum_norm import minimum_norm
from surefoot.solvers.solver import Answer, SolverSettings, register, solve, solver_names

__all__ = [
    "Answer",
    "ContactForces",
    "ContactSolver",
    "LcpSolution",
    "SolverSettings",
    "lcp_solver_names",
    "minimum_norm",
    "register",
    "solve",
    "solve_lcp",
    "solver_names",
]
