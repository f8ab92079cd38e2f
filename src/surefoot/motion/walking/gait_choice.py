"""From a gait's name and a command to a schedule: timing by speed, and with `auto` the gait by speed too.

A gait by name keeps its own timing as long as the joints allow the commanded speeds; where they do not, it
becomes a schedule that hurries with the speed. `auto` stands at rest, walks slowly with three feet on the
ground, and trots from there on; hurried, the trot flies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from surefoot.base.arrays import FloatArray, of_kind
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.spatial import GRAVITY
from surefoot.motion.gaits.adaptive_gait import AdaptiveGait, Pace, Stride
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.gaits.library import REFERENCE_LEG, GaitPattern, named_gait, patterns_of
from surefoot.motion.walking.command_limits import LeggedBody, Limits
from surefoot.motion.walking.pace_settings import GAIT_CHOICE, SPEED_LIMITS, STAIR_GAIT
from surefoot.motion.walking.stair_gait import OFFSETS, speed_in_step, stair_gait
from surefoot.motion.walking.walking_body import VelocityCommand

AUTO = "auto"
"""Name of the choice by speed."""
AUTO_WALK = (-0.125, 0.375, 0.625, 0.125)
"""Offsets of a walk that are nearest to a trot's: no foot moves by more than an eighth between them."""
LEAST_DUTY = {
    "walk": GAIT_CHOICE.walk_least_duty, "pace": GAIT_CHOICE.pace_least_duty,
    "tripod": GAIT_CHOICE.tripod_least_duty, "ripple": GAIT_CHOICE.ripple_least_duty,
    "wave": GAIT_CHOICE.wave_least_duty,
}  # fmt: skip
"""A gait in the greatest hurry keeps its feet on the ground for this share; others for `hurried_duty`."""


@dataclass(frozen=True)
class GaitChoice:
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
    limits
        What slows another command to what the schedule can do, and readies it for that command's speeds; None
        for a schedule without steps.
    """

    schedule: ContactSchedule
    command: VelocityCommand
    notes: list[str]
    shortest: float
    limits: Limits | None


def choose_gait(body: LeggedBody, command: VelocityCommand, gait: str | ContactSchedule) -> GaitChoice:
    """Return schedule and command for a gait, by name or as a schedule.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    if not isinstance(gait, str):
        of_kind("gait", gait, ContactSchedule)
        return _fixed(body, command, gait)
    feet = len(body.robot.feet)
    places = body.robot.foot_positions(body.robot.nominal)[:, :2]
    patterns = patterns_of(feet, places)
    if gait == AUTO and feet != len(AUTO_WALK):
        raise ProblemError(f"gait {AUTO!r} is for {len(AUTO_WALK)} feet, {body.robot.name} has {feet}")
    if gait != AUTO and patterns and gait not in patterns:
        auto = (AUTO,) if feet == len(AUTO_WALK) else ()
        raise ProblemError(unknown_name(f"gait for {feet} feet", gait, (*patterns, *auto)))
    if gait == AUTO:
        return _automatic(body, command)
    own = named_gait(gait, feet, body.height, places=places)
    if own.swing_time == 0.0:
        return GaitChoice(own, command, [], own.period, None)
    stairs = _on_stairs(body, command, own) if gait == "trot" else None
    if stairs is not None:
        return stairs
    pattern = patterns[gait]
    pace = _pace(body, pattern)
    limits = Limits(body, pace, True, LEAST_DUTY.get(gait, SPEED_LIMITS.hurried_duty))
    limited = limits.limit(command)
    most = float(limited.hurry.max())
    if (
        most == 0.0 and command.values.any() and not (body.terrain.learns and gait == "trot")
    ):  # one that begins at rest may be steered to any speed
        steady = Limits(body, pace, False)
        return GaitChoice(own, limited.command, limited.notes, own.period, steady)

    def stride(velocity: FloatArray, now: str) -> Stride:
        steps = stair_gait(
            body.terrain, VelocityCommand.constant(*velocity.tolist()), body.height, own.period, feet
        )
        if gait == "trot" and steps is not None:
            return Stride(
                gait, Pace(steps.period, STAIR_GAIT.duty, body.clearance), np.array(OFFSETS), in_step=True
            )
        return Stride(gait, limits.pace_at(velocity), np.array(pattern.offset))

    schedule = AdaptiveGait(gait, stride, stride(np.zeros(3), gait))
    quickest = limits.hurried(most)
    said = (
        f"at speed the {gait} hurries, to keep joints within their limits and to spend less: its cycle takes "
        f"{pace.period:.2f} to {quickest.period:.2f} s, "
        f"feet are down for {100.0 * pace.duty:.0f} to {100.0 * quickest.duty:.0f} % of it"
    )
    notes = [*limited.notes, said] if most > 0.0 else limited.notes
    return GaitChoice(schedule, limited.command, notes, quickest.period, limits)


