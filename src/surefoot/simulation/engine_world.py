"""What worlds do alike whose engine builds the robot anew from plain data, see `scene_of`: Drake, Bullet."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array, real_number
from surefoot.errors import SimulationError
from surefoot.robot import Robot
from surefoot.simulation.engine_scene import scene_of
from surefoot.simulation.world import ContactReading, ground_of
from surefoot.stepping import Stepper
from surefoot.terrain import Terrain

HIGHEST = 1e9
"""Largest friction, and largest payload [kg]."""
LARGEST = 1e10
"""Speed from which a motion counts as lost [rad/s, m/s]."""


class EngineWorld(ABC):
    """A robot on a terrain; its state is held here, and our own stepper says where its contact points are.

    Parameters
    ----------
    robot, terrain, dt, payload, payload_position
        As the worlds that are made of it take them.
    """

    def __init__(
        self, robot: Robot, terrain: Terrain | None, dt: float, payload: float, payload_position: ArrayLike
    ) -> None:
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.payload = real_number("payload", payload, low=0.0, high=HIGHEST)
        self.payload_position = finite_array("payload_position", payload_position, (3,))
        self._stepper = Stepper(robot, ground_of(terrain), payload=self.payload)
        self.terrain, self.contact_foot = self._stepper.terrain, robot.contact_points.foot
        self._scene = scene_of(robot, self.terrain, self.payload, self.payload_position)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.dt

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q [m, -, rad], (nv,) v [m/s, rad/s] in Pinocchio's order, at time 0."""
        state = self._stepper.start(q, v)
        self._q, self._v, self._steps = state.q, state.v, 0
        self._seen = self._stepper.contacts(state)
        self._rates = self._seen.velocities(state.v)
        self._forces = np.zeros((len(self.contact_foot), 3))
        self._place()

    @abstractmethod
    def _place(self) -> None:
        """Put the engine's robot into the state that is held here."""

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""
        return self._q.copy(), self._v.copy()

    def _lost(self) -> SimulationError:
        """Go back to the state before the last step and return the error that says what was lost."""
        steps = self._steps
        self.reset(self._q, self._v)
        self._steps = steps
        return SimulationError("motion", self.time, self.dt, *self._stepper.bodies.fastest_joint(self._v))

    def contacts(self) -> ContactReading:
        """Return what the ground did during the last step."""
        seen = self._seen
        return ContactReading(
            self._forces.copy(), seen.gaps.copy(), self._rates.copy(), seen.positions.copy()
        )
