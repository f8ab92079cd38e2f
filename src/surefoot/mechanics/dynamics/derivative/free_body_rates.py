"""The derivatives of bodies without joints between them: a block for each, see `free_bodies`."""

from __future__ import annotations

import numpy as np
from scipy.linalg import block_diag

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import skew
from surefoot.mechanics.dynamics.derivative.flow import Dynamics, FlowDerivative, variation
from surefoot.mechanics.dynamics.free_bodies import FreeFlight
from surefoot.mechanics.dynamics.free_contacts import place_bodies


class FreeDynamics(Dynamics):
    """Derivatives of M (v̇ - Rᵀ g) + v x* M v of every body, at rest."""

    def __init__(self, motion: FreeFlight) -> None:
        self._motion = motion

    def rates(self, q: FloatArray, v: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
        """See `Dynamics.rates`: (nv, nv) by q, nothing by v."""
        blocks = np.zeros(self._motion.masses.shape)
        blocks[:, :, 3:] = -self._motion.masses[:, :, :3] @ skew(gravity(self._motion, q))
        return np.asarray(block_diag(*blocks)), np.zeros((v.size, v.size))

    def regressor(self, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """See `Dynamics.regressor`: (nv, 10 bodies)."""
        return np.asarray(block_diag(*regressors(self._motion, q, v, a)))


class FreeFlowDerivative(FlowDerivative):
    """Derivatives of a `FreeFlight`."""

    motion: FreeFlight

    def __init__(self, motion: FreeFlight) -> None:
        self.motion, self.size = motion, 6
        self._one, self._none = np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64)

    def _blocks(self, q: FloatArray, v: FloatArray, effort: FloatArray | None) -> FloatArray:
        masses, light = self.motion.masses, self.motion.light
        twists = v.reshape(-1, 6)
        h = skew(np.einsum("bij,bj->bi", masses, twists).reshape(-1, 2, 3))
        speeds = skew(twists.reshape(-1, 2, 3))
        # δ(v x* M v) = v x* M δv + δv x* M v
        cross, turned = np.zeros((2, len(masses), 6, 6))
        cross[:, :3, :3] = cross[:, 3:, 3:] = speeds[:, 1]
        cross[:, 3:, :3] = speeds[:, 0]
        turned[:, :3, 3:] = turned[:, 3:, :3] = -h[:, 0]
        turned[:, 3:, 3:] = -h[:, 1]
        by_v, by_q = -light @ (cross @ masses + turned), np.zeros(masses.shape)
        by_q[:, :3, 3:] = skew(gravity(self.motion, q))
        F = np.zeros((len(masses), 12, 12))
        for b in range(len(masses)):
            variation(twists[b], self._one, self._none, by_q[b], by_v[b], F[b])
        return F

    def _acceleration_rates(
        self, q: FloatArray, v: FloatArray, effort: FloatArray | None, more: FloatArray,
        inertia: FloatArray | None,
    ) -> FloatArray:  # fmt: skip
        taken, count = more.reshape(-1, 6, more.shape[1]), len(self.motion.masses)
        if inertia is not None:
            blocks = regressors(self.motion, q, v, self.motion.acceleration(q, v, effort))
            taken = taken - blocks @ inertia.reshape(count, 10, -1)
        return np.asarray(self.motion.light @ taken)


def regressors(motion: FreeFlight, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """Return the derivatives (n, 6, 10) of the bodies' forces by their inertial parameters."""
    import pinocchio

    proper = a.reshape(-1, 6).copy()
    proper[:, :3] -= gravity(motion, q)
    pairs = zip(v.reshape(-1, 6), proper, strict=True)
    return np.array([pinocchio.bodyRegressor(pinocchio.Motion(w), pinocchio.Motion(f)) for w, f in pairs])


def gravity(motion: FreeFlight, q: FloatArray) -> FloatArray:
    """Return gravity (n, 3) in body axes [m/s²]."""
    turns = np.zeros((len(motion.masses), 3, 3))
    place_bodies(q, turns, np.zeros((len(turns), 3)))
    return -motion.weight * turns[:, 2]
