"""The derivative of motion between impulses, by the variational equation of its flow.

With δq in the tangent space at q and δv, and v̇ = a(q, v, ...) of `motion`::

    δq̇ = δv - [v, δq],      δv̇ = ∂a/∂q δq + ∂a/∂v δv + ∂a/∂p δp

where [ , ] is the bracket of the joints' velocities (that of twists for a free flyer). Over short spans its
flow is the exponential of Magnus' series: of second order at the middle where hardly anything turns, else of
fourth order at the two points of Gauss. ∂a are Pinocchio's (articulated-body derivatives).

This is the derivative of the motion itself; that of the integrator differs by as much as its tolerance.

Source: S. Blanes, F. Casas, J. A. Oteo, J. Ros, "The Magnus expansion and some of its applications", Physics
Reports 470, 2009; J. Carpentier, N. Mansard, "Analytical derivatives of rigid body dynamics algorithms",
RSS 2018.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.mechanics.dynamics.free_motion import FreeMotion

GAUSS = 0.5 - math.sqrt(3.0) / 6.0
"""First of the two points of Gauss in [0, 1]."""
SLOW, TURN = 1e-3, 0.05
"""Largest angle turned in a span for which its middle says enough, and in a piece of others [rad]."""
TERMS = 60
"""Most terms of an exponential."""
Inputs = tuple[FloatArray, FloatArray | None]
"""Rates of efforts (nv, m) [N, N m] and of inertial parameters (10 bodies, m)."""


class FlowDerivative:
    """Derivatives of one `FreeMotion`; keeps its work arrays.

    Raises
    ------
    ProblemError
        For joints whose velocities do not commute and that are neither free flyers nor ball joints, and for
        models whose joints are not in depth-first order: Pinocchio's derivatives are wrong for those.
    """

    def __init__(self, motion: FreeMotion) -> None:
        import pinocchio

        self.motion, self.data, self.size = motion, motion.model.createData(), motion.model.nv
        self._derive = pinocchio.computeABADerivatives
        ordered(motion.model)
        balls, free = list[int](), list[int]()
        for joint in list(motion.model.joints)[1:]:
            name = joint.shortname()
            if "FreeFlyer" in name:
                free.append(joint.idx_v)
            elif "Spherical" in name and joint.nq == 4:
                balls.append(joint.idx_v)
            elif joint.nv > 1 and joint.nq != joint.nv:
                raise ProblemError(f"no derivative of a motion with a {name}")
        self._balls, self._free = np.array(balls, dtype=np.int64), np.array(free, dtype=np.int64)

    def of(
        self, T: FloatArray, q: FloatArray, v: FloatArray, seconds: float, effort: FloatArray | None = None,
        efforts: FloatArray | None = None, inertia: FloatArray | None = None,
    ) -> FloatArray:  # fmt: skip
        """Return the rates (2nv, c) of where q and v lead in `seconds`, for rates T of q and v.

        Those of the effort are `efforts` (nv, c) [N, N m], of inertial parameters `inertia` (10 bodies, c).
        """
        given = [a for a in (efforts, inertia) if a is not None and a.any()]
        active = np.flatnonzero(np.vstack(given).any(axis=0)) if given else np.zeros(0, dtype=np.int64)
        none = np.zeros((v.size, active.size))
        own = none if efforts is None else efforts[:, active], None if inertia is None else inertia[:, active]
        inputs = own if active.size else None
        # of each block of bodies that no other moves: its rates, and ones for the inputs
        size, columns = self.size, T.shape[1]
        parts = T.reshape(2, -1, size, columns).swapaxes(0, 1).reshape(-1, 2 * size, columns)
        X = np.zeros((len(parts), 2 * size + active.size, columns))
        X[:, : 2 * size] = parts
        X[:, 2 * size + np.arange(active.size), active] = 1.0
        turned = seconds * float(np.abs(v).max(initial=0.0))
        if turned <= SLOW:
            X = _exponential_times(seconds * self._rate(q, v, 0.5 * seconds, effort, inputs), X)
        else:
            count = max(math.ceil(turned / TURN), 1)
            h = seconds / count
            for k in range(count):
                first, second = (
                    self._rate(q, v, (k + share) * h, effort, inputs) for share in (GAUSS, 1.0 - GAUSS)
                )
                # Magnus of fourth order: h/2 (F₁ + F₂) + √3/12 h² [F₂, F₁], at the two points of Gauss.
                swerve = second @ first - first @ second
                X = _exponential_times(0.5 * h * (first + second) + math.sqrt(3.0) / 12.0 * h * h * swerve, X)
        return np.asarray(X[:, : 2 * size].reshape(-1, 2, size, columns).swapaxes(0, 1).reshape(T.shape))

    def _rate(
        self, q: FloatArray, v: FloatArray, after: float, effort: FloatArray | None, inputs: Inputs | None
    ) -> FloatArray:
        """Return the matrix of the variational equation `after` seconds."""
        ahead = self.motion.advance(q, v, after, effort)
        assert ahead is not None  # the whole span was integrated before
        q, v, n = ahead.q, ahead.v, self.size
        blocks = self._blocks(q, v, effort)
        if inputs is None:
            return blocks
        F = np.zeros((len(blocks), *(2 * n + inputs[0].shape[1],) * 2))
        F[:, : 2 * n, : 2 * n], F[:, n : 2 * n, 2 * n :] = (
            blocks,
            self._acceleration_rates(q, v, effort, *inputs),
        )
        return F

    def _blocks(self, q: FloatArray, v: FloatArray, effort: FloatArray | None) -> FloatArray:
        """Return the matrices (blocks, 2n, 2n) of the variational equation."""
        given = np.zeros(v.size) if effort is None else effort
        self._derive(self.motion.model, self.data, q, v, given)
        F = np.zeros((1, 2 * v.size, 2 * v.size))
        variation(v, self._free, self._balls, self.data.ddq_dq, self.data.ddq_dv, F[0])
        return F

    def _acceleration_rates(
        self, q: FloatArray, v: FloatArray, effort: FloatArray | None, more: FloatArray,
        inertia: FloatArray | None,
    ) -> FloatArray:  # fmt: skip
        """Return the rates (blocks, n, m) of the acceleration by inputs, after `_blocks`."""
        import pinocchio

        data, upper = self.data, np.triu(self.data.Minv)
        if inertia is not None:
            a = np.array(data.ddq)
            # M δa = δτ - Y δθ at fixed motion, with Y the regressor of inverse dynamics. Pinocchio fills the
            # upper triangle of M⁻¹.
            more = more - pinocchio.computeJointTorqueRegressor(self.motion.model, data, q, v, a) @ inertia
        return np.asarray((upper + np.triu(upper, 1).T) @ more)[None]


class Dynamics:
    """Derivatives of the inverse dynamics of what a `FreeMotion` moves, under its gravity."""

    def __init__(self, motion: FreeMotion) -> None:
        self._model, self._data = motion.model, motion.model.createData()

    def rates(self, q: FloatArray, v: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives (nv, nv) of the forces by q and by v, at (nv,) v and acceleration a."""
        import pinocchio

        pinocchio.computeRNEADerivatives(self._model, self._data, q, v, a)
        return self._data.dtau_dq, self._data.dtau_dv

    def regressor(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return those by all inertial parameters: (nv, 10 bodies)."""
        import pinocchio

        return np.array(pinocchio.computeJointTorqueRegressor(self._model, self._data, q, v, a))


@kernel
def variation(
    v: FloatArray, free: IntArray, balls: IntArray, by_q: FloatArray, by_v: FloatArray, F: FloatArray
) -> None:
    """Write the matrix of the variational equation of (q, v) at (nv,) v into F, at least (2nv, 2nv).

    `free` and `balls` are the first velocities of free flyers and of ball joints, `by_q` and `by_v` (nv, nv)
    the derivatives of the acceleration.
    """
    n = v.size
    # q and v of joints with one axis: δq̇ = δv, and the derivatives of the acceleration.
    for i in range(n):
        F[i, n + i] = 1.0
        for j in range(n):
            F[n + i, j], F[n + i, n + j] = by_q[i, j], by_v[i, j]
    for k in range(free.size + balls.size):
        ball = k >= free.size
        at = balls[k - free.size] if ball else free[k]
        turn = at if ball else at + 3
        for i in range(3):  # -[v, δq]
            j, m = (i + 1) % 3, (i + 2) % 3
            F[at + j, at + m] = v[turn + i]
            F[at + m, at + j] = -v[turn + i]
            if not ball:
                F[turn + j, turn + m], F[turn + m, turn + j] = v[turn + i], -v[turn + i]
                F[at + j, turn + m], F[at + m, turn + j] = v[at + i], -v[at + i]


@kernel
def _exponential_times(matrices: FloatArray, X: FloatArray) -> FloatArray:
    """Return the exponentials of matrices (k, n, n) times X (k, n, c), by their series to rounding."""
    # The exponential's action on the columns, Σ Mᵏ X / k!: the exponential itself is never formed.
    out = X.copy()
    for b in range(X.shape[0]):
        matrix, term, largest = matrices[b], X[b].copy(), np.abs(X[b]).max()
        for k in range(1, TERMS):
            term = matrix @ term / k
            out[b] += term
            if not np.abs(term).max() > 1e-17 * largest:
                break
    return out


def ordered(model: Any) -> None:
    """Refuse a model whose joints are not in depth-first order: Pinocchio's derivatives are wrong for it."""
    for k, below in enumerate(model.subtrees):
        if k and len(below) != max(below) - min(below) + 1:
            raise ProblemError(
                f"no derivative: what joint {model.names[k]} carries must follow it in the model"
            )