def _on_stairs(body: LeggedBody, command: VelocityCommand, own: Gait) -> GaitChoice | None:
    """Return the trot in step with stairs, None where a trot keeps to its own timing."""
    limited = Limits(body, _pace(body, GaitPattern(0.4, STAIR_GAIT.duty, ())), False).limit(command)
    slowed, notes = _in_step(body, limited.command, own.period)
    gait = stair_gait(body.terrain, slowed, body.height, own.period, len(body.robot.feet))
    if gait is None:
        return None
    chosen = _fixed(body, slowed, gait)
    said = f"in step with the stairs the trot's cycle takes {gait.period:.2f} s, {own.period:.2f} s elsewhere"
    return replace(chosen, notes=[*limited.notes, *notes, *chosen.notes, said])


def _in_step(body: LeggedBody, command: VelocityCommand, period: float) -> tuple[VelocityCommand, list[str]]:
    """Return a command slowed to what suits the treads, and a note on it."""
    speed = float(abs(command.values[:, 0]).max(initial=0.0))
    most = speed_in_step(body.terrain, speed, body.height, period)
    if most >= speed * (1.0 - 1e-9):
        return command, []
    note = (
        f"slowed from {speed:.3g} to {most:.3g} m/s: in step with the stairs' treads that is the next speed"
    )
    return replace(command, values=command.values * (most / speed)), [note]


def _fixed(body: LeggedBody, command: VelocityCommand, schedule: ContactSchedule) -> GaitChoice:
    """Return a given schedule as it is, and the command slowed to what it allows."""
    if schedule.feet != len(body.robot.feet):
        raise ProblemError(
            f"the gait is for {schedule.feet} feet, {body.robot.name} has {len(body.robot.feet)}"
        )
    period, pace = 0.0, _pace(body, GaitPattern(0.4, 0.55, ()))
    if schedule.period > 0.0:
        period, moving = schedule.period, schedule.duty < 1.0
        if not moving.any():
            return GaitChoice(schedule, command, [], period, None)
        pace = Pace(period, float(schedule.duty[moving].min()), body.clearance)
    limits = Limits(body, pace, False)
    limited = limits.limit(command)
    return GaitChoice(schedule, limited.command, limited.notes, period, limits)


def _pace(body: LeggedBody, pattern: GaitPattern) -> Pace:
    """Return a pattern's own pace at a robot's size."""
    return Pace(pattern.period * math.sqrt(body.height / REFERENCE_LEG), pattern.duty, body.clearance)


def _automatic(body: LeggedBody, command: VelocityCommand) -> GaitChoice:
    """Return the schedule that stands, walks and trots by speed."""
    patterns = patterns_of(len(body.robot.feet))
    trot, walk = _pace(body, patterns["trot"]), _pace(body, patterns["walk"])
    limits = Limits(body, trot, True)
    limited = limits.limit(command)
    slow = GAIT_CHOICE.walks_below * math.sqrt(GRAVITY * body.height)
    trot_offset, walk_offset = np.array(patterns["trot"].offset), np.array(AUTO_WALK)

    def stride(velocity: FloatArray, now: str) -> Stride:
        size = limits.size_of(velocity)
        if size == 0.0:
            stands = (walk, walk_offset) if now == "walk" else (trot, trot_offset)
            return Stride(now, *stands, moving=False)
        edge = slow * (1.0 + GAIT_CHOICE.hysteresis if now == "walk" else 1.0 - GAIT_CHOICE.hysteresis)
        if size < edge:
            return Stride("walk", walk, walk_offset)
        return Stride("trot", limits.pace_at(velocity), trot_offset)

    schedule = AdaptiveGait(AUTO, stride, stride(limited.command.at(0.0), "walk"))
    shortest = limits.hurried(float(limited.hurry.max())).period
    return GaitChoice(schedule, limited.command, limited.notes, shortest, limits)
