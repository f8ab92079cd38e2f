"""One interface over every way to share a wrench among the feet.

`ForceDistributor` is the fast exact one; `SolverAllocation` puts any solver of the family behind the
same call, so that controllers can be compared on pyramids or on other projects' solvers.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.cones import FrictionCone
from surefoot.contact import ContactProblem, Status
from surefoot.contact.problem import Fit
from surefoot.control.force_distribution import ForceDistributor
from surefoot.errors import ProblemError
from surefoot.solvers import solve
from surefoot.solvers.solver import find_solver


class Allocation(Protocol):
    """Shares a wrench among n contact points, within their cones and normal bounds."""

    status: Status

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return (n, 3) forces [N] in contact frames for a (6, 3n) grasp map and a (6,) wrench."""


class ExactAllocation:
    """Exact friction cones through `ForceDistributor`."""

    def __init__(self, mu: FloatArray, wrench_weights: FloatArray, force_weight: float) -> None:
        self._distributor = ForceDistributor(mu, 0.0, np.inf, wrench_weights, force_weight)
        self._bounds: tuple[FloatArray, FloatArray] | None = None
        self.status = Status.SOLVED

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return the forces; see `Allocation.share`."""
        if self._bounds is None or self._bounds[0] is not normal_min or self._bounds[1] is not normal_max:
            self._distributor.set_bounds(normal_min, normal_max)
            self._bounds = (normal_min, normal_max)
        forces = self._distributor.solve(grasp_map, wrench)
        self.status = self._distributor.status
        return forces


class SolverAllocation:
    """Any solver of the convex law, on exact cones or on pyramids.

    Parameters
    ----------
    mu
        (n,) friction coefficients.
    wrench_weights
        (6,) weights of the wrench's components.
    force_weight
        Weight of the forces' square.
    solver
        A name from `surefoot.solver_names`.
    facets, fit
        Sides and kind of the pyramids; None for exact cones.
    """

    def __init__(
        self,
        mu: FloatArray,
        wrench_weights: FloatArray,
        force_weight: float,
        solver: str = "auto",
        facets: int | None = None,
        fit: Fit = "inner",
    ) -> None:
        self._mu, self._weights, self._force_weight = mu, wrench_weights, force_weight
        self._solver, self._facets, self._fit = solver, facets, fit
        self._cones = [FrictionCone(float(m)) for m in mu]
        self._last = np.zeros((len(mu), 3))
        self.status = Status.SOLVED
        size = 3 * len(mu)
        find_solver(solver, self._problem(np.eye(size), np.zeros(size), np.zeros(len(mu)), np.ones(len(mu))))

    def _problem(self, G: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray) -> ContactProblem:
        return ContactProblem(G, g, self._mu, low, high, "convex", self._facets, self._fit)

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return the forces; the last good ones, cut to the cones, where the solver failed."""
        weighted = self._weights[:, None] * grasp_map
        G = grasp_map.T @ weighted + self._force_weight * np.eye(grasp_map.shape[1])
        try:
            problem = self._problem(0.5 * (G + G.T), -weighted.T @ wrench, normal_min, normal_max)
            solution = solve(problem, self._solver, tol=1e-9, warm_start=self._last)
        except ProblemError:  # not finite: hold the last command
            self.status, forces = Status.INVALID, self._last
        else:
            self.status = solution.status
            usable = bool(np.isfinite(solution.forces).all())
            forces = solution.forces if usable else self._last
        if self._facets is None or self._fit == "inner":
            forces = np.array([c.project(f) for c, f in zip(self._cones, forces, strict=True)])
        forces[normal_max <= 0.0] = 0.0
        self._last = forces
        return forces
