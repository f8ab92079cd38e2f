"""The program of a plan as matrices: what other solvers are given, and optima are judged by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.motion.control import mpc_model
from surefoot.motion.control.mpc import BodyReference, BodyState, ConvexMpc


def hessians(weights: FloatArray, terminal: float, steps: int, dt: float) -> FloatArray:
    """Return the (6, N, N) Hessians of the tracking cost in the accelerations of every axis.

    Parameters
    ----------
    weights
        (2, 6) on the errors of place and of rate.
    terminal
        Factor on the weights of the last step.
    steps, dt
        Length of the horizon, and of a step [s].
    """
    since = np.arange(1, steps + 1)[:, None] - np.arange(steps)  # at the end of row k, of an acceleration a
    rate = np.where(since > 0, dt, 0.0)
    place = rate * dt * (since - 0.5)
    last = np.where(np.arange(steps) == steps - 1, terminal, 1.0)[:, None]
    square = np.stack([place.T @ (last * place), rate.T @ (last * rate)])
    return np.asarray(np.einsum("rj,rab->jab", weights, square))


@dataclass(frozen=True)
class HorizonProgram:
    """The condensed program of a horizon; see `surefoot.contact.solvers.dual_newton.horizon` for the symbols.

    Attributes
    ----------
    step, foot
        (c,) of every contact.
    M
        (c, 3, 6); accelerations of a unit force along each axis of the contact's frame.
    bounds
        (c, 3) friction, least and largest normal force.
    centre
        (c, 3) wanted forces [N].
    P, q
        (6, N, N), (N, 6) tracking cost in the accelerations.
    rho
        Weight of the forces.
    drift, heading
        See `surefoot.motion.control.mpc_model.build`.
    """

    step: IntArray
    foot: IntArray
    M: FloatArray
    bounds: FloatArray
    centre: FloatArray
    P: FloatArray
    q: FloatArray
    rho: float
    drift: FloatArray
    heading: FloatArray

    def condensed(self) -> tuple[FloatArray, FloatArray]:
        """Return H (3c, 3c) and g (3c,) so that the cost is 1/2 fᵀ H f + gᵀ f + const in all forces [N]."""
        c, N = self.step.size, self.P.shape[1]
        full = np.zeros((6, N, 3 * c))  # accelerations, axis by axis
        for i in range(c):
            full[:, self.step[i], 3 * i : 3 * i + 3] = self.M[i].T
        H = np.einsum("jka,jkm,jmb->ab", full, self.P, full, optimize=True)
        H[np.diag_indices(3 * c)] += self.rho
        g = np.einsum("jka,kj->a", full, self.q) - self.rho * self.centre.ravel()
        return 0.5 * (H + H.T), g


def horizon_program(
    mpc: ConvexMpc,
    state: BodyState,
    reference: BodyReference,
    foot_positions: ArrayLike,
    contacts: ArrayLike,
    frames: ArrayLike | None = None,
) -> HorizonProgram:
    """Return the program of a plan; parameters and errors as for `ConvexMpc.solve`."""
    given, body = mpc.given(state, reference, foot_positions, contacts, frames, None), mpc.body()
    sway = mpc_model.expected_sway(given.motion, given.reference, mpc.dt)
    verdict, step, foot, M, limits, centre, q, drift, heading = mpc_model.build(given, body, sway)
    if verdict != mpc_model.GOOD:
        raise ProblemError("state, reference, foot positions and frames must be finite")
    P = hessians(body.weights, body.terminal, mpc.horizon, mpc.dt)
    return HorizonProgram(step, foot, M, limits, centre, P, q, body.rho, drift, heading)
