"""The small mechanisms as robots on Pinocchio, so that exact steps and logs take them like any other.

Their coordinates are those of the systems in `textbook`: slides along x and z of the world in place of a free
base, which are joints without a motor here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.transcription import textbook
from surefoot.robot import Foot, Robot
from surefoot.robot.libraries import import_pinocchio


def ball(mass: float = 1.0, radius: float = 0.1) -> Robot:
    """Return a free ball of `mass` [kg] and `radius` [m]."""
    pinocchio = import_pinocchio()
    model: Any = pinocchio.Model()
    joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root_joint")
    model.appendBodyToJoint(joint, pinocchio.Inertia.FromSphere(mass, radius), pinocchio.SE3.Identity())
    frame = model.addBodyFrame("ball", joint, pinocchio.SE3.Identity(), 0)
    nominal = np.array(pinocchio.neutral(model))
    nominal[2] = radius
    return _robot("ball", model, [Foot("ball", frame, np.zeros((1, 3)), radius)], nominal, floating=True)


def hopper() -> Robot:
    """Return the hopper of `textbook.hopper`: joints x, z, hip [rad] and leg [m]."""
    pinocchio = import_pinocchio()
    model: Any = pinocchio.Model()
    joint = _slides(model, "x", "z")
    _mass(model, joint, textbook.BODY)
    here = pinocchio.SE3.Identity()
    joint = model.addJoint(joint, pinocchio.JointModelRY(), here, "hip")
    down = pinocchio.JointModelPrismaticUnaligned(np.array([0.0, 0.0, -1.0]))
    joint = model.addJoint(joint, down, here, "leg")
    _mass(model, joint, textbook.FOOT)
    frame = model.addBodyFrame("foot", joint, here, 0)
    _limit(model, [0.0, 0.0, *textbook.HOPPER_LIMIT])
    nominal = np.array([0.0, textbook.LEG, 0.0, textbook.LEG])
    return _robot("hopper", model, [Foot("foot", frame, np.zeros((1, 3)), 0.0)], nominal)


def block_and_foot() -> Robot:
    """Return the block and the foot of `textbook.pushed_block`: slides x and z of either.

    Its feet are where the block stands, and the foot's sphere.
    """
    pinocchio = import_pinocchio()
    model: Any = pinocchio.Model()
    here, radius = pinocchio.SE3.Identity(), textbook.FOOT_RADIUS
    block, foot = _slides(model, "block_x", "block_z"), _slides(model, "foot_x", "foot_z")
    _mass(model, block, textbook.BLOCK)
    _mass(model, foot, textbook.PUSHER)
    frames = [model.addBodyFrame(name, j, here, 0) for name, j in (("block", block), ("foot", foot))]
    _limit(model, [0.0, 0.0, *textbook.PUSH_LIMIT])
    feet = [
        Foot(name, frame, np.zeros((1, 3)), size)
        for name, frame, size in zip(("block", "foot"), frames, (0.0, radius), strict=True)
    ]
    return _robot("block_and_foot", model, feet, textbook.pushed_block().q)


def _slides(model: Any, *names: str) -> int:
    """Add slides along x and z of the world; return the last joint."""
    pinocchio = import_pinocchio()
    here = pinocchio.SE3.Identity()
    joint = model.addJoint(0, pinocchio.JointModelPX(), here, names[0])
    return int(model.addJoint(joint, pinocchio.JointModelPZ(), here, names[1]))


def _mass(model: Any, joint: int, mass: float) -> None:
    """Put a point mass [kg] at a joint."""
    pinocchio = import_pinocchio()
    point = pinocchio.Inertia(mass, np.zeros(3), np.zeros((3, 3)))
    model.appendBodyToJoint(joint, point, pinocchio.SE3.Identity())


def _limit(model: Any, limits: Sequence[float]) -> None:
    """Set what the motors can do; slides without one count as unlimited, and get zeros."""
    model.upperEffortLimit = np.asarray(limits)


def _robot(name: str, model: Any, feet: Sequence[Foot], nominal: FloatArray, floating: bool = False) -> Robot:
    """Return a robot without geometry."""
    empty = import_pinocchio().GeometryModel
    out = Robot(name, model, empty(), empty, (), nominal, floating)
    out.feet = tuple(feet)
    return out
