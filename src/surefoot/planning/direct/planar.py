"""Small robots in the vertical plane, built joint by joint: a hopper and a biped with point feet.

Their base hangs on two slides and a hinge (x, z, pitch) that carry no motor: a plan's torque limits are zero
there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.arrays import BoolArray
from surefoot.robot.catalog import FootShape
from surefoot.robot.libraries import import_pinocchio
from surefoot.robot.robot import Robot

BASE = ("base_x", "base_z", "base_pitch")
"""Joints of the base: two slides and a hinge without motor."""
RADIUS = 0.02
"""Of a foot [m]."""


def planar_hopper() -> Robot:
    """Return a body on one leg of hip and knee: q = (x, z, pitch, hip, knee).

    6 kg of body, links of 0.25 m with 0.5 kg and 0.2 kg, motors of 40 N m.

    Examples
    --------
    >>> hopper = planar_hopper()
    >>> hopper.joints, hopper.foot_names, round(hopper.mass, 3)
    (5, ('foot',), 6.7)
    """
    return _planar("planar-hopper", 6.0, ("foot",), (0.0,))


def planar_biped() -> Robot:
    """Return a trunk on two legs of hip and knee: q = (x, z, pitch, hips and knees leg by leg).

    10 kg of trunk, legs as of `planar_hopper`.

    Examples
    --------
    >>> biped = planar_biped()
    >>> biped.joints, biped.foot_names
    (7, ('left', 'right'))
    """
    return _planar("planar-biped", 10.0, ("left", "right"), (0.15, -0.15))


def passive_joints(robot: Robot) -> BoolArray:
    """Return (joints,) which joints have no motor: the base of a planar robot, none of others."""
    return np.array([name in BASE for name in robot.joint_names], dtype=np.bool_)


def _planar(name: str, mass: float, feet: Sequence[str], apart: Sequence[float]) -> Robot:
    """Return a body over legs of two links, whose feet stand `apart` of the hip."""
    pin = import_pinocchio()
    model = pin.Model()
    model.name = name
    body = 0
    for joint, title in zip((pin.JointModelPX(), pin.JointModelPZ(), pin.JointModelRY()), BASE, strict=True):
        body = model.addJoint(body, joint, pin.SE3.Identity(), title)
    model.appendBodyToJoint(body, pin.Inertia.FromBox(mass, 0.3, 0.2, 0.15), pin.SE3.Identity())
    model.addFrame(pin.Frame("body", body, pin.SE3.Identity(), pin.FrameType.BODY))
    nominal = [0.0, 0.45, 0.0]
    for foot, ahead in zip(feet, apart, strict=True):
        prefix = "" if len(feet) == 1 else f"{foot}_"
        hip = _link(pin, model, body, f"{prefix}hip", 0.0, (0.5, 40.0, 20.0))
        knee = _link(pin, model, hip, f"{prefix}knee", 0.25, (0.2, 40.0, 20.0))
        at = pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.25]))
        model.addFrame(pin.Frame(foot, knee, at, pin.FrameType.BODY))
        nominal += [0.6 - ahead, -1.2]
    q = np.array(nominal)
    shapes = tuple(FootShape(((0.0, 0.0, 0.0),), RADIUS) for _ in feet)
    robot = Robot(name, model, pin.GeometryModel(), pin.GeometryModel, feet, q, False, shapes)
    robot.nominal = q.copy()
    robot.nominal[1] -= min(robot.foot_positions(q)[:, 2]) - RADIUS
    return robot


def _link(pin: Any, model: Any, parent: int, name: str, drop: float, size: tuple[float, float, float]) -> int:
    """Add a hinge about y with a rod of 0.25 m below it: mass [kg], torque [N m] and speed [rad/s] limits."""
    mass, effort, speed = size
    at = pin.SE3(np.eye(3), np.array([0.0, 0.0, -drop]))
    low, high = (np.array([-2.6]), np.array([2.6]))
    limits = np.array([effort]), np.array([speed]), low, high
    joint: int = model.addJoint(parent, pin.JointModelRY(), at, name, *limits)
    rod = pin.Inertia.FromCylinder(mass, 0.02, 0.25)
    model.appendBodyToJoint(joint, rod, pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.125])))
    return joint
