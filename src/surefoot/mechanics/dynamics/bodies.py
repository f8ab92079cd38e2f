"""The moving bodies of a step: masses, forces of gravity and motors, motion without contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.collision import Geometry
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.detection import TerrainDetection
from surefoot.mechanics.dynamics.free_motion import FreeMotion
from surefoot.mechanics.dynamics.pair_detection import PairDetection
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.payload import loaded_model
from surefoot.mechanics.terrain import Terrain


class Bodies:
    """A copy of a robot's model, with its payload.

    Parameters
    ----------
    robot
        The robot.
    terrain
        What its feet may touch.
    payload, payload_position
        Point mass fixed to the base [kg], and where: (3,) base axes [m].
    geometry, dt
        What else may touch than the feet on the ground (None: nothing), and the length of a step [s].

    Attributes
    ----------
    model, data
        Pinocchio's.
    contacts
        Where the feet are to the ground.
    flight, coasting
        Free motion under gravity, and under no forces.
    L
        (nv, nv) lower factor of the mass matrix, as of the last `weigh`.
    lever
        (3,) the base's own centre of mass in its frame [m], where pushes act.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain,
        payload: float,
        geometry: Geometry | None = None,
        dt: float = 1e-3,
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        import pinocchio

        self.model = loaded_model(robot.model, payload if robot.floating else 0.0, payload_position)
        self.contacts: TerrainDetection | PairDetection = (
            TerrainDetection(self.model, robot.contact_points, terrain)
            if geometry is None
            else PairDetection(self.model, robot, geometry, terrain, dt)
        )
        self.data = self.contacts.data
        weightless = self.model.copy()
        weightless.gravity.setZero()
        self.flight = FreeMotion(self.model, robot.floating)
        self.coasting = FreeMotion(weightless, robot.floating)
        self.L = np.zeros((self.model.nv, self.model.nv))
        self._floating, self.lever = robot.floating, robot.model.inertias[1].lever.copy()
        self._crba, self._gravity = pinocchio.crba, pinocchio.computeGeneralizedGravity
        self._bias = pinocchio.nonLinearEffects
        self._integrate, self._energy = pinocchio.integrate, pinocchio.computeMechanicalEnergy

    @property
    def light(self) -> FloatArray:
        """(nv, nv) inverse of the lower factor of the mass matrix, as of the last `weigh`."""
        return np.asarray(np.linalg.inv(self.L))

    @property
    def base_rotation(self) -> FloatArray:
        """(3, 3) rotation_world_base where contacts were looked for last."""
        return np.asarray(self.data.oMi[1].rotation)

    def weigh(self, q: FloatArray) -> None:
        """Bring the factor of the mass matrix up to (nq,) q [m, -, rad]."""
        arithmetic.factorise(self._crba(self.model, self.data, q), self.L)

    def gravity(self, q: FloatArray) -> FloatArray:
        """Return the generalised forces (nv,) [N, N m] that hold the robot at q against gravity."""
        return np.asarray(self._gravity(self.model, self.data, q))

    def bias(self, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the forces (nv,) [N, N m] that keep v as it is: gravity's, Coriolis and centrifugal."""
        return np.asarray(self._bias(self.model, self.data, q, v))

    def free_velocity(
        self, v: FloatArray, effort: FloatArray, push: FloatArray | None, against: FloatArray, dt: float
    ) -> FloatArray:
        """Return the velocity (nv,) [m/s, rad/s] after all forces but the ground's for `dt`, at `weigh`'s q.

        `effort` are the motors' generalised forces (nv,), `against` what takes off them: `gravity` or `bias`;
        `push` (3,) acts on the base's own centre of mass.
        """
        if push is not None:
            effort = self.pushed(effort, push, self.base_rotation)
        return self._velocity_after(effort - against, v, dt)

    def _velocity_after(self, force: FloatArray, v: FloatArray, dt: float) -> FloatArray:
        """Return the velocity after a time under all (nv,) forces but the ground's."""
        return arithmetic.free_velocity(self.L, force, v, dt)

    def pushed(self, effort: FloatArray, push: FloatArray, rotation: FloatArray) -> FloatArray:
        """Return the effort (nv,) with that of a push (3,) on the base [N], world axes.

        `rotation` (3, 3) is rotation_world_base.
        """
        if not self._floating:
            return effort
        effort, local = effort.copy(), rotation.T @ push
        effort[:3] += local
        effort[3:6] += np.cross(self.lever, local)
        return effort

    def moved(self, q: FloatArray, step: FloatArray) -> FloatArray:
        """Return the configuration (nq,) [m, -, rad] that lies a (nv,) step from q."""
        return np.array(self._integrate(self.model, q, step))

    def energy(self, q: FloatArray, v: FloatArray) -> float:
        """Return kinetic plus potential energy [J] at q (nq,) and v (nv,), zero potential at z = 0."""
        return float(self._energy(self.model, self.data, q, v))

    def fastest_joint(self, v: FloatArray) -> tuple[str, float]:
        """Return the name of the joint with the largest entry of (nv,) v, and that speed [rad/s or m/s]."""
        fastest = int(np.argmax(np.abs(v))) if self.model.nv else 0
        joint = next(
            k for k in range(1, self.model.njoints) if fastest < self.model.idx_vs[k] + self.model.nvs[k]
        )
        return self.model.names[joint], float(abs(v[fastest]))
