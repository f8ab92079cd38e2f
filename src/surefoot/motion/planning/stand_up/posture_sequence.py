"""A motion as postures to pass through: joint targets at times, straight lines between, a PD law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot
from surefoot.records import Log

SLOW = 0.6
"""Share of the joints' speed limits that postures are reached with at most: feet then touch down softly."""
CUSHION, HARDER = 0.08, 8.0
"""How far before the ends of its range a joint is pushed back [rad], and by how much stiffer a spring."""
TAPER = 0.4
"""Share of the speed limit over which the torque along the motion falls to nothing."""


@dataclass(frozen=True, eq=False)
class Postures:
    """Joint targets over time, and the gains and limits with which joints follow them.

    Attributes
    ----------
    times
        (K,) when each posture is reached [s], increasing from above 0.
    targets
        (K, joints) [rad].
    stiffness, damping
        Of every joint [N m/rad, N m s/rad].
    effort, speed
        (joints,) torque limits [N m] and speed limits [rad/s]: torque along the motion falls to nothing over
        the last part of the speed, see `TAPER`.
    low, high
        (joints,) the joints' range [rad]; before its ends a stiffer spring pushes back.

    Raises
    ------
    ProblemError
        For times that do not increase, or shapes that do not fit.
    """

    times: FloatArray
    targets: FloatArray
    stiffness: float
    damping: float
    effort: FloatArray
    speed: FloatArray
    low: FloatArray
    high: FloatArray

    def __post_init__(self) -> None:
        if len(self.times) != len(self.targets) or self.targets.shape[1:] != self.effort.shape:
            raise ProblemError(
                f"postures need a time each and a target for every joint, got {self.times.shape}, "
                f"{self.targets.shape} and {self.effort.shape}"
            )
        if not (np.diff(self.times, prepend=0.0) > 0.0).all():
            raise ProblemError("the times of postures must increase from above 0")

    @classmethod
    def of(
        cls, robot: Robot, times: FloatArray, targets: FloatArray, stiffness: float, damping: float
    ) -> Postures:
        """Return postures within the limits of a robot's model, of its speeds to `SLOW` of them.

        Parameters
        ----------
        robot
            Whose joints.
        times, targets
            (K,) [s] and (K, joints) [rad].
        stiffness, damping
            Of every joint [N m/rad, N m s/rad].
        """
        first = int(robot.model.nq) - robot.joints
        low, high = robot.model.lowerPositionLimit[first:], robot.model.upperPositionLimit[first:]
        effort, speed = robot.effort_limits, SLOW * robot.speed_limits
        return cls(times, targets, stiffness, damping, effort, speed, np.array(low), np.array(high))

    @classmethod
    def read(cls, plan: Log, robot: Robot) -> Postures:
        """Return the postures of a plan, which are among its facts.

        Raises
        ------
        ProblemError
            If it has none.
        """
        table = [np.asarray(plan.fact(f"posture_{k}"), dtype=np.float64) for k in ("times", "targets")]
        gains = [float(plan.fact(f"posture_{k}")) for k in ("stiffness", "damping")]
        return cls.of(robot, table[0], table[1], gains[0], gains[1])

    @property
    def facts(self) -> dict[str, Any]:
        """What a plan says of them."""
        return {f"posture_{k}": getattr(self, k) for k in ("times", "targets", "stiffness", "damping")}

    @property
    def duration(self) -> float:
        """When the last posture is reached [s]."""
        return float(self.times[-1])

    def at(self, time: float, start: FloatArray) -> FloatArray:
        """Return the target (joints,) at a time since the start in posture `start` (joints,)."""
        k = int(np.searchsorted(self.times, time, side="right"))
        if k == len(self.times):
            return np.asarray(self.targets[-1])
        before, when = (start, 0.0) if k == 0 else (self.targets[k - 1], float(self.times[k - 1]))
        share = max(time - when, 0.0) / (float(self.times[k]) - when)
        return np.asarray((1.0 - share) * before + share * self.targets[k])

    def torques(self, target: FloatArray, angles: FloatArray, speeds: FloatArray) -> FloatArray:
        """Return the torques (joints,) that pull joints to a target [N m]."""
        pull = self.stiffness * (target - angles) - self.damping * speeds
        over = np.maximum(self.low + CUSHION - angles, 0.0) - np.maximum(angles - self.high + CUSHION, 0.0)
        pull += HARDER * self.stiffness * over
        driving = self.effort * np.clip((1.0 - np.abs(speeds) / self.speed) / TAPER, 0.0, 1.0)
        high = np.where(speeds > 0.0, driving, self.effort)
        low = np.where(speeds < 0.0, driving, self.effort)
        return np.asarray(np.minimum(np.maximum(pull, -low), high))
