"""From a gait's name and a command to a schedule: timing by speed, and with `auto` the gait by speed too.

A gait by name keeps its own timing as long as the joints allow the commanded speeds; where they do not, it
becomes a schedule that hurries with the speed. `auto` stands at rest, walks slowly with three feet on the
ground, and trots from there on; hurried, the trot flies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait, Stride
from surefoot.control.command_limits import HURRIED_DUTY, Limited, Limits, hurried
from surefoot.control.gait import ContactSchedule, Gait
from surefoot.control.gait_library import PATTERNS, REFERENCE_LEG, GaitPattern, gait_names, named_gait
from surefoot.control.leg_demand import Pace
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import ProblemError, unknown_name
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.terrain import Terrain

AUTO = "auto"
"""Name of the choice by speed."""
WALKS_BELOW, HYSTERESIS = 0.12, 0.15
"""Speed up to which `auto` walks, as a share of sqrt(g h), and the share by which it must be passed."""
AUTO_WALK = (-0.125, 0.375, 0.625, 0.125)
"""Offsets of a walk that are nearest to a trot's: no foot moves by more than an eighth between them."""
LEAST_DUTY = {"walk": 0.65, "pace": 0.5}
"""A gait in the greatest hurry keeps its feet on the ground for this share; others for `HURRIED_DUTY`."""


@dataclass(frozen=True)
class Chosen:
    """What a walking controller begins with.

    Attributes
    ----------
    schedule
        When feet carry.
    command
        Within the robot's limits.
    notes
        What was changed, one line each.
    shortest
        The shortest period that the schedule may get [s]; 0 for one without a period.
    """

    schedule: ContactSchedule
    command: VelocityCommand
    notes: list[str]
    shortest: float


@dataclass(frozen=True)
class Body:
    """Whom the gait is for, and where.

    Attributes
    ----------
    robot
        With point feet.
    height, clearance
        Of its centre of mass above the ground, and of a swing at ease [m].
    terrain, mu
        The ground and its friction, as the controller believes.
    """

    robot: Robot
    height: float
    clearance: float
    terrain: Terrain
    mu: float

    def limits(self, pace: Pace, adaptable: bool, least_duty: float = HURRIED_DUTY) -> Limits:
        """Return what the legs can do with a gait's pace."""
        told = self.robot, pace, self.height, adaptable, self.terrain, self.mu, least_duty
        return Limits(*told)


def choose_gait(body: Body, command: VelocityCommand, gait: str | ContactSchedule) -> Chosen:
    """Return schedule and command for a gait, by name or as a schedule.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    if not isinstance(gait, str):
        return _fixed(body, command, gait)
    feet = len(body.robot.feet)
    names = gait_names(feet)
    if gait == AUTO and feet != len(AUTO_WALK):
        raise ProblemError(f"gait {AUTO!r} is for {len(AUTO_WALK)} feet, {body.robot.name} has {feet}")
    if gait != AUTO and names and gait not in names:
        raise ProblemError(unknown_name(f"gait for {feet} feet", gait, (*names, AUTO)))
    if gait == AUTO:
        return _automatic(body, command)
    own = named_gait(gait, feet, body.height)
    if own.swing_time == 0.0:
        return Chosen(own, command, [], own.period)
    pattern = PATTERNS[feet][gait]
    pace, least = _pace(body, pattern), LEAST_DUTY.get(gait, HURRIED_DUTY)
    limits = body.limits(pace, True, least)
    limited = limits.limit(command)
    most = float(limited.hurry.max())
    shortest = hurried(pace, most, least).period
    if most == 0.0:
        return Chosen(own, limited.command, limited.notes, shortest)

    def stride(velocity: FloatArray, now: str) -> Stride:
        share = limited.hurry_at(limits.size_of(velocity))
        return Stride(gait, hurried(pace, share, least), np.array(pattern.offset))

    schedule = AdaptiveGait(gait, stride, stride(np.zeros(3), gait))
    return Chosen(schedule, limited.command, limited.notes, shortest)


def _fixed(body: Body, command: VelocityCommand, schedule: ContactSchedule) -> Chosen:
    """Return a given schedule as it is, and the command slowed to what it allows."""
    if schedule.feet != len(body.robot.feet):
        raise ProblemError(
            f"the gait is for {schedule.feet} feet, {body.robot.name} has {len(body.robot.feet)}"
        )
    if isinstance(schedule, Gait):
        if schedule.swing_time == 0.0:
            return Chosen(schedule, command, [], schedule.period)
        moving = schedule.duty[schedule.duty < 1.0]
        pace = Pace(schedule.period, float(moving.min()), body.clearance)
        limited = body.limits(pace, False).limit(command)
        return Chosen(schedule, limited.command, limited.notes, schedule.period)
    limited = body.limits(_pace(body, GaitPattern(0.4, 0.55, ())), False).limit(command)
    return Chosen(schedule, limited.command, limited.notes, 0.0)


def _pace(body: Body, pattern: GaitPattern) -> Pace:
    """Return a pattern's own pace at a robot's size."""
    return Pace(pattern.period * math.sqrt(body.height / REFERENCE_LEG), pattern.duty, body.clearance)


def _automatic(body: Body, command: VelocityCommand) -> Chosen:
    """Return the schedule that stands, walks and trots by speed."""
    patterns = PATTERNS[len(body.robot.feet)]
    trot, walk = _pace(body, patterns["trot"]), _pace(body, patterns["walk"])
    limits = body.limits(trot, True)
    limited = limits.limit(command)
    slow = WALKS_BELOW * math.sqrt(GRAVITY * body.height)
    trot_offset, walk_offset = np.array(patterns["trot"].offset), np.array(AUTO_WALK)

    def stride(velocity: FloatArray, now: str) -> Stride:
        size = limits.size_of(velocity)
        if size == 0.0:
            return Stride(now, walk if now == "walk" else trot, _offset(now), moving=False)
        edge = slow * (1.0 + HYSTERESIS if now == "walk" else 1.0 - HYSTERESIS)
        if size < edge:
            return Stride("walk", walk, walk_offset)
        return Stride("trot", hurried(trot, limited.hurry_at(size)), trot_offset)

    def _offset(name: str) -> FloatArray:
        return walk_offset if name == "walk" else trot_offset

    first = stride(limited.command.at(0.0), "walk")
    return Chosen(AdaptiveGait(AUTO, stride, first), limited.command, limited.notes, _shortest(trot, limited))


def _shortest(pace: Pace, limited: Limited) -> float:
    """Return the period of a pace in its greatest hurry under a command [s]."""
    return hurried(pace, float(limited.hurry.max())).period
