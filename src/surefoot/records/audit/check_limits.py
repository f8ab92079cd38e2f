"""Limits of the measures that audits take of every row, and of what becomes of them."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.loaded import CARRIES
from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import RIVALS, VARIED


@dataclass(frozen=True)
class CheckLimits(Settings):
    """Limits of the measures that are taken of every row."""

    slide_window: float = setting(
        0.05, "s", "time over which friction's work is added up", low=1e-6, tuned=VARIED + "0.01667 to 0.05"
    )
    drive_share: float = setting(
        0.05,
        "-",
        "share of the friction's largest work that it may give by turning late",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.001667 to 0.15",
    )
    brake_share: float = setting(
        0.9,
        "-",
        "share of the friction's largest work that a slide has to be braked by",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.7 to 0.9967",
    )
    chatter_window: float = setting(
        0.1, "s", "time over which contact switches are counted", low=1e-6, tuned=VARIED + "0.1 to 0.1"
    )
    chatter_switches: float = setting(
        8.0,
        "-",
        "switches between loaded and unloaded in that time that are chatter",
        low=1.0,
        tuned=VARIED + "8 to 8",
    )
    ringing: float = setting(
        0.15,
        "m g",
        "mean jump of a normal force back and forth, row by row, that is chatter",
        low=1e-9,
        tuned=VARIED + "0.05 to 4.5",
    )
    spike: float = setting(
        1.5,
        "m g",
        "excess of one or two rows' force over the rows on both sides that is a blow",
        low=0.0,
        tuned=VARIED + "0.5 to 4.5",
    )
    idle_time: float = setting(
        0.1,
        "s",
        "time without any force from which nothing carries a robot",
        low=0.0,
        tuned=VARIED + "0.003333 to 0.1",
    )
    idle_share: float = setting(
        0.95, "-", "share of that time without any force", low=0.0, high=1.0, tuned=VARIED + "0 to 0.9833"
    )
    idle_gap: float = setting(
        1e-4,
        "m",
        "gap up to which a foot touches the ground while idle",
        low=0.0,
        tuned=VARIED + "0.0001 to 0.003",
    )
    idle_force: float = setting(
        0.3,
        "m g",
        "force missing from the motion that shows that the robot does not fall",
        low=0.0,
        tuned=VARIED + "0.0001 to 0.9",
    )
    frozen_time: float = setting(
        0.03,
        "s",
        "time in which a measured force changes by rounding at least",
        low=0.0,
        tuned=VARIED + "0.03 to 0.09",
    )
    frozen_share: float = setting(
        0.95,
        "-",
        "share of that time without any change that is frozen",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.85 to 1",
    )
    frozen_rows: int = setting(
        8, "-", "rows in that time up to which nothing is called frozen", low=0, tuned=VARIED + "0 to 12"
    )
    lean_time: float = setting(
        0.1, "s", "time over which loads of the diagonals are compared", low=0.0, tuned=VARIED + "0.1 to 3"
    )
    lean: float = setting(
        0.25,
        "m g",
        "load of one diagonal of feet beyond the other's that is asymmetry",
        low=0.0,
        tuned=VARIED + "0.08333 to 0.25",
    )


@dataclass(frozen=True)
class BalanceLimits(Settings):
    """Limits of the force and moment that the motion leaves unexplained."""

    smooth: float = setting(
        0.01,
        "s",
        "time over which forces are compared with the motion",
        low=0.0,
        tuned=VARIED + "0.003333 to 0.01",
    )
    ringing_time: float = setting(
        0.05,
        "s",
        "time of the root mean square of what is left over",
        low=0.0,
        tuned=VARIED + "0.001667 to 0.05",
    )
    force: float = setting(
        0.05, "m g", "mean force that may be left over", low=1e-9, tuned=VARIED + "0.001667 to 0.05"
    )
    ringing: float = setting(
        0.1,
        "m g",
        "root mean square of the force that may be left over",
        low=1e-9,
        tuned=VARIED + "0.003333 to 300",
    )
    arm: float = setting(
        0.02,
        "m",
        "arm of m g that makes the moment which may be left over",
        low=1e-9,
        tuned=VARIED + "0.006667 to 0.6",
    )


@dataclass(frozen=True)
class ContinuityLimits(Settings):
    """Limits of the difference between positions and what velocities lead to."""

    time: float = setting(
        0.05,
        "s",
        "time over which steps of positions are added up",
        low=0.0,
        tuned=VARIED + "0.01667 to 0.05",
    )
    smooth: float = setting(
        0.01,
        "s",
        "time over which contact velocities are averaged",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    way: float = setting(
        2e-3,
        "m",
        "way by which positions may be beside their velocities",
        low=1e-9,
        tuned=VARIED + "6.667e-05 to 0.002",
    )
    lever: float = setting(
        0.1, "m/rad", "lever that makes an angle a way", low=1e-9, tuned=VARIED + "0.1 to 3"
    )
    drift: float = setting(
        0.05,
        "-",
        "share of the way gone by which positions may be beside velocities",
        low=0.0,
        tuned=VARIED + "1.667e-05 to 0.05",
    )
    gap_time: float = setting(
        0.02, "s", "time over which steps of gaps are added up", low=0.0, tuned=VARIED + "0.0006667 to 0.06"
    )
    gap: float = setting(
        5e-3,
        "m",
        "way by which gaps may be beside velocities: contacts wander over a round foot",
        low=0.0,
        tuned=VARIED + "1.667e-05 to 15",
    )
    velocity: float = setting(
        0.05,
        "m/s",
        "difference of a contact's velocity from that of the joints",
        low=0.0,
        tuned=RIVALS + "0.0001667 to 1.5",
    )
    velocity_share: float = setting(
        0.05, "-", "the difference as a share of the speed", low=0.0, tuned=RIVALS + "0.01667 to 0.15"
    )


@dataclass(frozen=True)
class ReboundLimits(Settings):
    """Limits of the energy that a touch gives back beyond what it took."""

    way: float = setting(
        5e-5,
        "m",
        "way on which m g does the work that a touch may return (clean walks: a seventh)",
        low=0.0,
        tuned=RIVALS + "5e-05 to 0.00015",
    )
    share: float = setting(
        0.03,
        "-",
        "share of the energy taken that a touch may return: restitution 1.015",
        low=0.0,
        tuned=VARIED + "0.01 to 0.03",
    )
    return_time: float = setting(
        0.01,
        "s",
        "time within which the rows at fault give back a part of the limit",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.03",
    )
    return_share: float = setting(
        0.5, "-", "that part of the limit", low=0.0, high=1.0, tuned=VARIED + "0.1667 to 1"
    )
    longest_row: float = setting(
        5e-3,
        "s",
        "step from row to row beyond which a touch is over between two",
        low=0.0,
        tuned=VARIED + "0.001667 to 15",
    )
    flight_rows: int = setting(4, "-", "rows of free fall that are a flight", low=3, tuned=RIVALS + "3 to 8")
    free_fall: float = setting(
        0.05,
        "g",
        "acceleration beside g of a contact point that falls freely",
        low=0.0,
        tuned=RIVALS + "0.05 to 150",
    )


@dataclass(frozen=True)
class FrictionLimits(Settings):
    """Limits of what a log tells of the ground's friction, see `friction`."""

    enough: float = setting(
        CARRIES,
        "m g",
        "normal force from which a foot's force tells of friction",
        low=0.0,
        tuned=VARIED + "0.006667 to 0.06",
    )
    least_slide: float = setting(
        0.02,
        "s",
        "shortest slide that bounds friction from above; half of it is cut off at each end",
        low=0.0,
        tuned=VARIED + "6.667e-06 to 0.02",
    )
    bins: int = setting(
        2000, "-", "bins in which friction is counted", low=10, tuned=VARIED + "666.7 to 6e+06"
    )
    top: float = setting(4.0, "-", "friction of the last bin", low=0.1, tuned=VARIED + "1.333 to 12")
    share: float = setting(
        0.995,
        "-",
        "share of rows that use no more than the lower bound",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.985 to 0.9983",
    )
    window: float = setting(
        0.1,
        "s",
        "time in which the ground is taken to be the same",
        low=1e-6,
        tuned=VARIED + "0.03333 to 0.3",
    )
    change: float = setting(
        0.15,
        "-",
        "share by which one bound must be beyond the other for a change of ground",
        low=0.0,
        tuned=VARIED + "0.05 to 0.45",
    )
    least_time: float = setting(
        0.01,
        "s",
        "time of friction used that contradicts slides",
        low=0.0,
        tuned=VARIED + "3.333e-06 to 0.03",
    )


