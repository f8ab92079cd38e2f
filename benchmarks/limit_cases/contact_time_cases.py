"""Readings of a foot's sensor whose contacts are known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from benchmarks.limit_cases.verdict import Verdict
from surefoot.base.arrays import FloatArray
from surefoot.records.audit.contact_times import FootTimes, contact_times
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.log import Log

PEAK, LATE = 100.0, 0.015
"""Usual reading of a loaded foot, and how far a touchdown may be from the true one [s]."""


def contact_time_cases() -> Iterator[Verdict]:
    """Yield the cases of contact times."""
    yield _told(
        "a trot whose feet shake", "a foot of 60 g at 3 g in its swing: 3 % of its load", 0.5, 0.6, 0.03
    )
    yield _told("a walk", "three feet of four carry: a quarter of the time in the air", 0.5, 0.75, 0.02)
    yield _told("a run", "period 0.25 s, a third of it on the ground: quick quadrupeds", 0.25, 0.34, 0.01)
    yield _told("a noisy trot", "a cell of 5 % noise", 0.5, 0.5, 0.05, shaking=False)
    for name, why, change, right in (
        (
            "a foot that bounces", "8 ms off the ground 12 ms after it: a rubber ball of 1 kHz on a leg",
            _bounces, _regular,
        ),
        (
            "a robot that rests", "a stand of 2 s between steps of 0.5 s is no stride", _rests,
            lambda foot: abs(foot.duty_factor - 0.6) < 0.03,
        ),
        (
            "strides that vary", "people's and dogs' strides vary by 3 to 5 %", _varies,
            lambda foot: len(foot.strides) >= 0.9 * (len(foot.touchdowns) - 1),
        ),
    ):  # fmt: skip
        yield Verdict(name, why, partial(_right, change(), right))
    for name, why, reading in (
        ("a drift", "a cell that warms up goes from end to end and never rests", _drift),
        ("rectified noise", "an unloaded cell that cannot read below zero", _one_sided),
    ):
        yield Verdict(name, f"{why}: tells no contact", partial(_right, _log(reading()), _refused))
    for lost, strides, why in (
        (0.08, 8, "eight rows of ten lost at 100 Hz may hide a touchdown"),
        (0.03, 9, "a computer that is late by two rows in 100 Hz has lost nothing"),
    ):
        right = partial(_count, strides)
        yield Verdict(f"a hole of {1e3 * lost:g} ms", why, partial(_right, _hole(lost), right))


def _right(log: Log, right: Callable[[FootTimes], bool], limits: AuditLimits) -> bool:
    return right(contact_times(log, limits).feet[0])


def _refused(foot: FootTimes) -> bool:
    return bool(foot.refused)


def _regular(foot: FootTimes) -> bool:
    periods = np.diff(foot.touchdowns)
    return not foot.refused and len(periods) > 5 and bool((np.abs(periods - 0.5) < 0.02).all())


def _count(strides: int, foot: FootTimes) -> bool:
    return len(foot.strides) == strides


def _told(name: str, why: str, period: float, duty: float, noise: float, shaking: bool = True) -> Verdict:
    """Return the case of steps, each of whose touchdowns and lift-offs should be found in time."""
    rng, time = np.random.default_rng(3), np.arange(0.0, 8.0, 2.5e-3)
    reading = _steps(time, period, duty)
    air = reading == 0.0
    shake = rng.uniform(-1.0, 1.0, len(time)) if shaking else rng.normal(size=len(time))
    reading = reading + noise * PEAK * np.where(air | (not shaking), shake, 0.0)
    begins = period * np.arange(int(8.0 / period) + 1)

    def right(foot: FootTimes) -> bool:
        if foot.refused or abs(len(foot.touchdowns) - len(begins)) > 2:
            return False
        near = np.abs(foot.touchdowns[:, None] - begins).min(axis=1)
        ends = np.abs(foot.lift_offs[:, None] - (begins - (1.0 - duty) * period)).min(axis=1)
        return bool(np.median(near) < LATE and np.median(ends) < LATE) and abs(foot.duty_factor - duty) < 0.06

    return Verdict(name, why, partial(_right, _log(reading, time), right))


def _steps(time: FloatArray, period: float, duty: float) -> FloatArray:
    phase = time / period % 1.0
    return np.where(phase < duty, PEAK * np.sin(np.pi * np.minimum(phase / duty, 1.0)), 0.0)


def _log(reading: FloatArray, time: FloatArray | None = None) -> Log:
    stamps = 2.5e-3 * np.arange(len(reading)) if time is None else time
    return Log({"time": stamps, "foot_sensors": reading[:, None]}, {"feet": ["foot"]})


def _bounces() -> Log:
    time = np.arange(0.0, 6.0, 1e-3)
    reading, phase = _square(time), time % 0.5
    return _log(np.where((phase > 0.012) & (phase < 0.02), 0.0, reading), time)


def _square(time: FloatArray, period: float = 0.5, duty: float = 0.6) -> FloatArray:
    return np.where(time / period % 1.0 < duty, PEAK * (1.0 + 0.01 * np.sin(40.0 * time)), 0.0)


def _rests() -> Log:
    time = np.arange(0.0, 8.0, 2.5e-3)
    walked = np.where(time < 3.0, time, np.where(time < 5.0, 3.1, time - 2.0))
    return _log(_square(walked), time)


def _varies() -> Log:
    rng, readings = np.random.default_rng(4), []
    for period in 0.5 * (1.0 + 0.04 * rng.normal(size=20)):
        readings.append(_square(np.arange(0.0, period, 2.5e-3), period))
    return _log(np.concatenate(readings))


def _drift() -> FloatArray:
    return np.linspace(0.0, PEAK, 4000)


def _one_sided() -> FloatArray:
    return np.maximum(np.random.default_rng(5).normal(size=4000), 0.0)


def _hole(lost: float) -> Log:
    """Return ten steps in rows of 10 ms, in the middle of whose fifth swing some time is lost."""
    time = np.arange(0.0, 5.0, 0.01) + 0.3
    keep = (time < 2.42) | (time >= 2.42 + lost)
    keep[0] = True
    return _log(_square(time)[keep], time[keep])
