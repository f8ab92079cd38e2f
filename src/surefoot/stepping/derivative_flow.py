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
from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.errors import ProblemError
from surefoot.kernels import kernel
from surefoot.stepping.motion import FreeMotion

GAUSS = 0.5 - math.sqrt(3.0) / 6.0
"""First of the two points of Gauss in [0, 1]."""
SLOW, TURN = 1e-3, 0.05
"""Largest angle turned in a span for which its middle says enough, and in a piece of others [rad]."""
TERMS = 60
"""Most terms of an exponential."""
Inputs = Callable[[Any, FloatArray, FloatArray, FloatArray], FloatArray]
"""∂a/∂p (nv, m) from Pinocchio's data after the derivatives of a, q, v and a."""


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

        self.motion, self.data = motion, motion.model.createData()
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
        self,
        q: FloatArray,
        v: FloatArray,
        seconds: float,
        effort: FloatArray | None = None,
        inputs: Inputs | None = None,
    ) -> FloatArray:
        """Return the derivative (2nv, 2nv + m) of where q and v lead in `seconds`, by q, v and the inputs."""
        nv = v.size
        turned = seconds * float(np.abs(v).max(initial=0.0))
        if turned <= SLOW:
            flow = _exponential(seconds * self._rate(q, v, 0.5 * seconds, effort, inputs))
            return flow[: 2 * nv]
        count = max(math.ceil(turned / TURN), 1)
        h, total = seconds / count, None
        for k in range(count):
            first, second = (
                self._rate(q, v, (k + share) * h, effort, inputs) for share in (GAUSS, 1.0 - GAUSS)
            )
            swerve = second @ first - first @ second
            flow = _exponential(0.5 * h * (first + second) + math.sqrt(3.0) / 12.0 * h * h * swerve)
            total = flow if total is None else flow @ total
        assert total is not None
        return total[: 2 * nv]

    def _rate(
        self, q: FloatArray, v: FloatArray, after: float, effort: FloatArray | None, inputs: Inputs | None
    ) -> FloatArray:
        """Return the matrix of the variational equation `after` seconds."""
        ahead = self.motion.advance(q, v, after, effort)
        assert ahead is not None  # the whole span was integrated before
        q, v, n = ahead.q, ahead.v, v.size
        given = np.zeros(n) if effort is None else effort
        self._derive(self.motion.model, self.data, q, v, given)
        own = None if inputs is None else inputs(self.data, q, v, np.array(self.data.ddq))
        F = np.zeros((2 * n + (0 if own is None else own.shape[1]),) * 2)
        variation(v, self._free, self._balls, self.data.ddq_dq, self.data.ddq_dv, F)
        if own is not None:
            F[n : 2 * n, 2 * n :] = own
        return F


@kernel
def variation(
    v: FloatArray, free: IntArray, balls: IntArray, by_q: FloatArray, by_v: FloatArray, F: FloatArray
) -> None:
    """Write the matrix of the variational equation of (q, v) at (nv,) v into F, at least (2nv, 2nv).

    `free` and `balls` are the first velocities of free flyers and of ball joints, `by_q` and `by_v` (nv, nv)
    the derivatives of the acceleration.
    """
    n = v.size
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
def _exponential(matrix: FloatArray) -> FloatArray:
    """Return the exponential of a small matrix, by its series to rounding."""
    term = matrix.copy()
    out = np.eye(matrix.shape[0]) + matrix
    for k in range(2, TERMS):
        term = term @ matrix / k
        out += term
        if not np.abs(term).max() > 1e-17:
            break
    return out


def ordered(model: Any) -> None:
    """Refuse a model whose joints are not in depth-first order: Pinocchio's derivatives are wrong for it."""
    for k, below in enumerate(model.subtrees):
        if k and len(below) != max(below) - min(below) + 1:
            raise ProblemError(
                f"no derivative: what joint {model.names[k]} carries must follow it in the model"
            )
