"""Impossible motions whose repair shows what one setting of repairs is for."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.certify.corruptions import resampled, spoil_each
from surefoot.base.arrays import BoolArray
from surefoot.records.motions.motion import Motion

RATE = 30.0
"""Frames per second [Hz]."""
MENDED = (
    "floating 3 cm",
    "floating 5 cm",
    "gliding 20 cm/s",
    "leaning 10 deg",
    "arms at 3 Hz",
    "turning body",
)
"""Corruptions that a repair mends without another pace."""
RAISED = {"hip_roll": -0.39, "ankle_roll": 0.39}
"""Angles that bring the G1's centre of mass above its left sole [rad]."""
BENT = {"hip_pitch": -0.2, "knee": 0.4, "ankle_pitch": -0.2}
"""Angles that raise its right foot by 7 cm [rad]."""
HEAVING, HEAVES = 0.16, 0.7
"""Height to which walks rise and from which they sink again [m], and how often [Hz]."""
WEAK = (0.3, 0.5)
"""Speeds of knees' motors over what a rising motion asks."""


def changed(robot: sf.Robot, **values: Any) -> sf.Robot:
    """Return a copy of a robot with other attributes."""
    out = copy.copy(robot)
    vars(out).update(values)
    return out


def rising_motion(robot: sf.Robot, low: float = 0.75, high: float = 0.2, duration: float = 1.5) -> Motion:
    """Return the robot straightening bent legs [rad] at an even speed, its soles flat on the ground."""
    count = round(duration * RATE)
    angles = np.linspace(low, high, count)
    q = np.tile(robot.nominal, (count, 1))
    for joint, share in (("hip_pitch", -1.0), ("knee", 2.0), ("ankle_pitch", -1.0)):
        for side in ("left", "right"):
            q[:, 7 + robot.joint_names.index(f"{side}_{joint}_joint")] = share * angles
    q[:, 2] -= [min(robot.sphere_bottoms(one)) for one in q]
    return Motion(robot, q, RATE, "rising")


def knees(robot: sf.Robot) -> BoolArray:
    """Return which joints are knees."""
    return np.array(["knee" in name for name in robot.joint_names])


def slow_knees(motion: Motion, share: float) -> Motion:
    """Return the motion of a robot whose knees turn at most so many times as fast as they do in it."""
    robot, mine = motion.robot, knees(motion.robot)
    most = np.abs(np.gradient(motion.q[:, 7:], 1.0 / motion.rate, axis=0))[:, mine].max()
    limits = np.where(mine, share * most, robot.speed_limits)
    return replace(motion, robot=changed(robot, speed_limits=limits))


def raised_foot(robot: sf.Robot, duration: float = 2.0) -> Motion:
    """Return the robot on its left foot, the right one still and 7 cm above, all of it 3 cm too high."""
    q = robot.nominal.copy()
    for sides, angles in ((("left", "right"), RAISED), (("right",), BENT)):
        for side in sides:
            for joint, angle in angles.items():
                q[7 + robot.joint_names.index(f"{side}_{joint}_joint")] += angle
    q[2] += 0.03 - min(robot.sphere_bottoms(q))
    return Motion(robot, np.tile(q, (round(duration * RATE), 1)), RATE, "one foot raised")


def heaving(motion: Motion) -> Motion:
    """Return the motion on a ground that rises and sinks."""
    q = motion.q.copy()
    phase = 2.0 * np.pi * HEAVES * np.arange(len(motion)) / motion.rate
    q[:, 2] += 0.5 * HEAVING * (1.0 + np.cos(phase))
    return replace(motion, q=q)


def repair_cases(name: str, walks: Sequence[Motion]) -> list[Motion]:
    """Return the impossible motions that decide a setting of repairs, from walks of one robot."""
    robot = walks[0].robot
    if name == "lowest":
        return [raised_foot(robot)]
    if name in ("calm", "stretch", "slowest", "paces"):
        return [slow_knees(rising_motion(robot), share) for share in WEAK]
    slow = [resampled(one, RATE) for one in walks]
    if name == "drift":
        return [heaving(one) for one in slow]
    return [spoilt for corruption, spoilt, _ in spoil_each(slow) if corruption.name in MENDED]
