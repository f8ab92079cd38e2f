"""Angular momentum in the horizon's cost: a weight on it, a bound on it, and their forces.

The horizon's body is rigid, so its momentum about the centre of mass is that of its angular velocity,
h = R I Rᵀ w, with R the reference's as in the rest of the model. What is added to the cost, summed over the
horizon and the heading's axes::

    1/2 weight (h - reference)²  +  1/2 beyond max(|h| - bound, 0)²

The solver takes one quadratic per axis, and no corners. The cost is convex and piecewise quadratic in the
angular velocities, so it is replaced by a quadratic with the same slope at the last plan's angular
velocities, and a curvature per axis that is at least its own there (the sums of the absolute entries of the
rows of its Hessian); then again from the new plan, until the slopes agree. Where the inertia is diagonal
along the heading's axes and no bound begins or ceases to bite, the first round is exact.

A plan of these rounds minimises a cost whose slope differs by some d from the true one. Both costs are
strongly convex with Hessian P in the accelerations and ρ in the forces, so that the two optima differ by

    ||f - f*|| <= 1/2 sqrt(dᵀ P⁻¹ d / ρ)

which is added to the error bound of the plan.

References
----------
.. [1] D. Orin, A. Goswami, S.-H. Lee, "Centroidal dynamics of a humanoid robot", Autonomous Robots 35, 2013.
.. [2] H. Walker, P. Ni, "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 2011.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.arrays import FloatArray, finite_array, real_number
from surefoot.control.mpc_model import predict
from surefoot.errors import ProblemError
from surefoot.solvers.dual_newton.horizon import newton

if TYPE_CHECKING:
    from surefoot.control.mpc_plan import HorizonProgram

PATIENCE = 16
"""Newton steps before the force weight is lowered in stages [-], see `solvers.dual_newton.horizon`."""
ROUNDS = 100
"""Most quadratics for one plan [-]: a bound on the time."""
MEMORY = 8
"""Rounds that a guess of where they lead looks back on [-]."""
FARTHER = 2.0
"""A move so many times longer than the one before makes the guess forget [-]: a bound has begun to bite."""
INNER = 0.25
"""Share of the tolerance for the error of the forces of one quadratic [-]; the rest is for what it lacks."""

Three = tuple[float, float, float]


@dataclass(frozen=True)
class MpcMomentum:
    """What angular momentum about the centre of mass costs in a plan; heading axes, as in `MpcWeights`.

    Attributes
    ----------
    weight
        (3,) on the squared distance from the reference, per step [1/(N m s)²].
    reference
        (3,) the momentum that costs nothing [N m s].
    bound
        (3,) size of the momentum up to which `beyond` costs nothing [N m s], inf for none. It is a soft
        bound: after a push the momentum may be larger whatever the forces.
    beyond
        Weight on the square of what is beyond the bound, per step [1/(N m s)²].

    Raises
    ------
    ProblemError
        For negative weights, and a bound that is not positive: a body without angular momentum could never
        turn, not even back to its reference.
    """

    weight: Three = (0.0, 0.0, 0.0)
    reference: Three = (0.0, 0.0, 0.0)
    bound: Three = (math.inf, math.inf, math.inf)
    beyond: float = 100.0

    def __post_init__(self) -> None:
        if (finite_array("momentum weight", self.weight, (3,)) < 0.0).any():
            raise ProblemError(f"momentum weight must be >= 0, got {self.weight}")
        finite_array("momentum reference", self.reference, (3,))
        try:
            bound = np.asarray(self.bound, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise ProblemError(f"momentum bound must be three numbers [N m s], got {self.bound!r}") from error
        if bound.shape != (3,) or not (bound > 0.0).all():
            raise ProblemError(
                f"momentum bound must be three numbers > 0 [N m s], got {self.bound!r}: a body that may have "
                "no angular momentum cannot turn back to its reference"
            )
        real_number("weight beyond the momentum bound", self.beyond, low=0.0, high=1e12)

    @property
    def idle(self) -> bool:
        """Whether nothing is asked."""
        bounded = self.beyond > 0.0 and bool(np.isfinite(self.bound).any())
        return not (bounded or any(self.weight))

    def cost(self, momentum: FloatArray) -> float:
        """Return the cost of (N, 3) momenta along the heading's axes [N m s]."""
        off = momentum - np.array(self.reference)
        excess = np.maximum(np.abs(momentum) - np.array(self.bound), 0.0)
        return 0.5 * float(np.sum(np.array(self.weight) * off**2) + self.beyond * np.sum(excess**2))


