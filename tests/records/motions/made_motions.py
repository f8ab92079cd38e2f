"""Motions of our own making: a robot that stands on one foot, then on the other, and waves all its joints."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pinocchio

import surefoot as sf
from surefoot.records.motions.joint_orders import breadth_first, mirror_names

RATE, FRAMES = 50.0, 150


@cache
def g1() -> sf.Robot:
    """Return the G1 of the catalogue."""
    return sf.load_robot("g1")


def waved(robot: sf.Robot, seed: int, heading: float = 0.7) -> Any:
    """Return (FRAMES, nq) configurations: the foot that stands is exactly where it was, flat on z = 0."""
    rng = np.random.default_rng(seed)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    size = np.minimum(0.35, 0.4 * np.minimum(high - robot.nominal[7:], robot.nominal[7:] - low).clip(0.05))
    pace, phase = rng.uniform(0.3, 0.9, robot.joints), rng.uniform(0.0, 6.0, robot.joints)
    times = np.arange(FRAMES)[:, None] / RATE
    joints = robot.nominal[7:] + size * np.sin(2.0 * np.pi * pace * times + phase)
    q = np.hstack([np.tile(robot.nominal[:7], (FRAMES, 1)), joints])
    data, turn = robot.model.createData(), pinocchio.SE3(pinocchio.utils.rotate("z", heading), np.zeros(3))
    stand = turn
    for k, row in enumerate(q):
        foot = robot.feet[0 if k < FRAMES // 2 else 1]
        if k == FRAMES // 2:  # the other foot stands from where it is above the ground, put flat
            place = _pose(robot, data, q[k - 1], foot)
            stand = pinocchio.SE3(turn.rotation, np.array([*place.translation[:2], 0.035]))
        if k == 0:
            stand = pinocchio.SE3(turn.rotation, np.array([0.2, -0.4, 0.035]))
        base = stand * _pose(robot, data, np.r_[np.zeros(6), 1.0, row[7:]], foot).inverse()
        row[:7] = pinocchio.SE3ToXYZQUAT(base)
    return q


def _pose(robot: sf.Robot, data: Any, q: Any, foot: Any) -> Any:
    pinocchio.framesForwardKinematics(robot.model, data, q)
    return data.oMf[foot.frame].copy()


def wxyz(q: Any) -> Any:
    """Return whole configurations with their quaternions w first."""
    return np.hstack([q[:, :3], q[:, [6, 3, 4, 5]], q[:, 7:]])


def in_order(robot: sf.Robot, q: Any, names: Any) -> Any:
    """Return the joints of configurations in the order of names."""
    return q[:, [7 + robot.joint_names.index(name) for name in names]]


def spoilt(robot: sf.Robot, q: Any, kind: str) -> tuple[Any, Any, Any]:
    """Return place, quaternion and joints with conventions other than the usual ones."""
    place, turn, joints = q[:, :3], q[:, 3:7], q[:, 7:]
    if "wxyz" in kind:
        turn = wxyz(q)[:, 3:7]
    if "breadth" in kind:
        joints = in_order(robot, q, breadth_first(robot))
    if "sides" in kind:
        joints = in_order(robot, q, [mirror_names(robot)[name] for name in robot.joint_names])
    if "shuffled" in kind:
        joints = joints[:, np.random.default_rng(len(q)).permutation(robot.joints)]
    if "degrees" in kind:
        joints = np.degrees(joints)
    return place, turn, joints


def same(motion: sf.Motion, q: Any, tolerance: float = 1e-9) -> bool:
    """Tell whether a motion has these configurations; a quaternion and its negative are one rotation."""
    turns = np.abs(np.einsum("ti,ti->t", motion.q[:, 3:7], q[:, 3:7]))
    rest = np.delete(motion.q - q, range(3, 7), axis=1)
    return bool(np.abs(rest).max() < tolerance and np.abs(turns - 1.0).max() < tolerance)
