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

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.spatial import skew
from surefoot.stepping.motion import FreeMotion

GAUSS = 0.5 - math.sqrt(3.0) / 6.0
"""First of the two points of Gauss in [0, 1]."""
SLOW, TURN = 1e-3, 0.02
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
        self._balls, self._free = [], []
        for joint in list(motion.model.joints)[1:]:
            name = joint.shortname()
            if "FreeFlyer" in name:
                self._free.append(joint.idx_v)
            elif "Spherical" in name and joint.nq == 4:
                self._balls.append(joint.idx_v)
            elif joint.nv > 1 and joint.nq != joint.nv:
                raise ProblemError(f"no derivative of a motion with a {name}")

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
        F[:n, n : 2 * n] = np.eye(n)
        for i in self._free:
            spin = skew(v[i + 3 : i + 6])
            F[i : i + 3, i : i + 3] = F[i + 3 : i + 6, i + 3 : i + 6] = -spin
            F[i : i + 3, i + 3 : i + 6] = -skew(v[i : i + 3])
        for i in self._balls:
            F[i : i + 3, i : i + 3] = -skew(v[i : i + 3])
        F[n : 2 * n, :n], F[n : 2 * n, n : 2 * n] = self.data.ddq_dq, self.data.ddq_dv
        if own is not None:
            F[n : 2 * n, 2 * n :] = own
        return F


def _exponential(matrix: FloatArray) -> FloatArray:
    """Return the exponential of a small matrix, by its series to rounding."""
    out, term = np.eye(len(matrix)) + matrix, matrix
    for k in range(2, TERMS):
        term = term @ matrix / k
        out += term
        if not np.abs(term).max(initial=0.0) > 1e-17:
            break
    return np.asarray(out)


def ordered(model: Any) -> None:
    """Refuse a model whose joints are not in depth-first order: Pinocchio's derivatives are wrong for it."""
    for k, below in enumerate(model.subtrees):
        if k and len(below) != max(below) - min(below) + 1:
            raise ProblemError(
                f"no derivative: what joint {model.names[k]} carries must follow it in the model"
            )
