"""What is not plausible in a log from outside: units, frames, orders, time stamps. Told, never mended."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import near_name
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.records.log.facts import FACTS
from surefoot.records.log.log import Log

ROWS = 20_000
"""Rows that are looked at for everything but stamps and numbers that are not finite: the first of them."""
SPREAD, RISE = 0.1, 0.5
"""Share of m g by which the mean load of a log may miss it before that is reported [-]: force sensors agree
better; and the change of a robot's vertical velocity from the first row to the last [m/s], which the load
makes up for (Newton: mean load - m g = m change / time)."""


def find_doubts(log: Log) -> list[str]:
    """Return what is not plausible in a log, one line each; empty if nothing is.

    Looks at stamps, missing numbers, angles in degrees, quaternions (norm, order), gravity in the IMU, the
    mean load against m g. A doubt may be wrong; no doubt does not mean that all is right.
    """
    found = [*_stamps(log), *_missing(log), *_unknown_facts(log)]
    first = log.rows(slice(0, ROWS))
    for check in CHECKS:
        with np.errstate(all="ignore"):
            found += check(first)
    return found


def _stamps(log: Log) -> Iterator[str]:
    time = np.asarray(log["time"])
    steps = np.diff(time)
    if not len(time):
        yield "the log has no rows"
    if not steps.size:
        return
    for bad, what in ((steps < 0.0, "goes backward"), (steps == 0.0, "stands still")):
        if bad.any():
            yield f"the time {what} in {int(bad.sum())} rows, first in row {int(np.argmax(bad)) + 1}"
    good = steps[steps > 0.0]
    middle = float(np.median(good)) if good.size else 0.0
    if middle > 0.5 or 0.0 < middle < 1e-5:
        yield f"rows are {middle:.3g} s apart: is the time in seconds?"
    holes = steps > max(5.0 * middle, 1e-12)
    if middle and holes.any():
        at = int(np.argmax(steps))
        count = int(holes.sum())
        yield f"rows are missing in {count} places, at most {steps[at]:.3g} s after {time[at]:.6g} s"


def _unknown_facts(log: Log) -> Iterator[str]:
    for name in log.facts:
        if name not in FACTS:
            yield f"nothing reads the fact {name}{near_name(name, [*FACTS, 'mu'])}"


def _missing(log: Log) -> Iterator[str]:
    for name, array in log.arrays.items():
        if array.dtype.kind == "f" and array.size:
            bad = ~np.isfinite(array.reshape(len(array), -1)).all(axis=1)
            if bad.any():
                yield f"{name} is not finite in {int(bad.sum())} rows, first in row {int(np.argmax(bad))}"


def _largest(array: FloatArray) -> float:
    """Return the largest magnitude but for one in a hundred."""
    values = np.abs(array[np.isfinite(array)])
    return float(np.percentile(values, 99)) if values.size else 0.0


def _mean(array: FloatArray, axis: int | None = None) -> FloatArray:
    """Return the mean of the finite numbers, NaN where there are none."""
    finite = np.isfinite(array)
    return np.asarray(np.where(finite, array, 0.0).sum(axis=axis) / finite.sum(axis=axis))


def _angles(log: Log) -> Iterator[str]:
    for name, most, what in (
        ("joint_positions", 7.0, "are they in degrees?"),
        ("joint_velocities", 100.0, "are they in deg/s?"),
        ("imu_angular_velocity", 35.0, "is it in deg/s?"),
        ("base_angular_velocity", 35.0, "is it in deg/s?"),
        ("torques", 2000.0, "are they in N m?"),
        ("gaps", 10.0, "are they in m?"),
        ("base_velocity", 30.0, "is it in m/s?"),
    ):
        if name in log and (found := _largest(log[name])) > most:
            yield f"{name} reach {found:.4g}: {what}"


def _quaternion(log: Log) -> Iterator[str]:
    if "base_orientation" in log:
        quaternion = np.asarray(log["base_orientation"])
    elif "q" in log and log.sizes.get("nq", 0) >= 7 and log.sizes.get("nv") != log.sizes["nq"]:
        quaternion = np.asarray(log["q"])[:, 3:7]
    else:
        return
    quaternion = quaternion[np.isfinite(quaternion).all(axis=1)]
    norm = np.linalg.norm(quaternion, axis=1)
    if not norm.size:
        return
    if np.abs(norm - 1.0).max() > 1e-3:
        worst = float(norm[np.argmax(np.abs(norm - 1.0))])
        yield f"quaternions have norms up to {worst:.4g}, not 1"
    quaternion = quaternion[norm > 0.1] / norm[norm > 0.1, None]
    if not len(quaternion):
        return
    up = float(np.median(rotation_from_quaternion(quaternion)[:, 2, 2]))
    other = float(np.median(rotation_from_quaternion(quaternion[:, [1, 2, 3, 0]])[:, 2, 2]))
    if up < 0.5 < other:
        yield (
            f"the base leans {np.degrees(np.arccos(np.clip(up, -1, 1))):.0f} deg as x, y, z, w, but "
            f"{np.degrees(np.arccos(np.clip(other, -1, 1))):.0f} deg as w, x, y, z: is that its order?"
        )


def _gravity(log: Log) -> Iterator[str]:
    if "imu_acceleration" not in log or not len(log):
        return
    mean = _mean(log["imu_acceleration"], 0)
    size = math.hypot(*mean)
    if not np.isfinite(size) or 0.8 * GRAVITY < size < 1.2 * GRAVITY:
        if mean[2] < -0.5 * size:
            yield f"the IMU's mean acceleration is {mean[2]:.3g} m/s^2 along z: its sign, or upside down?"
        elif np.isfinite(size) and mean[2] < 0.5 * size:
            yield f"the IMU's mean acceleration is {np.round(mean, 2).tolist()} m/s^2: is z its upward axis?"
    elif 0.9 < size < 1.1:
        yield f"the IMU's mean acceleration is {size:.3g}: is it in g?"
    elif size < 0.2 * GRAVITY:
        yield f"the IMU's mean acceleration is {size:.3g} m/s^2: is gravity taken out of it?"
    else:
        yield f"the IMU's mean acceleration is {size:.3g} m/s^2, gravity is {GRAVITY:g}"


def load_doubts(log: Log) -> Iterator[str]:
    """Compare the mean load with m g; over half a second or more, and for a body that is not in free fall."""
    log = log.rows(slice(0, ROWS))
    if "forces" not in log or len(log) < 2 or log["time"][-1] - log["time"][0] < 0.5:
        return
    total = _mean(np.asarray(log["forces"]).sum(axis=1), axis=0)
    if not np.isfinite(total).all():
        return
    size = math.hypot(*total)  # no overflow of huge forces
    if size > 1e-6 and total[2] < -0.7 * size:
        yield f"normal forces are {total[2]:.4g} N on average: are they those on the ground?"
        return
    if size > 1e-6 and abs(total[2]) < 0.7 * size:
        mean = np.round(total, 1).tolist()
        yield f"forces are {mean} N on average, the last is not the largest: is the normal the first?"
        return
    if "mass" in log.facts:
        share = float(total[2]) / (log.fact("mass") * GRAVITY)
        time = float(log["time"][-1] - log["time"][0])
        if abs(share - 1.0) > SPREAD + RISE / (GRAVITY * time):
            yield f"normal forces are {share:.3g} m g on average: unit, mass, or feet that are missing?"


CHECKS: tuple[Callable[[Log], Iterator[str]], ...] = (_angles, _quaternion, _gravity, load_doubts)
"""The checks of the first `ROWS` rows."""
