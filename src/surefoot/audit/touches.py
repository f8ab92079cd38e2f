"""What the ground gives back along its normal: a touch never returns more energy than it took.

A force held over a row, f, moves what it acts on from one velocity to the next; the energy that it gives is

    W = f_n dt (v_n + v_n') / 2,

exactly so for an impulse (Stronge's work of the normal force: restitution e <= 1 is sum W <= 0). A contact
that stores energy has taken it before: the sum since touchdown stays below zero at any time.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.audit.rows import Measured, Rows
from surefoot.audit.setting import Setting
from surefoot.log import Log

REBOUND = 5e-5
"""Energy that a touch may return beyond what it took is m g on this way [m] (clean walks: a seventh), ..."""
REBOUND_SHARE = 0.03
"""... or this share of what it took: restitution of 1.015."""
RETURN_TIME = 0.01
"""A touch is at fault while it gives back over half of the limit within this time [s]."""
LONGEST_ROW = 5e-3
"""Not judged where rows are further apart [s]: a touch of a foot is over between two."""


def rebound(rows: Rows) -> Measured:
    """Return the energy that touches have given back beyond what they took: (T, p) [J]."""
    up = rows.velocities[..., 2]
    value, taken = returned_work(rows.normal, up, rows.dt, rows.loaded, rows.setting.after)
    limit = np.maximum(REBOUND * rows.setting.weight, REBOUND_SHARE * taken)
    before = np.concatenate([value[:1].repeat(rows.window(RETURN_TIME), 0), value])[: len(value)]
    returns = value - before > 0.5 * limit  # the rows that give it back, not the rest of the touch
    return value, limit, (value > limit) & returns


def sparse(log: Log, setting: Setting) -> str:
    """Return why touches cannot be judged; empty where rows are close enough."""
    far = f"rows are {1e3 * setting.dt:.3g} ms apart: a touch is over between two"
    return far if setting.dt > LONGEST_ROW else ""


def returned_work(
    normal: FloatArray, velocity: FloatArray, dt: FloatArray, loaded: BoolArray, after: bool
) -> tuple[FloatArray, FloatArray]:
    """Return the energy given less taken since touchdown, and the energy taken: (T, p) each [J].

    Zero for contacts without load, and in touches whose beginning is not among the rows.

    Parameters
    ----------
    normal, velocity
        (T, p) normal force [N] and velocity along the normal [m/s].
    dt
        (T,) time to the next row [s].
    loaded
        (T, p) where a contact is loaded.
    after
        Whether a row's velocity is that after its force has acted.
    """
    ends = np.concatenate([velocity[:1], velocity, velocity[-1:]])
    first, last = (ends[:-2], ends[1:-1]) if after else (ends[1:-1], ends[2:])
    half = 0.5 * normal * dt[:, None]
    given = np.where(loaded, half * (np.maximum(first, 0.0) + np.maximum(last, 0.0)), 0.0)
    taken = np.where(loaded, -half * (np.minimum(first, 0.0) + np.minimum(last, 0.0)), 0.0)
    if not after:  # the velocity after the last row is not known
        given[-1:] = taken[-1:] = 0.0
    begun = np.logical_or.accumulate(~loaded, axis=0)
    known = loaded & begun
    return (
        np.where(known, _since_touchdown(given - taken, loaded), 0.0),
        np.where(known, _since_touchdown(taken, loaded), 0.0),
    )


def _since_touchdown(values: FloatArray, loaded: BoolArray) -> FloatArray:
    """Return the sums of (T, p) values since each contact was last without load."""
    total = np.cumsum(values, axis=0)
    before = np.maximum.accumulate(np.where(loaded, -1, np.arange(len(values))[:, None]), axis=0)
    columns = np.arange(values.shape[1])[None]
    return np.asarray(total - np.where(before >= 0, total[np.maximum(before, 0), columns], 0.0))
