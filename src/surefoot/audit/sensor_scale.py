"""What one unit of the feet's sensors is worth, from the robot's weight over whole strides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from surefoot.arrays import FloatArray, real_number
from surefoot.audit.contact_times import FLAT, ContactTimes, contact_times, load_readings
from surefoot.errors import ProblemError
from surefoot.log import Log
from surefoot.spatial import GRAVITY

FEWEST = 5
"""Fewest whole strides from which a scale is estimated."""
QUIET, QUIET_TIME = 0.02, 0.5
"""Readings that stay within this share of their peaks for this long [s] are those of a robot at rest."""
UNKNOWN = (
    "the scale of each foot by itself: all are taken to have one",
    "tangential forces and friction",
    "the sensors' bandwidth and delay",
)
"""What readings and weight do not tell."""


@dataclass(frozen=True)
class SensorScale:
    """What one unit of the feet's sensors is worth: m g over the mean of all readings in whole strides.

    Attributes
    ----------
    scale, low, high
        Estimate and the ends of its interval of 95 % [N per unit].
    strides
        Number of whole strides behind it.
    offsets
        (n,) readings in the air, which were taken off.
    doubts
        What speaks against one scale, one line each.
    unknown
        What this cannot tell.
    """

    scale: float
    low: float
    high: float
    strides: int
    offsets: FloatArray
    doubts: tuple[str, ...] = ()
    unknown: tuple[str, ...] = UNKNOWN


def sensor_scale(log: Log, mass: float | None = None) -> SensorScale:
    """Return what one unit of ``foot_sensors`` is worth, by the robot's weight over whole strides.

    Over whole strides the ground carries m g on average: scale = m g / mean of all readings less their
    offsets. The interval of 95 % is that of the strides' means (Student's, with fewer degrees of freedom for
    strides that resemble their neighbours), widened by how much the offsets wander.

    Parameters
    ----------
    log
        With the channel ``foot_sensors``.
    mass
        Of the robot [kg]; None for the log's fact.

    Raises
    ------
    ProblemError
        Where it cannot be known: no mass, a foot whose offset the log does not show, too few whole strides.
    """
    if "foot_sensors" not in log:
        raise ProblemError("the scale of the sensors needs the channel foot_sensors")
    weight = (log.fact("mass") if mass is None else real_number("mass", mass, low=1e-6, high=1e6)) * GRAVITY
    times = contact_times(log)
    for foot in times.feet:
        if foot.refused:
            raise ProblemError(f"the scale cannot be known: the load on {foot.name} is not: {foot.refused}")
    leader = max(times.feet, key=lambda f: len(f.strides))
    if len(leader.strides) < FEWEST:
        raise ProblemError(f"the scale needs {FEWEST} whole strides of a foot, got {len(leader.strides)}")
    offsets = np.array([foot.offset for foot in times.feet])
    time, _, readings = load_readings(log)
    loads = (readings - offsets).sum(axis=1)
    means = np.array([_mean(time, loads, begin, end) for begin, end in leader.strides])
    mean = float(means.mean())
    if mean <= 0.0:
        raise ProblemError(f"the scale cannot be known: the readings' mean over strides is {mean:.3g}")
    half = _half_width(means) + float(_wander(readings, times).sum())
    high = weight / (mean - half) if half < mean else np.inf
    doubts = _scale_doubts(log, times, loads, mean, leader.strides)
    return SensorScale(weight / mean, weight / (mean + half), high, len(means), offsets, tuple(doubts))


def _mean(time: FloatArray, values: FloatArray, begin: float, end: float) -> float:
    """Return the mean of a signal between two instants, its corners joined by lines."""
    inside = (time > begin) & (time < end)
    at = np.concatenate([[begin], time[inside], [end]])
    return float(np.trapezoid(np.interp(at, time, values), at) / (end - begin))


def _half_width(means: FloatArray) -> float:
    """Return half the 95 % interval of a mean of numbers that resemble their neighbours."""
    away = means - means.mean()
    power = float(away @ away)
    likeness = min(max(float(away[1:] @ away[:-1]) / power, 0.0), 0.9) if power > 0.0 else 0.0
    count = max(len(means) * (1.0 - likeness) / (1.0 + likeness), 2.0)
    return float(stats.t.ppf(0.975, count - 1.0) * means.std(ddof=1) / np.sqrt(count))


def _wander(readings: FloatArray, times: ContactTimes) -> FloatArray:
    """Return how far each foot's reading in the air is from its offset, four times out of five: (n,)."""
    out = []
    for k, foot in enumerate(times.feet):
        air = np.abs(readings[~times.contacts[:, k], k] - foot.offset)
        out.append(float(np.percentile(air[air <= FLAT * (foot.peak - foot.offset)], 80.0)))
    return np.array(out)


def _scale_doubts(
    log: Log, times: ContactTimes, loads: FloatArray, mean: float, strides: FloatArray
) -> list[str]:
    """Return what speaks against one scale for all of the log."""
    time, _, readings = load_readings(log)
    out = []
    size = np.array([foot.peak - foot.offset for foot in times.feet])
    rest = [loads[w].mean() for w in _windows(time) if (np.ptp(readings[w], axis=0) < QUIET * size).all()]
    if rest and not 0.8 < (share := float(np.median(rest)) / mean) < 1.25:
        out.append(
            f"at rest the readings sum up to {share:.2g} of their mean over strides: they are not linear, "
            "creep or wander, and the scale holds for walking only"
        )
    if "imu_acceleration" in log:
        inside = (time >= strides[0, 0]) & (time <= strides[-1, 1])
        sensed = float(np.nanmean(log["imu_acceleration"][inside, 2]))
        if abs(sensed / GRAVITY - 1.0) > 0.1:
            out.append(
                f"the IMU's mean vertical acceleration in strides is {sensed:.3g} m/s^2, not {GRAVITY:g}"
            )
    return out


def _windows(time: FloatArray) -> list[slice]:
    """Return consecutive windows of `QUIET_TIME`."""
    cuts = np.searchsorted(time, np.arange(time[0], time[-1], QUIET_TIME))
    return [slice(a, b) for a, b in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True) if b - a > 5]
