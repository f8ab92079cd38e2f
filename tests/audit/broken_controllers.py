"""Controllers and worlds that are broken on purpose: the chapter's seven symptoms, as they come about.

`BrokenStand` is a controller of its own, with Pinocchio's Jacobians alone: a spring on the base gives a wrench,
least squares share it out, J^T f gives the torques. Each fault is one that people make there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.arrays import FloatArray
from surefoot.contact import Status
from surefoot.control.controller import Command, Controller, RobotState
from surefoot.log import Log
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain

FAULTS = ("no forces", "infeasible", "wrong frame", "reversed", "coarse facets", "pull", "sinking", "chatter")


@dataclass
class BrokenStand(Controller):
    """Stands and sways; `fault` of `FAULTS` or "" and its `size` from 0 to 1, `phase` an angle [rad]."""

    robot: Robot
    fault: str = ""
    size: float = 0.5
    phase: float = 0.0
    sway: float = 0.02

    def __post_init__(self) -> None:
        self.channels = ()
        mass = self.robot.mass
        self.facts = {
            "kind": "own", "normal_min": 0.0, "normal_max": 2.0 * mass * GRAVITY, "mu_controller": 0.6,
        }  # fmt: skip
        self.data = self.robot.model.createData()

    def step(self, state: RobotState) -> Command:
        """Return torques for a swaying base."""
        import pinocchio as pin

        robot, model, data = self.robot, self.robot.model, self.data
        q, v, n = np.asarray(state.q), np.asarray(state.v), len(self.robot.feet)
        pin.computeJointJacobians(model, data, q)
        pin.centerOfMass(model, data, q, v)
        pin.updateFramePlacements(model, data)
        J = [pin.getFrameJacobian(model, data, f, pin.LOCAL_WORLD_ALIGNED)[:3] for f in robot.contact_points.frames]
        feet = np.array([data.oMf[f].translation for f in robot.contact_points.frames])
        wrench = self._wrench(q, v, np.array(data.com[0]), np.array(data.vcom[0]), state.time)
        grasp = np.hstack([np.vstack([np.eye(3), _cross(p - data.com[0])]) for p in feet])
        forces = np.linalg.lstsq(grasp, wrench, rcond=None)[0].reshape(n, 3)
        forces, active, attained = self._spoil(forces)
        applied = self._misapplied(forces)
        effort = pin.computeGeneralizedGravity(model, data, q)[6:] * 1.0
        torques = np.clip(
            effort - sum((Jk[:, 6:].T @ f for Jk, f in zip(J, applied, strict=True)), np.zeros(robot.joints)),
            -robot.effort_limits, robot.effort_limits,
        )  # fmt: skip
        if self.fault == "chatter" and int(round(state.time * 1000)) % 2:
            torques = (1.0 - 1.6 * self.size) * torques
        return Command(torques, forces, active, attained, Status.SOLVED if attained else Status.INFEASIBLE)

    def _wrench(self, q: FloatArray, v: FloatArray, com: FloatArray, speed: FloatArray, time: float) -> FloatArray:
        from surefoot.spatial import rotation_from_quaternion

        if not hasattr(self, "_start"):
            self._start = com.copy()
        R, m = rotation_from_quaternion(q[3:7]), self.robot.mass
        way = 2.0 * np.pi * 1.5 * time
        goal = self._start + self.sway * np.array([np.sin(way), 1.0 - np.cos(way), 0.0])
        force = m * (150.0 * (goal - com) - 20.0 * speed) + [0.0, 0.0, m * GRAVITY]
        tilt = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        return np.concatenate([force, -m * (8.0 * tilt + 0.8 * R @ v[3:6])])

    def _spoil(self, f: FloatArray) -> tuple[FloatArray, Any, bool]:
        """Return forces with the fault of an allocation, which feet may push, and whether that is attained."""
        n, weight = len(f), self.robot.mass * GRAVITY
        active = np.ones(n, dtype=bool)
        if self.fault == "no forces":
            return np.zeros_like(f), np.zeros(n, dtype=bool), True
        if self.fault == "pull":
            f = f + np.outer([1, -1, -1, 1], [0.0, 0.0, (0.3 + 0.3 * self.size) * weight])
        if self.fault == "infeasible":
            f = f + [(0.5 + self.size) * weight / n, 0.0, 0.0]
            f[:, :2] *= np.minimum(1.0, 0.6 * f[:, 2:] / np.maximum(np.hypot(f[:, :1], f[:, 1:2]), 1e-9))
            return f, active, False
        return f, active, True

    def _misapplied(self, f: FloatArray) -> FloatArray:
        """Return the forces as they enter J^T f."""
        if self.fault == "reversed":
            return -f
        if self.fault == "wrong frame":
            a = 0.3 + 0.7 * self.size
            axis = np.array([np.cos(self.phase), np.sin(self.phase), 0.0])
            K = _cross(axis)
            return f @ (np.eye(3) + np.sin(a) * K + (1.0 - np.cos(a)) * K @ K).T
        return f


def _cross(p: FloatArray) -> FloatArray:
    return np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])


def broken_log(fault: str, robot: str = "go2", size: float = 0.5, phase: float = 0.0, duration: float = 0.6) -> Log:
    """Return the log of a run in MuJoCo with a broken controller."""
    model = sf.load_robot(robot)
    world = sf.MujocoWorld(model, FlatTerrain(), 0.6)
    return sf.run(world, BrokenStand(model, fault, size, phase), sf.Scenario(duration, 0.6))
