"""Settings of a walk on two flat feet beside `BipedSettings`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class CatchingSettings(Settings):
    """Steps that catch a pushed biped."""

    begin_miss: float = setting(
        0.04, "h", "miss of the divergent motion from which a body is caught", low=0.0
    )
    end_miss: float = setting(0.025, "h", "miss below which a plan counts as calm", low=0.0)
    calm_plans: int = setting(10, "-", "calm plans after which a body is not caught any more", low=1)
    spared: float = setting(0.02, "m", "miss that steps may leave to the pressure in a sole", low=0.0)
    hurry_cost: float = setting(
        0.01, "m", "what a pace above 1 has to take off the miss, per unit, to be worth it", low=0.0
    )


CATCHING = CatchingSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class BipedWalkSettings(Settings):
    """Gait, reach and load of a walk on two flat feet."""

    turn_from: float = setting(
        0.1, "-", "share of its swing before which a foot does not turn: it lifts first", low=0.0, high=1.0
    )
    turn_until: float = setting(
        0.9, "-", "share of its swing after which a foot does not turn any more", low=0.0, high=1.0
    )
    descent: float = setting(0.06, "sqrt(g h)", "speed of a sole towards the ground at touchdown", low=0.0)
    reach: float = setting(
        0.194,
        "h",
        "farthest either side of its middle that a flat foot goes in a stance: with more its heel would rise",
        low=0.0,
    )
    heavy_legs: float = setting(
        0.6,
        "-",
        "largest share of the mass in the legs: steps are planned for a body on light ones",
        low=0.0,
        high=1.0,
    )
    heavy_rotors: float = setting(
        1.0,
        "-",
        "largest apparent mass of a sole, rotors included, in masses of the robot",
        low=0.0,
        tuned="`surefoot bench robots --published FOLDER`, 2026-11-27: 0.01 to 0.2 walk, OP3 with 5 falls",
    )
    light_sole: float = setting(
        800.0,
        "g / m",
        "turn of a sole under half the weight at its edge, about both axes, from which its damping is slowed",
        low=0.0,
        tuned="`surefoot bench robots --published FOLDER`, 2026-11-27: up to 620 they walk with all of it, "
        "XBot-L with 1500 falls",
    )
    period: float = setting(2.0 * math.pi / 1.96, "sqrt(h / g)", "length of a cycle of the gait", low=0.001)
    catch_until: float = setting(
        0.93,
        "-",
        "share of its swing up to which a foot that catches the body is sent elsewhere",
        low=0.0,
        high=1.0,
    )
    catch_time: float = setting(0.06, "s", "least time in which such a foot gets there", low=0.0)
    laden: float = setting(
        0.05,
        "m",
        "share of the robot's mass from which it carries a load: documents are off by less",
        low=0.0,
    )
    noticed_time: float = setting(0.1, "s", "time constant with which a load is noticed", low=1e-06)


BIPED_WALK = BipedWalkSettings()
"""The values in use; compiled code folds them when it is compiled."""
