"""Takes a robot from wherever it lies or stands to a posture: motions in turn, without feedback."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Actuators, Robot
from surefoot.motion.control.controller import JointTargets
from surefoot.motion.drive.getting_up import TRIES, RollOver
from surefoot.motion.drive.postures import BodyPostures, PostureMotion, posture_gains

SETTLE = 0.4
"""Time in a posture before what follows begins [s]."""
NEAR = 0.5
"""Legs whose joints are all so near to those of the stance need not be folded before it [rad]."""


class PosturePlayer(Remembering):
    """Plays motions to a posture, and holds it.

    Parameters
    ----------
    robot
        With a floating base.
    dt
        Time between calls of `targets` [s].
    actuators
        The motors; None for ideal ones.

    Attributes
    ----------
    postures, roll_over
        Those of the robot, and how it comes onto its belly.
    lying
        Whether it lies on its side or back, or has just rolled onto its belly, on its way to standing.
    """

    MEMORY = ("_motions", "_since", "_posed", "lying", "_tries", "_end")

    def __init__(self, robot: Robot, dt: float, actuators: Actuators | None = None) -> None:
        self.postures, self.dt = BodyPostures(robot), dt
        self._still = np.zeros(robot.joints)
        self.roll_over, self._nominal = RollOver(robot, self.postures), robot.nominal[7:]
        self._gains = posture_gains(robot, dt, actuators)
        self.reset()

    def reset(self) -> None:
        """Play nothing, from standing."""
        self._motions: list[PostureMotion] = []
        self._since, self._posed = 0.0, BodyPostures.stand
        self.lying, self._tries = False, 0

    def take(self, goal: str, angles: FloatArray, time: float, *, anywhere: bool, leans: bool) -> None:
        """Set off to a posture.

        Parameters
        ----------
        goal
            "stand", "sit" or "lie".
        angles
            (joints,) of now [rad].
        time
            Of now [s].
        anywhere
            Whether the joints may be anywhere: legs are folded first, unless they are nearly where they
            should be.
        leans
            Whether the robot lies on its side or back: to stand, it rolls over first, see `go_on`.
        """
        postures, begin = self.postures, self._posed
        end = {"stand": postures.stand, "sit": postures.sit, "lie": postures.lie}[goal]
        if anywhere:
            near = float(np.abs(angles - self._nominal).max()) < NEAR
            begin = postures.stand if near else postures.lie
        if self.lying or (goal == "stand" and leans):
            begin = postures.lie
        self.lying, self._tries = goal == "stand" and leans, 0
        self._motions = [postures.approach(angles, begin)]
        if not self.lying:
            self._motions.append(postures.way(begin, end))
        self._since, self._posed = time, end

    def go_on(self, angles: FloatArray, time: float, leans: bool) -> bool:
        """Roll over from (joints,) angles [rad], or rise from the belly; return whether tries are left."""
        if leans and self._tries == TRIES:
            return False
        postures, self._since, self.lying = self.postures, time, leans
        if leans:
            self._motions = self.roll_over.motions(angles, self._tries)
            self._tries += 1
        else:
            self._motions = [postures.way(postures.lie, postures.stand)]
        return True

    def rest(self, time: float) -> float:
        """Return how long the end of the last motion has been held [s]; 0 on the way."""
        return 0.0 if self._motions else time - self._since

    def targets(self, time: float) -> JointTargets:
        """Return the joints' targets at a time [s]."""
        clock = time - self._since
        if self._motions and clock >= self._motions[0].duration:
            self._end = self._motions.pop(0).points[-1]
            self._since, clock = time, 0.0
        angles, speeds = (self._end if not self._motions else self._motions[0].at(clock)), self._still
        if self._motions:
            speeds = self._motions[0].speeds(clock, self.dt)
        return JointTargets(angles, speeds, *self._gains, self._still)
