"""Leaps of a body that is caught, and how far it is from its plan."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walk_state import GaitState
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet, FeetModel

LEAP, LAND = 0.5, 0.44
"""Times in the air and on the ground of a body that leaps, in units of sqrt(h / g)."""
CALM, UNEASY, UNEASE_TIME = 0.06, 0.15, 1.0
"""Up to the first error of its velocity, as a share of sqrt(g h), a body moves as planned; from the second on
feet are lifted in full, and ever less for so long after it [s]."""


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
        period, air = (LEAP + LAND) * unit, LEAP * unit
        begun = [(time + air) / period] * len(feet.foot)
        together = Gait.from_phases("leap", period, LAND * unit / period, begun)
        return gait._replace(leap=together), model.leap(feet, clock, air, centres)
    return gait, feet


def unease(before: float, body: BodyPlan, now: Kinematics, height: float, elapsed: float) -> float:
    """Return how far a body is from its plan, from 0 to 1, `elapsed` [s] after it was `before`.

    `height` is that of the centre of mass [m].
    """
    error = now.com_velocity[:2] - body.flow()
    size = math.hypot(error[0], error[1]) / math.sqrt(GRAVITY * height)
    fresh = min(max((size - CALM) / (UNEASY - CALM), 0.0), 1.0)
    return max(fresh, before - elapsed / UNEASE_TIME)
