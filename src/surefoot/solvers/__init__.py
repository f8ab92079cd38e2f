"""Solvers for contact problems: one algorithm per file, joined by `solve`."""

from surefoot.solvers.solver import Settings, solve, solver_names

__all__ = ["Settings", "solve", "solver_names"]
