"""Getting up after a fall: how a robot on its side or back comes onto its belly, and when it does by itself.

A sampler found the postures by rolling a robot out from several ways of lying, in MuJoCo with all links,
motors and limits, each posture reached as the loop reaches it and the legs folded at the end. Front and hind
legs do the same, so that it turns about its long axis; left and right change places for the other way round.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Robot
from surefoot.motion.drive.modes import LoopMode
from surefoot.motion.drive.postures import BodyPostures, PostureMotion
from surefoot.motion.drive.readings import RobotReadings

FALLEN = "the robot has fallen"
"""The fault of one that leans too much, or whose body is down."""
UPRIGHT, LOW = 0.5, 0.4
"""A robot that leans more than this lies on its side or back [rad]; one whose body is lower over the ground
than this share of its usual height has fallen."""
ROLL_TIME, INSIDE = 0.3, 0.1
"""Time to each posture [s], and by how much they stay within the joints' ranges [rad]."""
TRIES = 4
"""How often a robot rolls, and from how many falls it gets up by itself until somebody asks for something."""
REST, STILL = 1.0, 0.3
"""A robot that turns, and whose joints do, slower than this [rad/s] for such a time [s] has come to lie."""
ROLLS = {
    "go2": (
        (0.24, 0.04, -2.72, 0.17, 0.48, -2.47),
        (0.44, 3.62, -2.71, 0.47, 4.36, -1.74),
        (0.42, 1.84, -0.07, 1.67, -0.04, -1.67),
        (0.08, 2.43, -2.25, 0.27, 2.71, -1.96),
        (0.20, 3.45, -2.42, 0.55, 1.92, -1.07),
    )
}
"""Of robots by name: hip, outward, thigh and calf of the left legs and of the right ones [rad]."""


class RollOver:
    """How a robot rolls over, from wherever it lies with folded legs.

    Parameters
    ----------
    robot
        Whose legs.
    postures
        Its own, the folded one among them.
    """

    def __init__(self, robot: Robot, postures: BodyPostures) -> None:
        self.postures, self.known = postures, robot.name in ROLLS and robot.joints == 12
        self._ways = [self._way(robot, left) for left in (True, False)] if self.known else []

    def _way(self, robot: Robot, left: bool) -> FloatArray:
        """Return (k, joints) angles in which it turns over, one way or the other [rad]."""
        table, out = np.array(ROLLS[robot.name]), np.tile(robot.nominal[7:], (len(ROLLS[robot.name]), 1))
        sides = np.sign(robot.foot_positions(robot.nominal)[:, 1])
        for row, side in zip(robot.contact_points.foot_support, sides, strict=True):
            angles = table[:, :3] if (side > 0.0) == left else table[:, 3:]
            out[:, np.flatnonzero(row[6:])] = angles * [side, 1.0, 1.0]
        low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
        return np.asarray(np.clip(out, low + INSIDE, high - INSIDE))

    def motions(self, angles: FloatArray, number: int) -> list[PostureMotion]:
        """Return what to do from (joints,) angles [rad] in the try of a number, up to folded legs."""
        way = self._ways[number % 2]
        rolls = [PostureMotion(np.array(pair), ROLL_TIME) for pair in pairwise([angles, *way])]
        return [*rolls, self.postures.approach(way[-1], self.postures.lie)]


class FallRecovery(Remembering):
    """Gets a robot up by itself after a fall, once it lies still, and walks on if it walked."""

    MEMORY = ("_falls", "_since", "_walked")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Begin anew: somebody has asked for something."""
        self._falls, self._since, self._walked = 0, 0.0, False

    def fell(self, mode: LoopMode, time: float) -> None:
        """Count a fall that happened in a mode at a time [s]."""
        self._walked |= mode is LoopMode.WALK
        self._falls, self._since = self._falls + 1, time

    def walks_on(self, mode: LoopMode, settled: bool) -> bool:
        """Whether a robot that has got up, and stands still (`settled`), is to walk again; true once."""
        on = mode is LoopMode.STAND and self._walked and settled
        self._walked &= not on
        return on

    def rises(self, mode: LoopMode, fault: str, time: float, readings: RobotReadings | None) -> bool:
        """Whether a robot that lies damped after a fall has lain still for long enough to get up.

        Parameters
        ----------
        mode, fault, time
            Of the loop; the time [s].
        readings
            Of now; None where none can be used.
        """
        if mode is not LoopMode.DAMP or fault != FALLEN or self._falls > TRIES:
            return False
        if readings is None or max(np.abs(readings.gyro).max(), np.abs(readings.speeds).max()) > STILL:
            self._since = time
            return False
        return time - self._since >= REST
