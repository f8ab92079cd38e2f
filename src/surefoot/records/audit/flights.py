"""Whole flights: what falls freely comes back no higher than it fell from, whatever happened in the touch.

A body that nothing drives has as much energy in a flight as it left the ground with. So a touch that gave
energy shows in the flight after it, at any rate and whatever the world declares of its contacts. A log with
the channel `energy` has it; where all that touches is one point, its apex gap + v_n² / 2 g is as good if it
flies as a thrown stone does: the same in every row of a flight to g h v_n / 2, by any scheme.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.audit.within_row import RIGID, fall
from surefoot.records.log import Log


def flights(rows: Rows) -> Measured:
    """Return the energy of a flight beyond that of the one before it: (T, p + 1), the body's last [J].

    In every row of the flight that has more.
    """
    value, limit = np.zeros((rows.count, rows.points + 1)), np.full((rows.count, rows.points + 1), np.inf)
    column, energy, turned, moving, free = _flying(rows)
    limits, unsure = rows.setting.limits.rebound, rows.setting.weight * rows.dt * np.sqrt(2.0 * moving)
    before = None
    for a, b in runs_of(free):
        if b - a < limits.flight_rows:
            continue
        if before is not None:
            value[a:b, column] = energy[a] - turned[before]
            limit[a:b, column] = (
                limits.way * rows.setting.weight
                + limits.share * rows.setting.weight / GRAVITY * moving[before]
                + unsure[a] + unsure[before]
            )  # fmt: skip
        before = b - 1
    return over(value, limit)


def what_drives(log: Log, setting: Setting) -> str:
    """Return why flights do not tell of touches; empty where nothing drives what flies."""
    if "torques" in log and bool(np.any(np.asarray(log["torques"][: 1 << 16]))):
        return "joints drive what flies"
    if "v" in log and log["v"].shape[1] > RIGID:
        return "limbs move what flies"
    if "energy" not in log and ("v" in log or len(setting.names) > 1):
        return "the log has no energy"
    if any(name in log and bool(np.any(np.asarray(log[name]))) for name in ("wrench_applied", "push")):
        return "something pushes what flies"
    return ""


def _flying(rows: Rows) -> tuple[int, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Return column, energy after and before a touch (T,) [J], half a squared speed (T,), flying rows (T,).

    The way of a single point across the ground counts before a touch, which may turn it upwards.
    """
    off = (rows.gaps > 0.0).all(axis=1) & (np.abs(rows.forces).max(axis=(1, 2)) == 0.0)
    weight, g = rows.setting.weight, max(fall(rows), 1e-9)
    if "energy" in rows.log:
        fastest = 0.5 * (rows.velocities**2).sum(axis=2).max(axis=1)
        return rows.points, rows.numbers("energy"), rows.numbers("energy"), fastest, off
    up, aside = rows.velocities[:, 0, 2], np.hypot(rows.velocities[:, 0, 0], rows.velocities[:, 0, 1])
    along = rows.numbers("normals")[:, 0, 2] if "normals" in rows.log else np.ones(rows.count)
    pull = (g * along * rows.dt)[:-1]
    beside = np.abs(np.diff(up) + pull) > rows.setting.limits.rebound.free_fall * pull
    off[:-1] &= ~(beside & off[1:])
    moving = 0.5 * up**2 + 0.5 * aside**2
    energy = weight * (rows.gaps[:, 0] + 0.5 * up**2 / g)
    return 0, energy, energy + 0.5 * weight * aside**2 / g, moving, off
