"""Whole flights: what falls freely comes back no higher than it fell from, whatever happened in the touch.

A contact point that flies as a thrown stone does, with g downwards, is that of a body that nothing drives. Its
apex, gap + v_n² / 2 g, is the same in every row of a flight, at any rate and by any scheme to g h v_n / 2; of the
flight before a touch the way across the ground counts, too, since a body that tumbles turns it upwards. So a
touch that gave energy shows in what comes after it, whatever the world declares of its contacts.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import runs_of
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.audit.within_row import fall
from surefoot.records.log import Log


def flights(rows: Rows) -> Measured:
    """Return the energy with which contacts come back beyond that they fell with: (T, p) [J].

    In every row of the flight that comes back.
    """
    value, limit = np.zeros(rows.normal.shape), np.full(rows.normal.shape, np.inf)
    limits, g, weight = rows.setting.limits.rebound, fall(rows), rows.setting.weight
    if g <= 0.0:
        return over(value, limit)
    up, aside = rows.velocities[..., 2], np.hypot(rows.velocities[..., 0], rows.velocities[..., 1])
    apex = rows.gaps + 0.5 * up**2 / g
    unsure = rows.dt[:, None] * np.abs(up) + 0.5 * g * rows.dt[:, None] ** 2
    falling = _falling(rows, up, g)
    for c in range(rows.points):
        before = None
        for a, b in runs_of(falling[:, c]):
            if b - a < limits.flight_rows:
                continue
            high = float(np.median(apex[a:b, c]))
            if before is not None:
                value[a:b, c] = weight * (high - before[0])
                limit[a:b, c] = weight * (
                    limits.way + limits.share * before[0] + before[1] + float(np.median(unsure[a:b, c]))
                )
            most = high + float(np.median(0.5 * aside[a:b, c] ** 2 / g))
            before = most, float(np.median(unsure[a:b, c]))
    return over(value, limit)


def driven(log: Log, setting: Setting) -> str:
    """Return why flights do not tell of touches; empty where nothing drives what flies."""
    if "torques" in log and bool(np.any(np.asarray(log["torques"][: 1 << 16]))):
        return "joints drive what flies"
    if "v" in log and log["v"].shape[1] > 6:
        return "limbs move what flies"
    if len(setting.feet) > 1 and "v" not in log:
        return "more than one body may touch: nothing says that none is driven"
    if any(name in log and bool(np.any(np.asarray(log[name]))) for name in ("wrench_applied", "push")):
        return "something pushes what flies"
    return ""


def _falling(rows: Rows, up: FloatArray, g: float) -> BoolArray:
    """Return in which rows contacts fall freely, off the ground and without a force: (T, p)."""
    free = (rows.gaps > 0.0) & (np.abs(rows.forces).max(axis=2) == 0.0)
    along = rows.numbers("normals")[..., 2] if "normals" in rows.log else np.ones(up.shape)
    pull = g * along * rows.dt[:, None]
    off = np.abs(np.diff(up, axis=0) + pull[:-1]) > rows.setting.limits.rebound.free_fall * pull[:-1]
    free[:-1] &= ~(off & free[1:])
    return np.asarray(free)