@dataclass(frozen=True)
class CommandLimits(Settings):
    """Limits of what the controller asked for and what came of it."""

    window: float = setting(
        0.05, "s", "time over which the command is judged", low=1e-6, tuned=VARIED + "0.05 to 0.15"
    )
    at_once: float = setting(
        0.025,
        "s",
        "time without a foot that pushes, longer than a lift-off or a late touchdown",
        low=0.0,
        tuned=VARIED + "0.025 to 0.075",
    )
    nearly_all: float = setting(
        0.9,
        "-",
        "share of the window in which a command is impossible",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.7 to 0.9667",
    )
    touching: float = setting(
        1e-3,
        "m",
        "gap up to which a foot touches that is asked for nothing",
        low=0.0,
        tuned=VARIED + "0.0003333 to 0.003",
    )
    mismatch: float = setting(
        0.06,
        "m g",
        "mean force beside the commanded one (clean walks: 0.015 measured, 0.005 by torques)",
        low=0.0,
        tuned=VARIED + "0.02 to 0.06",
    )
    torque_mismatch: float = setting(
        0.05,
        "-",
        "mean difference of applied and commanded torques over the largest commanded",
        low=0.0,
        tuned=VARIED + "0.05 to 0.15",
    )
    explained: float = setting(
        0.8,
        "-",
        "share of a mismatch that a turn or a mirror must explain to be named",
        low=0.0,
        high=1.0,
        tuned=RIVALS + "0 to 0.9667",
    )
    least_turn: float = setting(
        3.0, "deg", "turn of commanded forces that is named", low=0.0, tuned=VARIED + "0.001 to 90"
    )
    leans: float = setting(
        60.0, "deg", "lean of the base at the end from which a robot fell", low=0.0, tuned=VARIED + "60 to 60"
    )
    low: float = setting(
        0.4,
        "-",
        "height at the end, as a share of the first, below which a robot fell",
        low=0.0,
        tuned=VARIED + "0.4 to 0.4",
    )
