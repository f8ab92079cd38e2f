"""Two numbers for a law in a situation: a spring and a damper, or Hunt and Crossley's; and what is lost."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.spatial import GRAVITY
from surefoot.contact.laws.soft.behaviour import rebound
from surefoot.contact.laws.soft.hunt_crossley import HuntCrossley
from surefoot.contact.laws.soft.soft_law import SoftLaw


@dataclass(frozen=True)
class Situation:
    """The situation in which a translation is asked.

    Attributes
    ----------
    mass
        Effective mass of the contact, 1 / G_nn [kg]: of a robot on four feet about a quarter of its own.
    gravity
        [m/s²].
    speed
        Impact speed at which bounces are compared [m/s].
    dt
        The engine's step [s].
    keep
        What is kept where rest depth and motion cannot both be: "motion" or "rest".
    impedance
        MuJoCo's d of the translated contact.
    """

    mass: float
    gravity: float = GRAVITY
    speed: float = 1.0
    dt: float = 1e-3
    keep: str = "motion"
    impedance: float = 1e-3

    @property
    def weight(self) -> float:
        """Return what the contact carries at rest [N]."""
        return self.mass * self.gravity


STICKIEST = 20.0
"""Largest dissipation times impact speed that is looked for: 5 % of the speed comes back."""


def linear(law: SoftLaw, situation: Situation) -> tuple[float, float, list[str]]:
    """Return the spring [N/m] and the damper [N s/m] of a law about rest, and what they lose."""
    depth = np.array(law.rest_depth(situation.weight))
    force, by_depth, by_rate = law.pressed(depth, np.array(0.0))
    tangent, secant, damping = float(by_depth), float(force / depth), float(by_rate)
    straight = abs(tangent - secant) <= 1e-12 * tangent
    if straight and float(law.pressed(2.0 * depth, np.array(0.0))[2]) == damping:
        return tangent, damping, []
    lost = [
        f"valid for small motions about rest at {1e3 * float(depth):.4g} mm: the law itself is not linear"
    ]
    if not straight:
        which = "rest depth" if situation.keep == "motion" else "frequency and settling"
        lost.append(
            f"{which}: the slope at rest is {tangent:.6g} N/m, load over depth {secant:.6g} N/m; "
            f"kept: {situation.keep}"
        )
    return (tangent if situation.keep == "motion" else secant), damping, lost


def implicit_linear(law: SoftLaw, situation: Situation) -> tuple[float, float, list[str]]:
    """Return spring and damper for an engine whose implicit step adds damping of its own, and what is lost.

    An implicit step of dt takes the overlap at its end, -k (x + dt v) - d v: damping d + k dt. So the law's
    damping is asked for less k dt, as far as there is that much.
    """
    stiffness, damping, lost = linear(law, situation)
    return stiffness, max(damping - situation.dt * stiffness, 0.0), lost


def hunt_crossley(law: SoftLaw, situation: Situation) -> tuple[float, float, list[str]]:
    """Return stiffness [N/m] and dissipation [s/m] that bounce alike at one speed, and what is lost."""
    from scipy.optimize import brentq

    own = law.words("hunt-crossley")
    if own is not None:
        return own["stiffness"], own["dissipation"], []
    stiffness, _, lost = linear(law, situation)
    wanted = rebound(law, situation.mass, situation.speed, situation.gravity)

    def miss(logarithm: float) -> float:
        tried = HuntCrossley(stiffness, math.exp(logarithm) / situation.speed)
        return rebound(tried, situation.mass, situation.speed, situation.gravity) - wanted

    if wanted >= 1.0 - 1e-7:
        dissipation = 0.0
    elif miss(math.log(STICKIEST)) >= 0.0:
        dissipation = STICKIEST / situation.speed
    else:  # the closed form without weight bounces more, so it needs no less than this
        low = high = math.log(HuntCrossley.bouncing(stiffness, max(wanted, 1e-3), 1.0).dissipation)
        # a bracket in the logarithm of the dissipation, from which restitution falls
        while miss(low) < 0.0:
            low -= 0.5
        while miss(high) > 0.0:
            high += 0.5
        found = brentq(miss, low, high, xtol=1e-9) if low < high else low
        dissipation = math.exp(found) / situation.speed
    lost.append(
        f"restitution is that of the law at {situation.speed:g} m/s only: this one bounces more "
        "at lower speeds"
    )
    lost.append(
        f"damping at rest is load times dissipation, {situation.weight * dissipation:.4g} N s/m, "
        "whatever the law's was"
    )
    return stiffness, dissipation, lost
