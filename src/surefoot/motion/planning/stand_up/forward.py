"""What a sampling planner rolls out in: any world, or exact rigid steps in which all links touch."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot, State, Step, StepOptions, Stepper, robot_geometry


class ForwardModel(Protocol):
    """Where torques lead; every world of `surefoot.worlds.running` is one.

    Attributes
    ----------
    robot
        Who moves.
    dt
        Length of a step [s].
    """

    robot: Robot
    dt: float

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q and (nv,) v (Pinocchio's order; zero for None), at time 0."""

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) and v (nv,) in Pinocchio's order."""

    def step(self, torques: FloatArray) -> None:
        """Advance by `dt` under (joints,) torques [N m]."""


class RigidModel:
    """Exact rigid steps of a robot on flat ground; all its links touch the ground and each other.

    Parameters
    ----------
    robot
        Who moves.
    mu
        Friction of the ground, and of links on each other.
    dt
        Length of a step [s].
    """

    def __init__(self, robot: Robot, mu: float = 0.6, dt: float = 2e-3) -> None:
        self.robot, self.mu, self.dt = robot, mu, dt
        self.stepper = Stepper(robot, None, StepOptions(dt=dt), geometry=robot_geometry(robot))
        self.reset(robot.nominal)

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q and (nv,) v."""
        self._state: State = self.stepper.start(q, v)
        self.worst_residual, self.unsolved = 0.0, 0

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) and v (nv,)."""
        return self._state.q, self._state.v

    def step(self, torques: FloatArray) -> None:
        """Advance by `dt` under (joints,) torques [N m]."""
        self.last = step = self.stepper.step(self._state, torques, None, self.mu)
        self._state = step.state
        self.worst_residual = max(self.worst_residual, step.worst_residual)
        self.unsolved += step.unsolved

    def row(self) -> dict[str, Any]:
        """Return what the last step did at the feet, and the sum of all else: a log's channels, one row."""
        step, p = self.last, len(self.robot.contact_points)
        return {
            "forces": step.forces[:p].copy(),
            "gaps": step.gaps[:p].copy(),
            "contact_velocities": step.velocities[:p].copy(),
            "contact_positions": step.positions[:p].copy(),
            "other_forces": self._others(step, p),
        }

    def _others(self, step: Step, p: int) -> FloatArray:
        """Return the generalised force (nv,) of contacts that are no foot's on the ground [N, N m]."""
        if step.impact is None or not step.impulses[p:].any():
            return np.zeros(self.robot.model.nv)
        J = self.stepper.contacts(State(step.impact.q, step.impact.after)).J[3 * p :]
        return np.asarray(J.T @ step.forces[p:].ravel())
