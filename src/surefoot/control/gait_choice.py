"""From a gait's name and a command to a schedule: timing by speed, and with `auto` the gait by speed too.

A gait by name keeps its own timing as long as the joints allow the commanded speeds; where they do not, it
becomes a schedule that hurries with the speed. `auto` stands at rest, walks slowly with three feet on the
ground, and trots from there on; hurried, the trot flies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait, Stride
from surefoot.control.command_limits import HURRIED_DUTY, Limits, hurried
from surefoot.control.leg_demand import Pace
from surefoot.control.stair_gait import DUTY, OFFSETS, speed_in_step, stair_gait
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import ProblemError, unknown_name
from surefoot.robot import Robot
from surefoot.spatial import GRAVITY
from surefoot.stance.contact_schedule import ContactSchedule
from surefoot.stance.gait import Gait
from surefoot.stance.gait_library import PATTERNS, REFERENCE_LEG, GaitPattern, gait_names, named_gait
from surefoot.terrain import Terrain

AUTO = "auto"
"""Name of the choice by speed."""
WALKS_BELOW, HYSTERESIS = 0.12, 0.15
"""Speed up to which `auto` walks, as a share of sqrt(g h), and the share by which it must be passed."""
COMMANDS_KEPT = 3
"""Commands whose speeds a gait stays ready for."""
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
    limit
        Slows another command to what the schedule can do, and readies it for that command's speeds.
    """

    schedule: ContactSchedule
    command: VelocityCommand
    notes: list[str]
    shortest: float
    limit: Callable[[VelocityCommand], VelocityCommand]


class _Hurry:
    """How far a gait hurries at the speeds of the last commands that it was given."""

    def __init__(self, limits: Limits, command: VelocityCommand) -> None:
        self.limits = limits
        self._last = [limits.limit(command)]
        self.command, self.notes = self._last[0].command, self._last[0].notes
        self.most = float(self._last[0].hurry.max())

    def limit(self, command: VelocityCommand) -> VelocityCommand:
        """Return another command slowed to what is possible."""
        self._last = [self.limits.limit(command), *self._last[: COMMANDS_KEPT - 1]]
        return self._last[0].command

    def at(self, velocity: FloatArray) -> float:
        """Return how far the gait hurries at a (3,) velocity [m/s, m/s, rad/s]: 0 to 1."""
        size = self.limits.size_of(velocity)
        return max(limited.hurry_at(size) for limited in self._last)


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
        return Limits(self.robot, pace, self.height, adaptable, self.terrain, self.mu, least_duty)


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
        return Chosen(own, command, [], own.period, lambda other: other)
    stairs = _on_stairs(body, command, own) if gait == "trot" else None
    if stairs is not None:
        return stairs
    pattern = PATTERNS[feet][gait]
    pace, least = _pace(body, pattern), LEAST_DUTY.get(gait, HURRIED_DUTY)
    hurry = _Hurry(body.limits(pace, True, least), command)
    if (
        hurry.most == 0.0 and command.values.any() and not (body.terrain.learns and gait == "trot")
    ):  # one that begins at rest may be steered to any speed
        steady = body.limits(pace, False)
        return Chosen(own, hurry.command, hurry.notes, own.period, lambda other: steady.limit(other).command)

    def stride(velocity: FloatArray, now: str) -> Stride:
        steps = stair_gait(
            body.terrain, VelocityCommand.constant(*velocity.tolist()), body.height, own.period, feet
        )
        if gait == "trot" and steps is not None:
            return Stride(gait, Pace(steps.period, DUTY, body.clearance), np.array(OFFSETS), in_step=True)
        return Stride(gait, hurried(pace, hurry.at(velocity), least), np.array(pattern.offset))

    schedule = AdaptiveGait(gait, stride, stride(np.zeros(3), gait))
    quickest = hurried(pace, hurry.most, least)
    said = (
        f"at speed the {gait} hurries, so that joints keep to their limits: its cycle takes "
        f"{pace.period:.2f} to {quickest.period:.2f} s, "
        f"feet are down for {100.0 * pace.duty:.0f} to {100.0 * quickest.duty:.0f} % of it"
    )
    notes = [*hurry.notes, said] if hurry.most > 0.0 else hurry.notes
    return Chosen(schedule, hurry.command, notes, quickest.period, hurry.limit)


