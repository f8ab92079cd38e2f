"""What may happen between the two ends of a row, by the largest second difference that forces allow.

A row holds what is so at its start, and mean forces. When within it a touch began is not known: what falls
freely for an unknown share of it has a velocity that is known to half of g dt, and a place to half of g dt².
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.rows import Rows


def fall(rows: Rows) -> float:
    """Return the acceleration of what falls freely in the log [m/s²]."""
    return float(np.linalg.norm(rows.log.facts.get("gravity", (0.0, 0.0, -GRAVITY))))


def way_to_touch(rows: Rows) -> FloatArray:
    """Return how far contacts may come nearer to the ground in each row before its force acts: (T, p) [m].

    By the velocity before the force: that of the row, of the row before it where a row has those after it.
    Without velocities by the way of the row before.
    """
    dt = rows.dt[:, None]
    if rows.has("contact_velocities"):
        nearing = np.maximum(-rows.velocities[..., 2], 0.0) * dt
        nearing[1:] = np.maximum(nearing[1:], nearing[:-1])
    else:
        nearing = np.maximum(-np.diff(rows.gaps, axis=0, prepend=rows.gaps[:1]), 0.0)
    return np.asarray(nearing + fall(rows) * dt**2)


def edges(rows: Rows) -> BoolArray:
    """Return over which rows' steps loads begin or end, nobody knows when: loaded, but not on both sides."""
    loaded = rows.loaded
    inside = loaded.copy()
    inside[1:] &= loaded[:-1]
    inside[:-1] &= loaded[1:]
    return step_of(rows, loaded & ~inside)


def step_of(rows: Rows, values: Any) -> Any:
    """Return (T, ...) values of forces at the rows whose steps they act in: a row earlier where they are late."""
    return np.concatenate([values[1:], values[-1:]]) if rows.setting.late else values
