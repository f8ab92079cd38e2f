"""Small robots in the vertical plane, built joint by joint: points, hoppers, a block and a foot.

Their bases hang on slides along x and z, and some on a hinge as well, that carry no motor: a plan's torque
limits are zero there. Names of such joints end like those of `UNDRIVEN`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.libraries import import_pinocchio
from surefoot.mechanics import Robot, shaped_foot

UNDRIVEN = ("base_x", "base_z", "base_pitch")
"""Joints of a base: two slides and a hinge without motor."""
RADIUS = 0.02
"""Of a foot [m]."""
BODY, FOOT, LEG = 3.0, 0.3, 0.5
"""The sliding hopper's masses [kg] and its leg's length as it stands [m]."""
BLOCK_WIDTH, BLOCK, PUSHER = 0.2, 2.0, 0.5
"""The width of the block [m], and its mass and that of the foot that pushes it [kg]."""


def point(name: str, radius: float = 0.0) -> Robot:
    """Return a point or ball of 1 kg that slides freely along x and z."""
    model = _model(name)
    _weigh(model, _slides(model, *UNDRIVEN[:2]))
    return _robot(model, [name], (radius,), [0.0, radius])


def sliding_hopper() -> Robot:
    """Return a body that stays upright on a leg that slides: q = (x, z, hip [rad], leg [m]).

    The leg leans back where the hip is positive; motors turn the hip and push along the leg.
    """
    pin = import_pinocchio()
    model = _model("hopper")
    body = _slides(model, *UNDRIVEN[:2], lowest=0.2)
    _weigh(model, body, BODY)
    down = pin.JointModelPrismaticUnaligned(np.array([0.0, 0.0, -1.0]))
    hip = _joint(model, body, pin.JointModelRY(), "hip", 40.0, -1.2, 1.2)
    leg = _joint(model, hip, down, "leg", 200.0, 0.25, 0.65)
    _weigh(model, leg, FOOT, "foot")
    return _robot(model, ["foot"], (0.0,), [0.0, LEG, 0.0, LEG])


def block_and_foot() -> Robot:
    """Return a block that does not tilt and a foot that forces move: q = x and z of either."""
    model = _model("block_and_foot")
    _weigh(model, _slides(model, *UNDRIVEN[:2]), BLOCK, "block")
    _weigh(
        model, _slides(model, "foot_x", "foot_z", effort=40.0, lowest=RADIUS, highest=0.18), PUSHER, "foot"
    )
    start = [0.0, 0.0, -0.5 * BLOCK_WIDTH - RADIUS - 0.1, 0.1]
    return _robot(model, ["block", "foot"], (0.0, RADIUS), start)


def planar_hopper() -> Robot:
    """Return a body on one leg of hip and knee: q = (x, z, pitch, hip, knee).

    6 kg of body, links of 0.25 m with 0.5 kg and 0.2 kg, motors of 40 N m.

    Examples
    --------
    >>> hopper = planar_hopper()
    >>> hopper.joints, hopper.foot_names, round(hopper.mass, 3)
    (5, ('foot',), 6.7)
    """
    pin = import_pinocchio()
    model = _model("planar-hopper")
    body = int(
        model.addJoint(_slides(model, *UNDRIVEN[:2]), pin.JointModelRY(), pin.SE3.Identity(), UNDRIVEN[2])
    )
    model.appendBodyToJoint(body, pin.Inertia.FromBox(6.0, 0.3, 0.2, 0.15), pin.SE3.Identity())
    model.addFrame(pin.Frame("body", body, pin.SE3.Identity(), pin.FrameType.BODY))
    knee = _link(model, _link(model, body, "hip", 0.0, 0.5), "knee", 0.25, 0.2)
    at = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.25]))
    model.addFrame(pin.Frame("foot", knee, at, pin.FrameType.BODY))
    robot = _robot(model, ["foot"], [RADIUS], [0.0, 0.45, 0.0, 0.6, -1.2])
    robot.nominal[1] -= robot.foot_positions(robot.nominal)[0, 2] - RADIUS
    return robot


def is_planar(robot: Robot) -> bool:
    """Return whether a robot is one of these: its base hangs on slides along x and z."""
    return not robot.floating and robot.joint_names[:2] == UNDRIVEN[:2]


def passive_joints(robot: Robot) -> BoolArray:
    """Return (joints,) which joints have no motor: the base of a planar robot, none of others."""
    return np.array([name in UNDRIVEN for name in robot.joint_names], dtype=np.bool_)


def _model(name: str) -> Any:
    """Return an empty model."""
    model = import_pinocchio().Model()
    model.name = name
    return model


def _robot(model: Any, feet: Sequence[str], radii: Sequence[float], nominal: Sequence[float]) -> Robot:
    """Return a model as a robot whose feet are spheres about frames."""
    empty, q = import_pinocchio().GeometryModel, np.array(nominal)
    shaped = [shaped_foot(model, f, [(0.0, 0.0, 0.0)], radius) for f, radius in zip(feet, radii, strict=True)]
    robot = Robot(model.name, model, empty(), empty, shaped, q, False)
    robot.nominal = q.copy()
    return robot


def _slides(
    model: Any, x: str, z: str, effort: float = 0.0, lowest: float = -np.inf, highest: float = np.inf
) -> int:
    """Add slides along x and z of the world, the second from `lowest` to `highest` [m]; return the last."""
    pin = import_pinocchio()
    return _joint(model, _joint(model, 0, pin.JointModelPX(), x, effort), pin.JointModelPZ(), z, effort,
                  lowest, highest)  # fmt: skip


def _joint(
    model: Any, parent: int, kind: Any, name: str, effort: float = 0.0, low: float = -np.inf,
    high: float = np.inf,
) -> int:  # fmt: skip
    """Add a joint where its parent is, with the largest torque or force of its motor and its range."""
    sides: list[FloatArray] = [np.array([value]) for value in (effort, np.inf, low, high)]
    return int(model.addJoint(parent, kind, import_pinocchio().SE3.Identity(), name, *sides))


def _weigh(model: Any, joint: int, mass: float = 1.0, frame: str = "") -> None:
    """Put a point mass [kg] at a joint, and a frame for a foot there, named as the model or otherwise."""
    pin = import_pinocchio()
    model.appendBodyToJoint(joint, pin.Inertia(mass, np.zeros(3), np.zeros((3, 3))), pin.SE3.Identity())
    model.addFrame(pin.Frame(frame or model.name, joint, pin.SE3.Identity(), pin.FrameType.BODY))


def _link(model: Any, parent: int, name: str, drop: float, mass: float) -> int:
    """Add a hinge about y, of 40 N m and 20 rad/s, with a rod of 0.25 m and some mass [kg] below it."""
    pin = import_pinocchio()
    at = pin.SE3(np.eye(3), np.array([0.0, 0.0, -drop]))
    limits = [np.array([value]) for value in (40.0, 20.0, -2.6, 2.6)]
    joint: int = model.addJoint(parent, pin.JointModelRY(), at, name, *limits)
    rod = pin.Inertia.FromCylinder(mass, 0.02, 0.25)
    model.appendBodyToJoint(joint, rod, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.125])))
    return joint
