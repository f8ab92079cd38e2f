"""Runs of a Go2 in the rigid world whose sensors have two faults at once, or a fault and their noise."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy

import numpy as np

from benchmarks.limit_cases.made import arrays_of, changed_log
from benchmarks.limit_cases.verdict import SLOPE, STAND, TROT, CleanLogs, Verdict, breaks, keeps, named
from surefoot.base.spatial import GRAVITY, rotation_about
from surefoot.mechanics import Robot, load_robot
from surefoot.records.audit.fault_injection import LogCopy
from surefoot.records.audit.seeded_faults import shift_support
from surefoot.records.log import Log

AT_PIN = 5e-3
"""Play of a joint's gear, within which a pin may push back: 0.3 degrees [rad]."""


def measured_cases(logs: CleanLogs) -> Iterator[Verdict]:
    """Yield the cases of sensors."""
    trot, stand, slope = logs(TROT), logs(STAND), logs(SLOPE)
    yield _off_zero(trot)
    yield from _clipped(trot, slope)
    yield from _velocities(trot)
    yield from _stops(trot)
    yield _bounced(stand)
    yield _overloaded(stand)


def _off_zero(trot: Log) -> Verdict:
    """Return forces that are reversed, and off zero."""
    weight = float(trot.fact("mass")) * GRAVITY
    reverse = arrays_of(trot)
    reverse["forces"] *= -1.0
    reverse["forces"][..., 2] += 0.1 * weight
    why = "the force on the ground, by cells whose zero is off by a foot's and a shank's weight: 15 N"
    return named("reversed, and off zero", why, changed_log(trot, reverse), "reversed")


def _clipped(trot: Log, slope: Log) -> Iterator[Verdict]:
    """Yield sensors at the end of their range."""
    weight = float(trot.fact("mass")) * GRAVITY
    ends = arrays_of(slope)
    load = float(np.median(ends["forces"][:, 0, 2]))
    ends["forces"][:, 0, 2] = np.minimum(ends["forces"][:, 0, 2], 0.3 * load)
    why = "a cell of 1 kgf along the normal, which a foot on a slope of 15 degrees loads three times over"
    yield named("the normal channel at its end", why, changed_log(slope, ends), "clipped")
    noisy = arrays_of(trot)
    noisy["forces"][..., 2] = np.minimum(noisy["forces"][..., 2], 0.3 * weight)
    step = 2.0 * 45.0 / 4096.0
    noisy["torques"] = step * np.round(noisy["torques"] / step)
    why = "torques from currents of 12 bits in a range of +-45 N m: steps of 0.022 N m, 0.1 N on a shank"
    yield named("cells at their end, torques in steps", why, changed_log(trot, noisy), "clipped")


def _velocities(trot: Log) -> Iterator[Verdict]:
    """Yield velocities of the contacts that are not those of the joints."""
    for factor, law, why in (
        (1.03, keeps, "by a model whose links are 3 % long"),
        (0.0, breaks, "velocities of feet that were never written"),
    ):
        arrays = arrays_of(trot)
        arrays["contact_velocities"] *= factor
        log = changed_log(trot, arrays)
        yield law(f"contact velocities times {factor:g}", why, log, "contact velocity")


def _stops(trot: Log) -> Iterator[Verdict]:
    """Yield knees at a pin that ends their range, which is a part of no log."""
    knee, q = 2, trot["q"][:, 9]
    pressed, folded = arrays_of(trot), float(np.min(q))
    pressed["torques"][q < folded + AT_PIN, knee] -= 10.0
    why = "a pin where the swing folds the knee most: the motor of 45 N m presses on it with 10"
    log = changed_log(trot, pressed)
    yield named("a knee that knocks at a pin", why, log, "joint stop", _pinned(low=folded))
    silent, part = arrays_of(trot), slice(780, 937)
    silent["forces"][part, 0] = 0.0
    why = "the cell is silent for a stance, and at push-off the knee is stretched to half a degree of a pin"
    pin = _pinned(high=float(np.max(q[part])))
    yield named("a cell that is silent near a pin", why, changed_log(trot, silent), "dropout", pin)


def _pinned(low: float | None = None, high: float | None = None) -> Robot:
    """Return a Go2 whose first knee has another range [rad]."""
    robot = copy(load_robot("go2"))
    model = robot.model = robot.model.copy()
    low_of, high_of = model.lowerPositionLimit.copy(), model.upperPositionLimit.copy()
    low_of[9] = low_of[9] if low is None else low
    high_of[9] = high_of[9] if high is None else high
    model.lowerPositionLimit, model.upperPositionLimit = low_of, high_of
    return robot


def _bounced(stand: Log) -> Verdict:
    """Return one foot's frame that is tilted; the foot loses contact for 5 ms in a second."""
    spoilt = LogCopy(stand, np.random.default_rng(0))
    change = np.zeros(spoilt.arrays["forces"].shape)
    part = slice(500, 505)
    share = spoilt.arrays["forces"][part, 0, 2]
    change[part, :, 2] = share[:, None] * np.array([-1.0, 1.0, 1.0, -1.0])
    spoilt.arrays["forces"] += change
    shift_support(spoilt, change)
    turn = rotation_about(np.array([0.6, 0.8, 0.0]), np.radians(20.0))
    spoilt.arrays["forces"][:, 0] = spoilt.arrays["forces"][:, 0] @ turn.T
    why = "a foot that bounces once in a second: too short to tell a constant from a turn"
    return named("a tilted frame, and a bounce", why, changed_log(stand, spoilt.arrays), "wrong frame")


def _overloaded(stand: Log) -> Verdict:
    """Return a foot that uses more than its cone, read by a cell with noise along the normal."""
    arrays = arrays_of(stand)
    part, f = slice(300, 600), arrays["forces"]
    f[part, 0, 0] = 1.3 * arrays["mu"][part] * f[part, 0, 2]
    f[part, 0, 1] = 0.0
    f[part, 0, 2] += 0.5 * np.random.default_rng(4).normal(size=300)
    why = "friction of 0.78 simulated where the material has 0.6; a cell of 50 N that is good to 1 %"
    return named("too much friction, and noise", why, changed_log(stand, arrays), "too much friction")
