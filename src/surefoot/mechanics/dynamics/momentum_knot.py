"""The knot of plans: a first-order step in which the momentum of the whole robot is what forces gave it.

A velocity v belongs to the way that led to q, so that the momentum that the robot arrives with is that at
q ⊖ dt v, where the way began. With A_G the centroidal momentum matrix, c the centre of mass, and the contact
forces' impulses λ at points p_i, the base obeys, instead of its rows of ``M (v⁺ - v) = dt (τ - b) + Jᵀ λ``::

    A_G(q) v⁺ = A_G(q ⊖ dt v) v + dt [m g; 0] + Σ [λ_i; (p_i - c) x λ_i]
    c(q⁺)     = c(q) + dt p⁺ / m,        p⁺ the linear part of A_G(q) v⁺

The joints' rows stay, and the way of the base's attitude and of the joints is q ⊕ dt v⁺. Momentum, linear and
angular, changes by gravity and the impulses to rounding, and the centre of mass goes where momentum takes it:
what a plan cannot do is push off from the error of its step. (In the plain step the bias Ȧ_G v of one knot
answers the change of A_G over the next, whose v is another after an impact: it loses dt Ȧ_G (v⁺ - v).) These
are the base's discrete Euler-Lagrange equations under the left rectangle rule [1]_, whose symmetries keep
momentum.

`MomentumKnot.velocity_at_end` gives the velocity of the same momentum at q⁺ itself, which logs show, and
`velocity_of_way` its inverse.

References
----------
.. [1] J. E. Marsden, M. West, "Discrete mechanics and variational integrators", Acta Numerica 10, 2001
   (symplectic Euler from the rectangle rule, section 2.6; discrete Noether theorem, section 1.3).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import GRAVITY, skew
from surefoot.mechanics.dynamics.knot import BaseMomentum, Knot, KnotStep, Rates
from surefoot.mechanics.dynamics.stepper import Stepper
from surefoot.mechanics.robot.centroidal import free_momentum_rows

ROUNDS = 30
"""Most rounds that look for the velocity of a way that ends with a momentum; each is dt times nearer."""


class MomentumKnot(Knot):
    """Takes first-order steps that keep the momentum of the whole robot; else as `Knot`.

    For robots that nothing carries: with a free flyer, or on slides along the world's axes. Others have no
    momentum of their own, and take the plain step.
    """

    def __init__(self, stepper: Stepper) -> None:
        import pinocchio

        super().__init__(stepper)
        self._pin: Any = pinocchio
        model = self._model
        self._rows = np.array(free_momentum_rows(model), dtype=np.int64)
        self._ways = np.flatnonzero(self._rows < 3)
        self._other, self._still = model.createData(), np.zeros(model.nv)

    def _momentum_at(self, q: FloatArray, v: FloatArray) -> BaseMomentum | None:
        n = len(self._rows)
        if not n:
            return None
        model, data = self._model, self._data
        A, X = np.array(data.Ag), _rigid_motion(data, n)
        arriving = _arriving(model, self._other, q, v, self._dt)
        gained = arriving - A @ v
        # the base's rows: gravity alone, and the change of momentum in place of its rate
        weight = self._pin.computeGeneralizedGravity(model, self._other, q)[:n]
        effort = data.nle[:n] - weight + X.T @ gained / self._dt
        return BaseMomentum(A, X, arriving, effort, np.array(data.com[0]), float(data.mass[0]))

    def _end(self, q: FloatArray, after: FloatArray, momentum: BaseMomentum | None) -> FloatArray:
        out = super()._end(q, after, momentum)
        if self._ways.size and momentum is not None:
            end = self._pin.centerOfMass(self._model, self._other, out)
            ahead = momentum.com + self._dt / momentum.mass * (momentum.map[:3] @ after)
            out[self._ways] += (ahead - end)[self._rows[self._ways]]
        return out

    def velocity_at_end(self, step: KnotStep) -> FloatArray:
        """Return a step's velocity (nv,), the base's such that the momentum at the new q is the step's."""
        out, other, momentum = step.v.copy(), self._other, step.momentum
        if momentum is not None and np.isfinite(out).all():
            # The momentum in directions of the base's own motion, 6 equations for a free flyer: joints keep
            # their rates.
            n = len(momentum.effort)
            A = np.array(self._pin.computeCentroidalMap(self._model, other, step.q))
            X = _rigid_motion(other, n)
            out[:n] = np.linalg.solve(X.T @ A[:, :n], X.T @ (momentum.map @ step.v - A[:, n:] @ out[n:]))
        return out

    def _rates(self, step: KnotStep, after: FloatArray) -> tuple[Rates, Rates]:
        dynamics, way = super()._rates(step, after)
        momentum = step.momentum
        if momentum is None:
            return dynamics, way
        change = self._pin.computeCentroidalDynamicsDerivatives
        q, other = step.start[0], self._other
        by_place = np.array(change(self._model, other, q, after, self._still)[0])
        self._write_base_rows(step, momentum, after, by_place, dynamics)
        return dynamics, self._way_rates(step, momentum, after, by_place, way)

    def _write_base_rows(
        self, step: KnotStep, momentum: BaseMomentum, after: FloatArray, by_place: FloatArray, dynamics: Rates
    ) -> None:
        """Write the base's rows of `dynamics`: those of momentum, divided by dt, in the base's axes."""
        model, other, dt, (q, v) = self._model, self._other, self._dt, step.start
        change = self._pin.computeCentroidalDynamicsDerivatives
        by_q, by_way = self._d_integrate(model, q, -dt * v)
        back = self._integrate(model, q, -dt * v)
        by_back, _, _, map_back = change(model, other, back, v, self._still)
        A, X, n = momentum.map, momentum.motion, len(momentum.effort)
        # world axes, about the centre of mass; what is left over is turned with the base's axes
        left = A @ after - momentum.arriving
        left[2] += dt * momentum.mass * GRAVITY
        turned = _turned_wrench(step.twists, self._first, A[:3] / momentum.mass, momentum.com, left, n)
        dynamics[0][:n] = (turned + X.T @ (by_place - by_back @ by_q)) / dt
        dynamics[1][:n] = X.T @ (A - map_back + dt * by_back @ by_way) / dt

    def _way_rates(
        self, step: KnotStep, momentum: BaseMomentum, after: FloatArray, by_place: FloatArray, way: Rates
    ) -> Rates:
        """Return the derivatives of the way by q and by itself: its centre of mass goes with momentum."""
        by_q, by_way = way
        if self._ways.size:
            model, other, dt, ways = self._model, self._other, self._dt, self._ways
            end = self._integrate(model, step.start[0], dt * after)
            B = np.array(self._pin.computeCentroidalMap(model, other, end))[:3]
            A = momentum.map[:3]
            rates = A + dt * by_place[:3] - B @ by_q, A - B @ by_way
            axes = np.array(other.oMi[1].rotation).T if model.nq != model.nv else np.eye(3)[self._rows[ways]]
            by_q, by_way = by_q.copy(), by_way.copy()
            for out, rate in zip((by_q, by_way), rates, strict=True):
                out[ways] += axes @ rate / momentum.mass
        return by_q, by_way


