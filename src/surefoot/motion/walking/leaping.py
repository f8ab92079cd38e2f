"""Leaps of a body that is caught, and how far it is from its plan."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.pace_settings import LEAPING
from surefoot.motion.walking.walk_state import GaitState
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet, FeetModel


def leap(
    gait: GaitState, feet: Feet, wanted: bool, model: FeetModel, schedule: ContactSchedule, clock: GaitClock,
    centres: FloatArray, unit: float,
) -> tuple[GaitState, Feet]:  # fmt: skip
    """Return gait and feet of a walk whose feet all leave the ground and meet it together, if that is wanted.

    A leap that is not wanted any more ends late in a stance.

    Parameters
    ----------
    gait, feet, clock
        Now.
    wanted
        Whether a recovery asks for leaps.
    model
        Of the feet.
    schedule
        The walk's own.
    centres
        (n, 3) where the feet are [m].
    unit
        sqrt(h / g) [s].
    """
    time = clock.time
    if gait.leap is not None:
        landed, begin, end = gait.leap.phase(0, time)
        if not wanted and landed and time > 0.5 * (begin + end):
            return gait._replace(leap=None), model.following(feet, schedule, time)
    elif wanted:
        period, air = (LEAPING.air_time + LEAPING.ground_time) * unit, LEAPING.air_time * unit
        begun = [(time + air) / period] * len(feet.foot)
        together = Gait.from_phases("leap", period, LEAPING.ground_time * unit / period, begun)
        return gait._replace(leap=together), model.leap(feet, clock, air, centres)
    return gait, feet


def unease(before: float, body: BodyPlan, now: Kinematics, height: float, elapsed: float) -> float:
    """Return how far a body is from its plan, from 0 to 1, `elapsed` [s] after it was `before`.

    `height` is that of the centre of mass [m].
    """
    error = now.com_velocity[:2] - body.flow()
    size = math.hypot(error[0], error[1]) / math.sqrt(GRAVITY * height)
    fresh = min(max((size - LEAPING.calm) / (LEAPING.uneasy - LEAPING.calm), 0.0), 1.0)
    return max(fresh, before - elapsed / LEAPING.unease_time)
