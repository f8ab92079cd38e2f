"""Limits of what channels of one motion may differ by: momentum, centre of mass, places of contacts."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import RIVALS


@dataclass(frozen=True)
class ConsistencyLimits(Settings):
    """Limits beside what a row's length and its forces allow, see `consistency` and `places`."""

    impulse: float = setting(
        0.01,
        "-",
        "share of the impulses of forces and weight by which momentum may be beside its rate",
        low=0.0,
        tuned=RIVALS + "0.01 to 0.03",
    )
    way: float = setting(
        2e-4,
        "m",
        "way by which the centre of mass may be beside its momentum",
        low=0.0,
        tuned=RIVALS + "0.0002 to 0.0002",
    )
    drift: float = setting(
        0.02, "-", "share of its way by which it may be", low=0.0, tuned=RIVALS + "0.02 to 0.06"
    )
    time: float = setting(
        0.05,
        "s",
        "time over which the way of the centre of mass, and its acceleration, are compared",
        low=0.0,
        tuned=RIVALS + "0.05 to 150",
    )
    press: float = setting(
        1e-3,
        "m",
        "way by which forces may press beside the contact points",
        low=0.0,
        tuned=RIVALS + "0.0003333 to 0.003",
    )
    place: float = setting(
        2e-3,
        "m",
        "way by which contact points may be beside their gaps",
        low=0.0,
        tuned=RIVALS + "0.002 to 0.002",
    )
    jump: float = setting(
        5e-3,
        "m",
        "way by which a contact point may jump in a row",
        low=0.0,
        tuned=RIVALS + "0.005 to 0.005",
    )
    anew: float = setting(
        0.02,
        "m",
        "jump of a recorded contact point from which it is another one",
        low=0.0,
        tuned=RIVALS + "6.667e-06 to 0.06",
    )
    shown: float = setting(
        0.8,
        "-",
        "share of the rows that must show the same plane for the ground to be known",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0.0002667 to 0.8",
    )
