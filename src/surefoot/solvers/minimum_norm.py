"""Among all forces that give the same motion, those of least norm.

A solved problem fixes the velocities. Forces that keep them, and obey the laws with them, are a convex set: a
contact that separates carries none, one that slides pushes along its cone's edge against the velocity, one
that sticks anywhere in its cone. ADMM between the affine set G λ = G λ₀ and the cones finds the least one.

Source: S. Boyd et al., "Distributed optimization and statistical learning via ADMM", 2011, section 5.
Limits: linear convergence; which contacts slide or separate is read from the velocities with a tolerance.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.solution import ContactSolution
from surefoot.errors import ProblemError
from surefoot.solvers.pyramid import project_any
from surefoot.solvers.solver import Answer, certify

MAX_ITERATIONS = 5000
MOVING = 1e-6
"""A contact moves if its speed exceeds this share of the largest free or final speed."""


def minimum_norm(solution: ContactSolution, tol: float = 1e-8) -> ContactSolution:
    """Return the solution whose forces have the least Euclidean norm, with the same velocities.

    Its status and residuals are its own; where the polish could not keep them below `tol` [-], the solution
    given is returned unchanged.

    Raises
    ------
    ProblemError
        If the solution is not solved, or its problem is polyhedral (sliding forces are then not on one ray).
    """
    problem = solution.problem
    if not solution.solved:
        raise ProblemError(
            f"only a solved problem has a least-norm share, got status {solution.status.value!r}"
        )
    if problem.general:
        raise ProblemError("the least-norm share is for contacts of three rows under a named law")
    if problem.facets is not None:
        raise ProblemError("the least-norm share is for exact cones (facets=None)")
    columns, kinds = _free_columns(solution)
    values, vectors = np.linalg.eigh(problem.G)
    keep = values > 1e-10 * max(float(values[-1]), 1e-300)
    A = vectors[:, keep].T @ columns
    b = vectors[:, keep].T @ solution.forces.ravel()
    z = np.linalg.lstsq(columns, solution.forces.ravel(), rcond=None)[0]
    U, s, Vt = np.linalg.svd(A, full_matrices=False)
    good = s > 1e-9 * (s[0] if s.size else 1.0)
    V, particular = Vt[good].T, Vt[good].T @ ((U[:, good].T @ b) / s[good])
    y = np.zeros_like(z)
    for _ in range(MAX_ITERATIONS):
        target = 0.5 * (z - y)  # of 1/2 |x|² + 1/2 |x - z + y|²
        x = target - V @ (V.T @ target) + particular
        new = _project(problem.mu, problem.normal_min, problem.normal_max, kinds, x + y)
        y += x - new
        done = np.abs(x - new).max(initial=0.0) + np.abs(new - z).max(initial=0.0)
        z = new
        if done <= 1e-3 * tol * max(float(np.abs(z).max(initial=0.0)), 1e-300):
            break
    better = certify(
        problem,
        Answer((columns @ z).reshape(-1, 3), solution.iterations),
        solution.solver,
        tol,
        solution.solve_time,
    )
    return better if better.solved else solution


Kinds = list[tuple[int, int, int]]


def _free_columns(solution: ContactSolution) -> tuple[FloatArray, Kinds]:
    """Return the free directions of force, and (contact, first column, how many) for each contact."""
    problem, u = solution.problem, solution.velocities
    speed = MOVING * max(float(np.abs(u).max(initial=0.0)), float(np.abs(problem.g).max(initial=0.0)), 1e-300)
    columns: list[FloatArray] = []
    kinds: Kinds = []
    for k in range(problem.contacts):
        slip = math.hypot(u[k, 0], u[k, 1])
        normal = u[k, 2] - (1.0 - problem.law.shift) * problem.mu[k] * slip
        held = problem.normal_min[k] == -np.inf
        if not held and normal > speed and problem.normal_min[k] == 0.0:
            continue
        block = np.zeros((problem.contacts * 3, 3))
        block[3 * k : 3 * k + 3] = np.eye(3)
        if not held and (slip > speed or problem.mu[k] == 0.0):
            edge = np.array([0.0, 0.0, 1.0])
            if slip > speed:
                edge[:2] = -problem.mu[k] * u[k, :2] / slip
            block = (block @ edge)[:, None]
        kinds.append((k, sum(c.shape[1] for c in columns), block.shape[1]))
        columns.append(block)
    return (np.hstack(columns) if columns else np.zeros((3 * problem.contacts, 0))), kinds


def _project(mu: FloatArray, low: FloatArray, high: FloatArray, kinds: Kinds, x: FloatArray) -> FloatArray:
    """Return the nearest free components that are admissible."""
    out = x.copy()
    for k, at, size in kinds:
        if size == 1:
            out[at] = min(max(x[at], low[k]), high[k])
        else:
            out[at : at + 3] = project_any(x[at], x[at + 1], x[at + 2], mu[k], low[k], high[k], 0, True)
    return out