def minimise_with_momentum(
    term: MpcMomentum, inertia: FloatArray, rates: FloatArray, program: HorizonProgram, inverse: FloatArray,
    dt: float, tol: float, limit: int, point: FloatArray, force: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Fill the forces of a horizon whose cost has a term; return Newton steps and an error bound [N].

    Parameters
    ----------
    term
        See `MpcMomentum`.
    inertia, rates
        (N, 3, 3) and (N, 3) of the reference after every step, heading's axes [kg m²], [rad/s].
    program, inverse
        Without the momentum term; (6, N, N) inverses of its P.
    dt
        Length of a step [s].
    tol, limit
        Wanted error [N], and the most Newton steps.
    point, force
        (c, 3) guess of the points, filled with the answer's, and the forces; see
        `surefoot.solvers.dual_newton.horizon.newton` [N].
    """
    N = len(rates)
    sums = dt * np.tri(N)  # rates after every step of the accelerations in all steps
    free = predict(program.drift, np.zeros((N, 6)), dt)[1:, 1, 3:]
    error, total, here = math.inf, 0, np.zeros((N, 3))
    rounds: list[tuple[FloatArray, FloatArray]] = []
    for _ in range(ROUNDS):
        slope, curve = _slope(term, inertia, rates + here), _curvature(term, inertia, rates + here)
        gradient = slope + curve * (free - here)
        count, inner = newton(
            *_with_curve(program, inverse, sums, curve, gradient), program.step, program.M, program.bounds,
            program.centre, program.rho, INNER * tol, PATIENCE, limit - total, point, force,
        )  # fmt: skip
        total += count
        turning = np.zeros((N, 3))
        np.add.at(turning, program.step, np.einsum("cxa,cx->ca", program.M[:, :, 3:], force))
        there = free + sums @ turning
        # d, by which the slope of the quadratic differs from the true one: ||f - f*|| <= ½ sqrt(dᵀ P⁻¹ d / ρ)
        missed = sums.T @ (_slope(term, inertia, rates + there) - slope - curve * (there - here))
        away = float(np.einsum("kj,jkm,mj->", missed, inverse[3:], missed))
        error = inner + 0.5 * math.sqrt(max(away, 0.0) / program.rho)
        if error <= tol or not math.isfinite(error) or total >= limit:
            break
        here = _ahead(rounds, here, there)
    return total, error


def _ahead(rounds: list[tuple[FloatArray, FloatArray]], here: FloatArray, there: FloatArray) -> FloatArray:
    """Return where to go on after a round that led from (N, 3) rates to others [rad/s]; rounds grow by it.

    Guesses where the rounds lead from the last few of them: Anderson's acceleration [2]_.
    """
    move = there - here
    if rounds and np.linalg.norm(move) > FARTHER * np.linalg.norm(rounds[-1][1]):
        rounds.clear()
    rounds[:] = [*rounds[-MEMORY:], (there, move)]
    if len(rounds) == 1:
        return there
    ends, moves = (np.diff([r[i].ravel() for r in rounds], axis=0).T for i in (0, 1))
    share = np.linalg.lstsq(moves, move.ravel(), rcond=1e-10)[0]
    return np.asarray(there - (ends @ share).reshape(there.shape))


def _slope(term: MpcMomentum, inertia: FloatArray, w: FloatArray) -> FloatArray:
    """Return the derivative of the cost (N, 3) in the angular velocities; inertia is (N, 3, 3)."""
    h, bound = np.einsum("kij,kj->ki", inertia, w), np.array(term.bound)
    excess = h - np.clip(h, -bound, bound)
    pull = np.array(term.weight) * (h - np.array(term.reference)) + term.beyond * excess
    return np.asarray(np.einsum("kij,ki->kj", inertia, pull))


def _curvature(term: MpcMomentum, inertia: FloatArray, w: FloatArray) -> FloatArray:
    """Return a diagonal (N, 3) that is at least the cost's Hessian in the angular velocities."""
    h = np.einsum("kij,kj->ki", inertia, w)
    weight = np.array(term.weight) + term.beyond * (np.abs(h) > np.array(term.bound))
    hessian = np.einsum("kij,ki,kil->kjl", inertia, weight, inertia)
    return np.asarray(np.abs(hessian).sum(axis=2))


def _with_curve(
    program: HorizonProgram, inverse: FloatArray, sums: FloatArray, curve: FloatArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return inverses, Hessians and gradient with a cost on the rates added, see `newton`."""
    P, K, q = program.P.copy(), inverse.copy(), program.q.copy()
    for j in range(3):
        P[3 + j] += sums.T @ (curve[:, j, None] * sums)
        K[3 + j] = np.linalg.inv(P[3 + j])
        q[3 + j :: 6] += sums.T @ slope[:, j]
    return K, P, q
