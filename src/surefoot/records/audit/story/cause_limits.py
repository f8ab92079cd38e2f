"""Limits within the rules of a story: how each cause is told from what looks like it."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import MADE, RULES


@dataclass(frozen=True)
class CauseLimits(Settings):
    """Limits of single rules, by the file of rules that reads them."""

    longest_lag: float = setting(
        0.07, "s", "longest delay that is tried", low=0.0, tuned=RULES + "0.04667 to 0.14"
    )
    still_led: float = setting(
        0.25,
        "s",
        "time for which a robot that falls is still controlled",
        low=0.0,
        tuned=RULES + "0.1667 to 0.375",
    )
    left_open: float = setting(
        0.5,
        "-",
        "share of the torques' changes that a delay may leave open",
        low=0.0,
        tuned=RULES + "0.03125 to 32",
    )
    far_better: float = setting(
        4.0,
        "lag_better",
        "what a delay explains that leaves more open",
        low=0.0,
        tuned=RULES + "0.0625 to 256",
    )
    held_flips: float = setting(
        0.95,
        "-",
        "share of rows in which a held torque turns in chatter: by chance two of three do",
        low=0.0,
        tuned=MADE + "0.85 to 0.95",
    )
    least_ticks: int = setting(20, "-", "torques that are looked at for that", low=1, tuned=MADE + "12 to 40")
    caught: float = setting(
        0.5,
        "s",
        "time for which the capture point of a robot that survived a push stays within its feet",
        low=0.0,
        tuned=MADE + "0 to 0.5",
    )
    tips_on_two: float = setting(
        1.6,
        "sqrt(h/g)",
        "time on two feet of four in which a body tips over",
        low=0.0,
        tuned=RULES + "1.6 to 2.4",
    )
    tips_on_one: float = setting(
        1.05,
        "sqrt(h/g)",
        "time on its only foot in which a body tips over",
        low=0.0,
        tuned=RULES + "1.001 to 1.2",
    )
    landings: int = setting(
        2, "-", "landings of a foot from which it is known where it belongs", low=2, tuned=RULES + "2 to 3"
    )
    beside: float = setting(
        0.1,
        "h",
        "way of a landing beside that, from which it is amiss",
        low=0.0,
        tuned=RULES + "0.06667 to 0.1",
    )
    follows: float = setting(
        0.1, "s", "what a change of velocity moves a foothold by", low=0.0, tuned=MADE + "0.1 to 0.12"
    )
    later: float = setting(
        1.2,
        "-",
        "time of a swing over the longest before, from which it is late",
        low=0.0,
        tuned=RULES + "1.2 to 1.2",
    )
    jumps: float = setting(
        4.0,
        "-",
        "jump of a torque asked for over all before, which no motion explains",
        low=0.0,
        tuned=RULES + "2 to 64",
    )
    with_it: float = setting(
        0.2,
        "-",
        "share of a jump from which another torque's of that moment belongs to it",
        low=0.0,
        tuned=MADE + "0 to 0.2",
    )
    known_after: float = setting(
        0.2, "s", "time from which it is known how torques change", low=0.0, tuned=RULES + "0.003125 to 0.4"
    )
    off_feet: float = setting(
        0.1,
        "-",
        "way of a centre of mass at rest outside of the feet, over its height, of a body started as another",
        low=0.0,
    )
    at_rest: float = setting(
        0.15,
        "s",
        "first moments of a run, in which a controller for another body shows itself",
        low=0.0,
        tuned=RULES + "0.15 to 0.15",
    )
    few_driven: int = setting(
        3,
        "-",
        "driven joints of which all but one at rest say something of that one in the air, too",
        low=1,
        tuned=RULES + "1 to 3",
    )
    started_on: float = setting(
        0.03,
        "s",
        "time within which something carries a robot that was started at rest",
        low=0.0,
        tuned=MADE + "0 to 0.03",
    )
    stood: float = setting(
        0.3,
        "s",
        "time for which a body that is led out of its feet has stood first",
        low=0.0,
        tuned=RULES + "0.004687 to 0.6",
    )
    drift_begun: float = setting(
        0.08,
        "-",
        "share of what a drift comes to from which it has begun",
        low=0.0,
        tuned=RULES + "0.00125 to 0.32",
    )
    jump_strength: float = setting(
        0.7, "-", "strength of a torque that nothing explains", low=0.0, tuned=RULES + "0.35 to 44.8"
    )
    drift_strength: float = setting(
        0.2, "-", "strength of a drift to one side", low=0.0, tuned=RULES + "0.003125 to 0.4"
    )
    own_part: float = setting(
        0.25,
        "-",
        "share of that way that the contact's place goes, from which the robot went to it",
        low=0.0,
        tuned=MADE + "0 to 0.5",
    )
    near_base: float = setting(
        0.2,
        "-",
        "distance from a bolted base, over the robot's reach, of what belongs to it",
        low=0.0,
        tuned=RULES + "0.1 to 12.8",
    )
