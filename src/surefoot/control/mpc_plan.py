"""What model-predictive control is given, hands on and returns: weights, program and plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.contact.solution import Status
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class MpcWeights:
    """What deviations cost, per step; the axes are the heading's (forward, left, up).

    The body's errors are in m, rad, m/s, rad/s; `force` is the weight on the squared deviation of every
    force [N²] from its share of the body's weight. Velocity weights must be positive.
    """

    position: tuple[float, float, float] = (10.0, 10.0, 100.0)
    orientation: tuple[float, float, float] = (50.0, 50.0, 30.0)
    linear_velocity: tuple[float, float, float] = (2.0, 2.0, 1.0)
    angular_velocity: tuple[float, float, float] = (0.3, 0.3, 0.3)
    force: float = 1e-5
    terminal: float = 1.0

    def matrix(self) -> FloatArray:
        """Return the (2, 6) weights on [position; orientation] and on their rates, in one unit of cost.

        Raises
        ------
        ProblemError
            For a negative or infinite weight, or a velocity weight that is not positive.
        """
        place = [finite_array(n, getattr(self, n), (3,)) for n in ("position", "orientation")]
        rate = [finite_array(n, getattr(self, n), (3,)) for n in ("linear_velocity", "angular_velocity")]
        out = np.vstack([np.concatenate(place), np.concatenate(rate)])
        if (out[0] < 0.0).any():
            raise ProblemError(f"MPC weights must be >= 0, got position and orientation {out[0]}")
        if (out[1] <= 0.0).any():
            raise ProblemError(f"MPC weights on velocities must be > 0, got {out[1]}")
        real_number("force weight", self.force, low=1e-12, high=1e12)
        real_number("terminal weight", self.terminal, low=1e-6, high=1e6)
        return out


@dataclass(frozen=True)
class MpcPlan:
    """The forces of a horizon and what they should lead to.

    Attributes
    ----------
    forces
        (N, n, 3) in the contact frames [N], always inside their cones and bounds; zero in swing.
    forces_world
        (N, n, 3) the same in world axes.
    position, linear_velocity, angular_velocity
        (N + 1, 3) predicted motion, world axes; row 0 is the state.
    orientation_error
        (N + 1, 3) predicted rotation vector from the reference to the body, world axes [rad].
    status
        SOLVED when `error` is within the tolerance, ALMOST within a thousand times of it,
        MAX_ITERATIONS above that, INVALID for a state or reference that is not finite (the forces then
        share the body's weight).
    error
        Bound on the distance of all forces together to the optimum [N].
    iterations
        Newton steps taken.
    """

    forces: FloatArray
    forces_world: FloatArray
    position: FloatArray
    linear_velocity: FloatArray
    angular_velocity: FloatArray
    orientation_error: FloatArray
    status: Status
    error: float
    iterations: int

    @property
    def first(self) -> FloatArray:
        """(n, 3) forces of the first step, contact frames [N]."""
        return np.asarray(self.forces[0])

    @property
    def solved(self) -> bool:
        """Whether the status is SOLVED."""
        return self.status is Status.SOLVED


@dataclass(frozen=True)
class HorizonProgram:
    """The condensed program of a horizon; see `surefoot.solvers.dual_newton.horizon` for the symbols.

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
        See `surefoot.control.mpc_model.build`.
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