def _on_stairs(body: Body, command: VelocityCommand, own: Gait) -> Chosen | None:
    """Return the trot in step with stairs, None where a trot keeps to its own timing."""
    limited = body.limits(_pace(body, GaitPattern(0.4, DUTY, ())), False).limit(command)
    slowed, notes = _in_step(body, limited.command, own.period)
    gait = stair_gait(body.terrain, slowed, body.height, own.period, len(body.robot.feet))
    if gait is None:
        return None
    chosen = _fixed(body, slowed, gait)
    said = f"in step with the stairs the trot's cycle takes {gait.period:.2f} s, {own.period:.2f} s elsewhere"
    return replace(chosen, notes=[*limited.notes, *notes, *chosen.notes, said])


def _in_step(body: Body, command: VelocityCommand, period: float) -> tuple[VelocityCommand, list[str]]:
    """Return a command slowed to what suits the treads, and a note on it."""
    speed = float(abs(command.values[:, 0]).max(initial=0.0))
    most = speed_in_step(body.terrain, speed, body.height, period)
    if most >= speed * (1.0 - 1e-9):
        return command, []
    note = (
        f"slowed from {speed:.3g} to {most:.3g} m/s: in step with the stairs' treads that is the next speed"
    )
    return VelocityCommand(command.times, command.values * (most / speed)), [note]


def _fixed(body: Body, command: VelocityCommand, schedule: ContactSchedule) -> Chosen:
    """Return a given schedule as it is, and the command slowed to what it allows."""
    if schedule.feet != len(body.robot.feet):
        raise ProblemError(
            f"the gait is for {schedule.feet} feet, {body.robot.name} has {len(body.robot.feet)}"
        )
    period, pace = 0.0, _pace(body, GaitPattern(0.4, 0.55, ()))
    if schedule.period > 0.0:
        period, moving = schedule.period, schedule.duty < 1.0
        if not moving.any():
            return Chosen(schedule, command, [], period, lambda other: other)
        pace = Pace(period, float(schedule.duty[moving].min()), body.clearance)
    hurry = _Hurry(body.limits(pace, False), command)
    return Chosen(schedule, hurry.command, hurry.notes, period, hurry.limit)


def _pace(body: Body, pattern: GaitPattern) -> Pace:
    """Return a pattern's own pace at a robot's size."""
    return Pace(pattern.period * math.sqrt(body.height / REFERENCE_LEG), pattern.duty, body.clearance)


def _automatic(body: Body, command: VelocityCommand) -> Chosen:
    """Return the schedule that stands, walks and trots by speed."""
    patterns = PATTERNS[len(body.robot.feet)]
    trot, walk = _pace(body, patterns["trot"]), _pace(body, patterns["walk"])
    hurry = _Hurry(body.limits(trot, True), command)
    slow = WALKS_BELOW * math.sqrt(GRAVITY * body.height)
    trot_offset, walk_offset = np.array(patterns["trot"].offset), np.array(AUTO_WALK)

    def stride(velocity: FloatArray, now: str) -> Stride:
        size = hurry.limits.size_of(velocity)
        if size == 0.0:
            stands = (walk, walk_offset) if now == "walk" else (trot, trot_offset)
            return Stride(now, *stands, moving=False)
        edge = slow * (1.0 + HYSTERESIS if now == "walk" else 1.0 - HYSTERESIS)
        if size < edge:
            return Stride("walk", walk, walk_offset)
        return Stride("trot", hurried(trot, hurry.at(velocity)), trot_offset)

    schedule = AdaptiveGait(AUTO, stride, stride(hurry.command.at(0.0), "walk"))
    return Chosen(schedule, hurry.command, hurry.notes, hurried(trot, hurry.most).period, hurry.limit)
