"""Limits of what a whole run came to: contact times, stands, walks, estimates and motors."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.loaded import DEBOUNCE
from surefoot.base.settings import Settings, setting
from surefoot.records.audit.limit_sources import VARIED


@dataclass(frozen=True)
class ContactTimeLimits(Settings):
    """Limits of touchdowns and lift-offs that are read from foot sensors, see `contact_times`."""

    debounce: float = setting(
        DEBOUNCE, "s", "shortest phase of a foot", low=0.0, tuned=VARIED + "0.03 to 0.03"
    )
    touchdown: float = setting(
        0.10,
        "-",
        "share of the way from a foot's offset to its peak at which it touches down",
        low=0.0,
        tuned=VARIED + "0.1 to 0.1",
    )
    lift_off: float = setting(
        0.06, "-", "share of that way at which the foot lifts off", low=0.0, tuned=VARIED + "0.06 to 180"
    )
    flat: float = setting(
        0.05,
        "-",
        "share of that way within which a reading is that of the air",
        low=0.0,
        tuned=VARIED + "0.05 to 0.05",
    )
    flat_share: float = setting(
        0.15,
        "-",
        "least share of rows with a reading of the air",
        low=0.0,
        high=1.0,
        tuned=VARIED + "0.15 to 0.15",
    )
    noise_ratio: float = setting(
        10.0, "-", "least ratio of a foot's peak to its noise", low=0.0, tuned=VARIED + "10 to 10"
    )
    longest: float = setting(
        2.0,
        "-",
        "longest stride over the median one; a longer one is a pause",
        low=1.0,
        tuned=VARIED + "2 to 2",
    )
    hole: float = setting(
        5.0, "dt", "step of the clock from which no stride crosses it", low=1.0, tuned=VARIED + "5 to 5"
    )


@dataclass(frozen=True)
class StandLimits(Settings):
    """Limits of a stand that is called one."""

    slip: float = setting(
        0.01,
        "m",
        "way over the ground from which a loaded foot has slipped",
        low=0.0,
        tuned=VARIED + "0.003333 to 0.03",
    )
    drift: float = setting(
        0.1,
        "height",
        "distance of the base from its place, at the end, of a displaced robot",
        low=0.0,
        tuned=VARIED + "0.03333 to 0.1",
    )
    tilt: float = setting(
        10.0, "deg", "turn of the base, at the end, of a displaced robot", low=0.0, tuned=VARIED + "10 to 10"
    )


@dataclass(frozen=True)
class WalkLimits(Settings):
    """Limits of a walk that followed its command."""

    settled: float = setting(
        2.0,
        "s",
        "time after which the velocity should be the commanded one",
        low=0.0,
        tuned=VARIED + "2 to 2",
    )
    tracking_share: float = setting(
        0.1, "-", "share of the command within which it is tracked", low=0.0, tuned=VARIED + "0.1 to 0.1"
    )
    tracking_floor: float = setting(
        0.03,
        "m/s, rad/s",
        "difference within which a small command is tracked",
        low=0.0,
        tuned=VARIED + "0.01 to 0.09",
    )
    followed_share: float = setting(
        0.5,
        "-",
        "share of the command that a robot may miss which walked as commanded",
        low=0.0,
        tuned=VARIED + "0.5 to 0.5",
    )
    followed_floor: float = setting(
        0.05,
        "m/s, rad/s",
        "difference that such a robot may miss of a small command",
        low=0.0,
        tuned=VARIED + "0.05 to 0.05",
    )


@dataclass(frozen=True)
class EstimateLimits(Settings):
    """Limits of what is said of an estimate."""

    shortest_way: float = setting(
        0.5, "m", "shortest way over which drift is given as a share", low=0.0, tuned=VARIED + "0.5 to 0.5"
    )
    last: float = setting(
        1.0,
        "s",
        "time at the end over which a load's estimate is averaged",
        low=0.0,
        tuned=VARIED + "0.3333 to 3",
    )
    light: float = setting(
        0.05,
        "mass",
        "payload below which its place is not told, over the robot's mass",
        low=0.0,
        tuned=VARIED + "0.01667 to 0.05",
    )


@dataclass(frozen=True)
class MotorLimits(Settings):
    """Limits of what is said of motors."""

    over_speed: float = setting(
        1.0 + 1e-3, "-", "use of a speed limit that exceeds it", low=0.0, tuned=VARIED + "1.001 to 1.003"
    )
    cut: float = setting(
        0.01,
        "-",
        "share of a torque limit by which a commanded torque is cut",
        low=0.0,
        tuned=VARIED + "0.003333 to 0.03",
    )