def velocity_of_way(model: Any, q: FloatArray, v: FloatArray, dt: float) -> FloatArray:
    """Return the velocity (nv,) of a way of dt [s] to q (nq,) on which the momentum is that of (nv,) v at q.

    What `MomentumKnot` takes for a start whose velocity is that of an instant; its inverse is
    `MomentumKnot.velocity_at_end`.
    """
    import pinocchio

    n, out = len(free_momentum_rows(model)), v.copy()
    if not n or not v.any():
        return out
    data = model.createData()
    A = np.array(pinocchio.computeCentroidalMap(model, data, q))
    X = _rigid_motion(data, n)
    wanted, square = A @ v, X.T @ A[:, :n]
    for _ in range(ROUNDS):
        step = np.linalg.solve(square, X.T @ (wanted - _arriving(model, data, q, out, dt)))
        out[:n] += step
        if not np.abs(step).max() > 1e-15 * np.abs(out).max():
            break
    return out


def _arriving(model: Any, data: Any, q: FloatArray, v: FloatArray, dt: float) -> FloatArray:
    """Return the momentum (6,) at the start of a way of dt that ended at q with v."""
    import pinocchio

    back = pinocchio.integrate(model, q, -dt * v)
    return np.array(pinocchio.computeCentroidalMomentum(model, data, back, v).vector)


def _rigid_motion(data: Any, n: int) -> FloatArray:
    """Return the velocity of the centre of mass and the rate of turning (6, n) by the base's n velocities."""
    return np.vstack([np.array(data.Ag[:3, :n]) / data.mass[0], np.array(data.J[3:, :n])])


def _turned_wrench(
    twists: FloatArray, first: IntArray, J: FloatArray, com: FloatArray, wrench: FloatArray, n: int
) -> FloatArray:
    """Return the derivative (n, nv) by q of the base's rows of a wrench (f, m) about the centre of mass c.

    Row j is f·(t_j + a_j x c) + m·a_j of the twist (t_j, a_j) at the world's origin; twists of the base's
    joints move with those before them, by the cross product of twists, and c by J (3, nv).
    """
    F = skew(wrench[:3])
    G = skew(wrench[3:] - F @ com)
    t, a = twists[:n, :3], twists[:n, 3:]
    turned = a @ F.T
    out = turned @ J
    moves = first[:n] <= first[:n, None]
    out[:, :n] += moves * (t @ turned.T + a @ (t @ F.T + a @ G.T).T)
    return np.asarray(out)
