"""Solvers for contact problems: one algorithm per file, joined by `solver.solve`."""
