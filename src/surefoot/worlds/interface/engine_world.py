"""What worlds do alike whose engine builds the robot anew, Drake and Bullet, and the plain data for it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ModelError, SimulationError
from surefoot.mechanics import GroundBox, Plane, Robot, Stepper, Terrain, loaded_model
from surefoot.worlds.interface.world import ContactReading, ground_of

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

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""
        return self._q.copy(), self._v.copy()

    def _undo_step(self) -> SimulationError:
        """Return to the state before the last step; return the error that names the joint at fault."""
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


def scene_of(
    robot: Robot, terrain: Terrain, payload: float = 0.0, payload_position: ArrayLike = (0.0, 0.0, 0.0)
) -> dict[str, Any]:
    """Return a robot's tree of joints, its contact spheres and the ground as plain data.

    `payload_position` is (3,) in base axes [m].

    Raises
    ------
    ModelError
        For a joint or a shape of ground that these worlds do not build.
    """
    load = payload if robot.floating else 0.0
    model, points = loaded_model(robot.model, load, payload_position), robot.contact_points
    joints = [_joint(model, index) for index in range(1, model.njoints)]
    spheres = [
        [int(joint), place.tolist(), float(radius)]
        for joint, place, radius in zip(points.joints, points.places, points.radii, strict=True)
    ]
    ground = []
    for shape in terrain.shapes():
        if type(shape) not in _GROUND:
            raise ModelError(
                f"this world takes planes and boxes, a {type(terrain).__name__} is made of a "
                f"{type(shape).__name__}"
            )
        ground.append(_GROUND[type(shape)](shape))
    gravity = np.array(model.gravity.linear).tolist()
    return {"joints": joints, "spheres": spheres, "ground": ground, "gravity": gravity}


def _joint(model: Any, index: int) -> dict[str, Any]:
    """Return a joint and the body that it carries."""
    joint, pose, inertia = model.joints[index], model.jointPlacements[index], model.inertias[index]
    words: dict[str, Any] = {
        "parent": int(model.parents[index]), "rotation": pose.rotation.tolist(),
        "place": pose.translation.tolist(), "mass": float(inertia.mass), "com": inertia.lever.tolist(),
        "inertia": inertia.inertia.tolist(),
    }  # fmt: skip
    kind, axis = joint_kind(joint, str(model.names[index]))
    low, high = -np.inf, np.inf
    if kind != "free":
        low, high = (
            float(limits[joint.idx_q]) for limits in (model.lowerPositionLimit, model.upperPositionLimit)
        )
        if not low < high:
            low, high = -np.inf, np.inf
    return {**words, "kind": kind, "axis": axis, "low": low, "high": high}


def joint_kind(joint: Any, name: str) -> tuple[str, list[float]]:
    """Return free, revolute or prismatic, and the axis, of a Pinocchio joint; `name` is for the error."""
    kind, axes = joint.shortname().removeprefix("JointModel"), np.eye(3)
    if kind == "FreeFlyer":
        return "free", [0.0, 0.0, 0.0]
    words = {"R": "revolute", "P": "prismatic"}
    if kind in ("RevoluteUnaligned", "PrismaticUnaligned"):
        return words[kind[0]], np.array(joint.extract().axis).tolist()
    if len(kind) == 2 and kind[0] in words and kind[1] in "XYZ":
        return words[kind[0]], axes["XYZ".index(kind[1])].tolist()
    if kind.startswith("RUB") or kind == "RevoluteUnboundedUnaligned":
        raise ModelError(
            f"joint {name} turns without end, as a wheel does, and this world takes hinges that have a range "
            "(type revolute), and slides. Give it a range, or weld it (type fixed)"
        )
    raise ModelError(f"joint {name} is a {kind}; this world takes revolute and prismatic joints")


def _plane(plane: Plane) -> dict[str, Any]:
    return {"rotation": plane.rotation.tolist(), "place": plane.point.tolist()}


def _box(box: GroundBox) -> dict[str, Any]:
    return {"rotation": np.eye(3).tolist(), "place": box.centre.tolist(), "size": box.size.tolist()}


_GROUND: dict[type, Any] = {Plane: _plane, GroundBox: _box}
