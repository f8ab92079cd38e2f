"""What a standing robot wants over time: where its base is, and which feet are in the air."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.walking.swing import minimum_jerk

SHIFT_TIME = 4.0
"""Time to move the weight before a foot leaves the ground and after it returns, in units of sqrt(height / g).

A faster shift takes more of its braking from the foot that is to be lifted: over this time the centre of
pressure runs ahead of the weight by at most 36 % of the way.
"""
UNLOAD_TIME = 0.15
"""Time over which a foot's largest normal force ramps down before lift-off, and up after touchdown [s]."""
SHORTEST_SHIFT = 0.3
CLEARANCE = 0.15
"""Height of a lifted foot over the ground, as a share of the base's height."""


@dataclass(frozen=True)
class Lift:
    """A foot that leaves the ground at `start` and is back at `end` [s]."""

    foot: str
    start: float
    end: float


@dataclass(frozen=True)
class StandingTarget:
    """What is wanted at one instant.

    Attributes
    ----------
    position, velocity, acceleration
        (3,) of the base in world axes [m, m/s, m/s²].
    stance
        (n,) whether each foot should push.
    load
        (n,) share of its largest normal force that a foot may carry, 0 to 1.
    height, climb
        (n,) height over the ground that a foot in the air should have [m], and its rate [m/s].
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    stance: BoolArray
    load: FloatArray
    height: FloatArray
    climb: FloatArray


class StandingPlan:
    """The base's path and the feet's duties; without lifts, standing still.

    Before a foot leaves the ground the weight moves over the middle of the others, along the terrain,
    so that the stance stays possible.

    Parameters
    ----------
    robot
        Who stands.
    terrain
        On what.
    q
        (nq,) configuration at the start [m, -, rad].
    lifts
        Feet to lift, in any order; their times may not overlap or come closer than a shift takes.

    Raises
    ------
    ModelError
        For a foot that the robot does not have.
    ProblemError
        For lifts that end before they start, overlap, or leave no time to shift the weight.
    """

    def __init__(self, robot: Robot, terrain: Terrain, q: FloatArray, lifts: Sequence[Lift] = ()) -> None:
        of_kind("robot", robot, Robot)
        of_kind("terrain", terrain, Terrain)
        self.robot, self.terrain = robot, terrain
        self.start = np.array(q[:3])
        self.lifts = tuple(sorted(lifts, key=lambda lift: lift.start))
        self._feet = [robot.foot_names.index(robot.foot(lift.foot).name) for lift in self.lifts]
        self._check()
        self._contacts = robot.stance(q, terrain=terrain).positions
        self._com = robot.com(q)
        height = float(np.linalg.norm(self.start - self._contacts.mean(axis=0)))
        self._clearance = CLEARANCE * height
        self._shift_time = SHIFT_TIME * math.sqrt(height / GRAVITY)
        self._keys = self._key_frames()
        n = len(robot.feet)
        still = np.zeros(3)
        self._idle = StandingTarget(
            self.start, still, still, np.ones(n, dtype=bool), np.ones(n), np.zeros(n), np.zeros(n)
        )

    def _check(self) -> None:
        last = 0.0
        for lift in self.lifts:
            real_number("lift start", lift.start, low=0.0)
            if not lift.end > lift.start:
                raise ProblemError(f"a lift must end after it starts, got {lift.start:g} to {lift.end:g} s")
            gap = SHORTEST_SHIFT if last == 0.0 else 2.0 * SHORTEST_SHIFT
            if lift.start - last < gap - 1e-9:
                raise ProblemError(
                    f"lifting {lift.foot} at {lift.start:g} s leaves no time to shift the weight: "
                    f"the earliest is {last + gap:g} s"
                )
            last = lift.end

    def shifted(self, foot: int) -> FloatArray:
        """Return the base position that puts the weight over all feet but one: (3,) [m]."""
        others = np.delete(self._contacts, foot, axis=0)
        step = np.zeros(3)
        step[:2] = others.mean(axis=0)[:2] - self._com[:2]
        normal = self.terrain.normal(self.start[:2])
        step[2] = -float(normal[:2] @ step[:2]) / float(normal[2])  # along the ground
        return self.start + step

    def com(self, lift: int) -> FloatArray:
        """Return the centre of mass during a lift: (3,) [m]."""
        return np.asarray(self._com + self.shifted(self._feet[lift]) - self.start)

    def _key_frames(self) -> list[tuple[float, FloatArray]]:
        """Return the times and base positions between which the base moves smoothly."""
        keys: list[tuple[float, FloatArray]] = [(0.0, self.start)]
        free = 0.0
        for k, (lift, foot) in enumerate(zip(self.lifts, self._feet, strict=True)):
            place = self.shifted(foot)
            # There before the foot is unloaded: the others can carry the weight only once it is above them.
            arrive = lift.start - min(UNLOAD_TIME, 0.25 * (lift.start - free))
            keys.append((max(free, arrive - self._shift_time), keys[-1][1]))
            keys.append((arrive, place))
            leave = lift.end + UNLOAD_TIME
            keys.append((leave, place))
            following = self.lifts[k + 1].start if k + 1 < len(self.lifts) else np.inf
            free = min(leave + self._shift_time, 0.5 * (leave + following))
            keys.append((free, self.start))
        return keys

    @cached_property
    def _times(self) -> FloatArray:
        return np.array([t for t, _ in self._keys])

    def at(self, time: float) -> StandingTarget:
        """Return what is wanted at a time [s]."""
        if not self.lifts:
            return self._idle
        position, velocity, acceleration = self._base(time)
        n = len(self.robot.feet)
        stance, load = np.ones(n, dtype=bool), np.ones(n)
        height, climb = np.zeros(n), np.zeros(n)
        for lift, foot in zip(self.lifts, self._feet, strict=True):
            if lift.start <= time < lift.end:
                stance[foot], load[foot] = False, 0.0
                half = min(0.4, 0.5 * (lift.end - lift.start))
                since, left = time - lift.start, lift.end - time
                share, sign = (since / half, 1.0) if since < left else (left / half, -1.0)
                value, slope, _ = minimum_jerk(share)
                height[foot], climb[foot] = self._clearance * value, sign * self._clearance * slope / half
            elif lift.start - UNLOAD_TIME < time < lift.start:
                load[foot] = (lift.start - time) / UNLOAD_TIME
            elif lift.end <= time < lift.end + UNLOAD_TIME:
                load[foot] = (time - lift.end) / UNLOAD_TIME
        return StandingTarget(position, velocity, acceleration, stance, load, height, climb)

    def _base(self, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the base's wanted position, velocity and acceleration."""
        k = int(np.searchsorted(self._times, time, side="right"))
        if k == len(self._keys):
            return self.start, np.zeros(3), np.zeros(3)
        (begin, a), (end, b) = self._keys[k - 1], self._keys[k]
        span = max(end - begin, 1e-9)
        value, slope, curve = minimum_jerk((time - begin) / span)
        step = b - a
        return a + value * step, slope / span * step, curve / span**2 * step
