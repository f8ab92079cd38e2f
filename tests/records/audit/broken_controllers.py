"""Controllers and worlds that are broken on purpose: the chapter's symptoms, as they come about.

`BrokenStand` is a controller of its own on Pinocchio's Jacobians: a spring on the base gives a wrench,
least squares share it out, J^T f gives the torques. Each fault is one that people make.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion, skew
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import Command, Controller, RobotState
from surefoot.records.log import Log
from surefoot.worlds.bullet.bullet_world import BulletWorld

CONTROL = ("no forces", "infeasible", "wrong frame", "reversed", "coarse facets", "pull")
WORLD = ("sinking", "chatter")
FAULTS = (*CONTROL, *WORLD)
NAMES = {
    "pull": ("commanded pull",), "sinking": ("sinking", "deep contact"),
    "chatter": ("energy gain",),
}  # fmt: skip
"""Names under which a fault may be reported, where they are not its own: an undamped contact does both."""


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
        frames = robot.contact_points.frames
        J = [pin.getFrameJacobian(model, data, f, pin.LOCAL_WORLD_ALIGNED)[:3] for f in frames]
        feet = np.array([data.oMf[f].translation for f in frames])
        wrench = self._wrench(q, v, np.array(data.com[0]), np.array(data.vcom[0]), state.time)
        grasp = np.hstack([np.vstack([np.eye(3), skew(p - data.com[0])]) for p in feet])
        forces = np.linalg.lstsq(grasp, wrench, rcond=None)[0].reshape(n, 3)
        forces, active, attained = self._spoil(forces, state.time)
        applied = self._misapplied(forces)
        legs = sum((Jk[:, 6:].T @ f for Jk, f in zip(J, applied, strict=True)), np.zeros(robot.joints))
        torques = pin.computeGeneralizedGravity(model, data, q)[6:] - legs
        torques = np.clip(torques, -robot.effort_limits, robot.effort_limits)
        return Command(torques, forces, active, attained, Status.SOLVED if attained else Status.INFEASIBLE)

    def _wrench(
        self, q: FloatArray, v: FloatArray, com: FloatArray, speed: FloatArray, time: float
    ) -> FloatArray:
        if not hasattr(self, "_start"):
            self._start = com.copy()
        R, m = rotation_from_quaternion(q[3:7]), self.robot.mass
        way = 2.0 * np.pi * 1.5 * time
        goal = self._start + self.sway * np.array([np.sin(way), 1.0 - np.cos(way), 0.0])
        force = m * (150.0 * (goal - com) - 20.0 * speed) + [0.0, 0.0, m * GRAVITY]
        tilt = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        return np.concatenate([force, -m * (8.0 * tilt + 0.8 * R @ v[3:6])])

    def _spoil(self, f: FloatArray, time: float) -> tuple[FloatArray, Any, bool]:
        """Return forces with the fault of an allocation, which feet may push, whether all is attained."""
        n, weight = len(f), self.robot.mass * GRAVITY
        active = np.ones(n, dtype=bool)
        if self.fault == "no forces":
            return np.zeros_like(f), np.zeros(n, dtype=bool), True
        if self.fault == "pull":
            f = f + np.outer([1, -1, -1, 1], [0.0, 0.0, (0.3 + 0.3 * self.size) * weight])
        if self.fault == "infeasible":
            f = f + np.array([(0.5 + self.size) * weight / n, 0.0, 0.0])
            f[:, :2] *= np.minimum(1.0, 0.6 * f[:, 2:] / np.maximum(np.hypot(f[:, :1], f[:, 1:2]), 1e-9))
            return f, active, False
        if self.fault == "coarse facets":  # legs push against each other up to an outer pyramid of four
            way = np.pi * time + 0.5 * np.pi * np.array([0.0, 1.0, 3.0, 2.0])
            out = f[:, 2:] * np.column_stack([np.cos(way), np.sin(way)])
            a = self.phase + 0.5 * np.pi * np.arange(4)
            reach = (out @ np.stack([np.cos(a), np.sin(a)])).max(axis=1, keepdims=True)
            f[:, :2] = out * 0.6 * f[:, 2:] / np.maximum(reach, 1e-9)
        return f, active, True

    def _misapplied(self, f: FloatArray) -> FloatArray:
        """Return the forces as they enter J^T f."""
        if self.fault == "reversed":
            return -f
        if self.fault == "wrong frame":
            a = 0.3 + 0.7 * self.size
            axis = np.array([np.cos(self.phase), np.sin(self.phase), 0.0])
            K = skew(axis)
            return f @ (np.eye(3) + np.sin(a) * K + (1.0 - np.cos(a)) * K @ K).T
        return f


def _world(fault: str, model: Robot, world: str, size: float) -> Any:
    """Return a world, broken where the fault is one of worlds."""
    rigid = world == "rigid"
    if world == "bullet":
        return BulletWorld(model, FlatTerrain(), 0.6, contact=_bullet_contact(fault, model.mass, size))
    if fault == "sinking":  # 8 to 25 mm under its own weight
        depth = 0.008 + 0.017 * size
        if rigid:
            stiffness = 0.25 * model.mass * GRAVITY / depth
            damping = 2.0 * np.sqrt(stiffness * model.mass / 4)
            law = sf.laws.SpringDamper(stiffness=stiffness, damping=damping)
            return sf.RigidWorld(model, FlatTerrain(), 0.6, law=law)
        return sf.MujocoWorld(model, FlatTerrain(), 0.6, solref=(0.1 + 0.1 * size, 1.0))
    if fault == "chatter":  # hardly damped, of a frequency that a step of a millisecond does not resolve
        return sf.MujocoWorld(model, FlatTerrain(), 0.6, solref=(-(2e5 + 8e5 * size), -1.0))
    return sf.RigidWorld(model, FlatTerrain(), 0.6) if rigid else sf.MujocoWorld(model, FlatTerrain(), 0.6)


def _bullet_contact(fault: str, mass: float, size: float) -> dict[str, float]:
    """Return a foot's contact in Bullet: soft, all but undamped, or Bullet's own."""
    if fault == "sinking":
        stiffness = 0.25 * mass * GRAVITY / (0.008 + 0.017 * size)
        return {"contactStiffness": stiffness, "contactDamping": np.sqrt(stiffness * mass)}
    return {"restitution": 0.9 + 0.1 * size} if fault == "chatter" else {}


@dataclass(frozen=True)
class BrokenRun:
    """A robot that stands, in a world, with one fault of one size."""

    robot: str
    world: str
    fault: str
    size: float
    phase: float

    def log(self, duration: float = 0.6) -> Log:
        """Simulate it; what the world declares of its softness is its own affair."""
        model = sf.load_robot(self.robot)
        world = _world(self.fault, model, self.world, self.size)
        fault = self.fault if self.fault in CONTROL else ""
        lift = 5e-4 if self.fault == "chatter" else 0.0
        q = model.nominal.copy()
        q[2] += lift
        controller = BrokenStand(model, fault, self.size, self.phase)
        return sf.run(world, controller, sf.Scenario(duration, 0.6, start=q))

    def named(self, report: sf.AuditReport) -> bool:
        """Return whether an audit names the fault first, of the command or of the physics."""
        first = [found[0].name for found in (report.command, report.symptoms) if found]
        return bool(set(first) & {self.fault, *NAMES.get(self.fault, ())})


def broken_runs(count: int, seed: int, worlds: Sequence[str] = ("mujoco", "rigid")) -> list[BrokenRun]:
    """Return broken runs drawn by a seed."""
    rng = np.random.default_rng(seed)
    out = []
    for k in range(count):
        robot, world = str(rng.choice(["go2", "a1", "solo12"])), str(rng.choice(worlds))
        size, phase = float(rng.uniform()), float(rng.uniform(0.0, 0.5 * np.pi))
        out.append(BrokenRun(robot, world, FAULTS[k % len(FAULTS)], size, phase))
    return out
