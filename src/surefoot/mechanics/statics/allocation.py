"""One interface over every way to share a wrench among the feet.

`ExactAllocation` is the fast exact one; `SolverAllocation` puts any solver of the family behind the same
call, so that controllers can be compared on pyramids or on other projects' solvers.

The exact one keeps away from the cones' edges in two ways. The least forces that give a wrench have the same
tangential force at every foot, so that a foot with little weight on it is asked for more than its friction;
forces parallel to the wanted one use the same share of every foot's friction, which on plane ground is the
least that is possible. So the tangential forces are drawn to those: the wanted force, shared as the normal
forces of the step before were. And the wrench is first sought within a share of the friction; only what
that cannot give takes the whole cones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import MATRIX, VECTOR, entry_point, kernel
from surefoot.contact import ContactProblem, Fit, FrictionCone, Status, find_solver, solve
from surefoot.mechanics.statics.force_distribution import ForceDistributor

SHARES = 0.9, 1.0
"""Shares of the friction: forces use the first as long as it gives the wanted wrench."""
MARGIN_COST = 5e-3
"""A wrench counts as given within the first share of friction if no more than so much of it is missing."""

LARGEST = 1e60
"""Grasp maps and wrenches with larger numbers are not given to other solvers."""


class Allocation(Protocol):
    """Shares a wrench among n contact points, within their cones and normal bounds."""

    status: Status

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return (n, 3) forces [N] in contact frames for a (6, 3n) grasp map and a (6,) wrench."""

    def reset(self) -> None:
        """Forget the forces of the step before."""


@kernel
def draw_to_parallel(
    grasp_map: FloatArray,
    wrench: FloatArray,
    weights: FloatArray,
    last: FloatArray,
    normal_max: FloatArray,
    out: FloatArray,
) -> float:
    """Write the tangential parts of forces parallel to the wanted one; return the wrench's squared size.

    Parameters
    ----------
    grasp_map, wrench, weights
        (6, 3n), (6,) and (6,); the first three rows of the map are the axes of the contact frames.
    last
        (n, 3) forces of the step before [N], whose normal parts say how the wanted force is shared; equally
        where none pushed.
    normal_max
        (n,) zero for contacts that are off [N].
    out
        (n, 3) [N]; its normal parts become zero.
    """
    total, count = 0.0, 0
    for k in range(last.shape[0]):
        if normal_max[k] > 0.0:
            total += last[k, 2]
            count += 1
    for k in range(last.shape[0]):
        # Of the wanted force, which the first three rows give in contact axes, each foot takes the share of
        # the weight that it had: all then use the same share of their friction.
        part = 0.0
        if normal_max[k] > 0.0:
            part = last[k, 2] / total if total > 0.0 else 1.0 / count
        for j in range(2):
            c = 3 * k + j
            axis = grasp_map[0, c] * wrench[0] + grasp_map[1, c] * wrench[1] + grasp_map[2, c] * wrench[2]
            out[k, j] = part * axis
        out[k, 2] = 0.0
    size = 0.0
    for i in range(6):
        size += weights[i] * wrench[i] * wrench[i]
    return size


@cache
def _draw() -> Callable[..., float]:
    """Return `draw_to_parallel` itself, for the only types that are passed here."""
    strided = MATRIX.copy(layout="A")
    return entry_point(draw_to_parallel, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, strided)


class ExactAllocation:
    """Exact friction cones through `ForceDistributor`.

    Parameters
    ----------
    mu
        (n,) friction coefficients.
    wrench_weights
        (6,) weights of the wrench's components.
    force_weight
        Weight of the square of the forces' distance from parallel ones.
    """

    def __init__(self, mu: FloatArray, wrench_weights: FloatArray, force_weight: float) -> None:
        self._distributors = [
            ForceDistributor(part * mu, 0.0, np.inf, wrench_weights, force_weight) for part in SHARES
        ]
        self._bounds: tuple[FloatArray, FloatArray] | None = None
        self._weights = np.ascontiguousarray(wrench_weights, dtype=np.float64)
        self._zero = np.zeros((len(mu), 3))
        self.reset()

    def reset(self) -> None:
        """Forget the forces of the step before."""
        self._last = self._zero
        self.status = Status.SOLVED
        for distributor in self._distributors:
            distributor.reset()

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return the forces; see `Allocation.share`."""
        if self._bounds is None or self._bounds[0] is not normal_min or self._bounds[1] is not normal_max:
            for distributor in self._distributors:
                distributor.set_bounds(normal_min, normal_max)
            self._bounds = (normal_min, normal_max)
        draw = _draw()
        for distributor in self._distributors:
            size = draw(grasp_map, wrench, self._weights, self._last, normal_max, distributor.reference)
            forces = distributor.solve(grasp_map, wrench)
            if distributor.wrench_error**2 <= MARGIN_COST**2 * size or distributor.status is Status.INVALID:
                break
        if distributor.status is Status.INVALID:  # hold the last command, whoever found it
            distributor.reset(self._last)
            forces = distributor.solve(grasp_map, wrench)
        self.status, self._last = distributor.status, forces
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
        Weight of the square of the forces.
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
        self._weights, self._force_weight = np.asarray(wrench_weights, dtype=np.float64), force_weight
        self._mu, self._solver, self._facets, self._fit = mu, solver, facets, fit
        self.reset()
        size = 3 * len(mu)
        find_solver(solver, self._problem(np.eye(size), np.zeros(size), np.zeros(len(mu)), np.ones(len(mu))))

    def reset(self) -> None:
        """Forget the forces of the step before."""
        self._last = np.zeros((len(self._mu), 3))
        self.status = Status.SOLVED

    def _problem(self, G: FloatArray, g: FloatArray, low: FloatArray, high: FloatArray) -> ContactProblem:
        return ContactProblem(G, g, self._mu, low, high, "convex", self._facets, self._fit)

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return the (n, 3) forces [N]; the last good ones, cut to the cones, where the solver failed.

        The grasp map is (6, 3n), the wrench (6,) [N, N m], the bounds on normal forces (n,) [N].
        """
        self.status, forces = Status.INVALID, self._last
        size = max(np.abs(grasp_map).max(initial=0.0), np.abs(wrench).max())
        if size <= LARGEST:  # finite, and small enough to square
            weighted = self._weights[:, None] * grasp_map
            G = grasp_map.T @ weighted + self._force_weight * np.eye(grasp_map.shape[1])
            try:
                problem = self._problem(0.5 * (G + G.T), -weighted.T @ wrench, normal_min, normal_max)
                solution = solve(problem, self._solver, tol=1e-9, warm_start=self._last)
            except ProblemError:  # too large for double precision
                pass
            else:
                self.status = solution.status
                forces = solution.forces if np.isfinite(solution.forces).all() else forces
        if self._facets is None or self._fit == "inner":
            forces = np.array(
                [FrictionCone(float(m)).project(f) for m, f in zip(self._mu, forces, strict=True)]
            )
        forces[normal_max <= 0.0] = 0.0
        self._last = forces
        return forces
