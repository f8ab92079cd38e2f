"""Newton and Euler for the whole robot, where its momentum is in the log: no model of it is needed.

    d/dt (p, L) = sum of contact forces and moments + (m g, 0) + the log's pushes, thrust and drag,

L about the centre of mass. What is left over is a force that no contact gave: hidden, or gravity that is
compensated.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.numerics.windows import sliding_mean
from surefoot.records.audit.rows import Measured, Rows, on_body, over
from surefoot.records.audit.within_row import moved_moment


def balance(rows: Rows) -> Measured:
    """Return the force that the momentum leaves unexplained, in the column of the body: (T, p + 1) [N]."""
    rest, weight, limits = rows.left_over, rows.setting.weight, rows.setting.limits.balance
    w, long = rows.window(limits.smooth), rows.window(limits.ringing_time)
    force, moment = (np.linalg.norm(sliding_mean(part, w), axis=-1) for part in (rest[:, :3], rest[:, 3:]))
    moment = np.maximum(moment - sliding_mean(moved_moment(rows), w), 0.0)
    rings = np.sqrt(sliding_mean((rest[:, :3] ** 2).sum(axis=1), long))
    value = np.fmax(force, moment * (limits.force / limits.arm))
    value = np.fmax(value, rings * (limits.force / limits.ringing))
    return over(on_body(rows, np.nan_to_num(value)), limits.force * weight)
