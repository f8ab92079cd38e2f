"""Moving bodies without joints between them: inertias of their own, nothing that grows faster than they do.

In body axes the inertia M of a free body is constant, and its motion that of Newton and Euler::

    M v̇ = f - v x* M v + M (Rᵀ g, 0)
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.collision import Geometry
from surefoot.mechanics.dynamics.bodies import Bodies
from surefoot.mechanics.dynamics.free_contacts import FreeDetection
from surefoot.mechanics.dynamics.free_motion import FreeMotion
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.payload import loaded_model
from surefoot.mechanics.terrain import Terrain


class FreeBodies(Bodies):
    """Bodies of a scene without a robot; see `Bodies` for arguments and attributes.

    Attributes
    ----------
    L
        (bodies, 6, 6) lower factors of the bodies' inertias; constant.
    """

    contacts: FreeDetection
    flight: FreeFlight

    def __init__(
        self, robot: Robot, terrain: Terrain, payload: float, geometry: Geometry, dt: float,
        payload_position: ArrayLike,
    ) -> None:  # fmt: skip
        import pinocchio

        self.model = loaded_model(robot.model, payload if robot.floating else 0.0, payload_position)
        self.contacts = FreeDetection(self.model, robot, geometry, terrain, dt)
        inertias = list(self.model.inertias)[1:]
        self._masses = np.array([i.matrix() for i in inertias])
        self._own = np.array([(i.mass, *i.lever) for i in inertias])
        self.flight = FreeFlight(self.model, self._masses, GRAVITY)
        self.coasting = FreeFlight(self.model, self._masses, 0.0)
        self.L = np.linalg.cholesky(self._masses)
        self._floating, self.lever = True, robot.model.inertias[1].lever.copy()
        self._integrate = pinocchio.integrate

    @property
    def light(self) -> FloatArray:
        """See `Bodies.light`."""
        return np.asarray(block_diag(*np.linalg.inv(self.L)))

    @property
    def base_rotation(self) -> FloatArray:
        """See `Bodies.base_rotation`."""
        return np.asarray(self.contacts.turns[1])

    def weigh(self, q: FloatArray) -> None:
        """Do nothing: the inertias are constant in body axes, whatever (nq,) q [m, -]."""

    def gravity(self, q: FloatArray) -> FloatArray:
        """See `Bodies.gravity`: (nv,) [N, N m]."""
        return self.bias(q, np.zeros(self.model.nv))

    def bias(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """See `Bodies.bias`: (nv,) [N, N m]."""
        return -(self._masses @ self.flight.acceleration(q, v).reshape(-1, 6, 1)).ravel()

    def _velocity_after(self, force: FloatArray, v: FloatArray, dt: float) -> FloatArray:
        return np.asarray(v + dt * (self.flight.light @ force.reshape(-1, 6, 1)).ravel())

    def energy(self, q: FloatArray, v: FloatArray) -> float:
        """See `Bodies.energy` [J]."""
        self.contacts.at(q)
        heights = q[2::7] + np.einsum("bi,bi->b", self.contacts.turns[1:, 2], self._own[:, 1:])
        twists = v.reshape(-1, 6)
        kinetic = 0.5 * np.einsum("bi,bij,bj->", twists, self._masses, twists)
        return float(kinetic + GRAVITY * self._own[:, 0] @ heights)


class FreeFlight(FreeMotion):
    """Moves free bodies with inertias (n, 6, 6) under `gravity` [m/s²]; see `FreeMotion`.

    Attributes
    ----------
    masses, light
        (n, 6, 6) the inertias in body axes, and their inverses.
    weight
        Gravity [m/s²].
    """

    def __init__(self, model: Any, masses: FloatArray, gravity: float) -> None:
        super().__init__(model, len(masses), None)
        self.masses, self.light, self.weight = masses, np.asarray(np.linalg.inv(masses)), gravity

    def acceleration(self, q: FloatArray, v: FloatArray, effort: FloatArray | None = None) -> FloatArray:
        """See `FreeMotion.acceleration`: (nv,) [m/s², rad/s²]."""
        force = self._rest if effort is None else effort
        return accelerate(q, v, force, self.masses, self.light, self.weight)


@kernel
def accelerate(
    q: FloatArray, v: FloatArray, effort: FloatArray, masses: FloatArray, light: FloatArray, gravity: float
) -> FloatArray:
    """Return v̇ (6n,) of free bodies at (7n,) q with (6n,) v under efforts (6n,) [N, N m].

    `masses` and `light` (n, 6, 6) are the inertias in body axes and their inverses.
    """
    out, f, h = np.empty(v.size), np.empty(6), np.empty(6)
    for b in range(masses.shape[0]):
        at = 6 * b
        for i in range(6):
            # Momentum h = M v in body axes, whose rate there is f - v x* h: [ω x p; ω x L + v x p].
            h[i] = 0.0
            for j in range(6):
                h[i] += masses[b, i, j] * v[at + j]
        for k in range(3):  # f - v x* h
            i, j = (k + 1) % 3, (k + 2) % 3
            f[k] = effort[at + k] - (v[at + 3 + i] * h[j] - v[at + 3 + j] * h[i])
            f[3 + k] = effort[at + 3 + k] - (v[at + 3 + i] * h[3 + j] - v[at + 3 + j] * h[3 + i])
            f[3 + k] -= v[at + i] * h[j] - v[at + j] * h[i]
        for i in range(6):
            out[at + i] = 0.0
            for j in range(6):
                out[at + i] += light[b, i, j] * f[j]
        # Gravity accelerates every point of a body alike: it is added to v̇, and needs no inertia.
        x, y, z, w = q[7 * b + 3], q[7 * b + 4], q[7 * b + 5], q[7 * b + 6]
        # Rᵀ g: the world's vertical in body axes
        out[at] -= gravity * 2.0 * (x * z - y * w)
        out[at + 1] -= gravity * 2.0 * (y * z + x * w)
        out[at + 2] -= gravity * (1.0 - 2.0 * (x * x + y * y))
    return out


def bodies_of(
    robot: Robot, terrain: Terrain, payload: float, geometry: Geometry | None, dt: float,
    payload_position: ArrayLike,
) -> Bodies:  # fmt: skip
    """Return the moving bodies of a robot or a scene: `FreeBodies` where no joint ties any together.

    `payload_position` is (3,), base axes [m].
    """
    model = robot.model
    free = geometry is not None and not robot.feet and model.nv == 6 * (model.njoints - 1)
    if geometry is not None and free and all("FreeFlyer" in j.shortname() for j in list(model.joints)[1:]):
        return FreeBodies(robot, terrain, payload, geometry, dt, payload_position)
    return Bodies(robot, terrain, payload, geometry, dt, payload_position)
