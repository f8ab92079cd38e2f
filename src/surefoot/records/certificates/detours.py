"""How far a centre of mass would have to leave its way for forces to exist."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY


def find_detours(bound: FloatArray, limit: float, window: float, step: float) -> FloatArray:
    """Return the detours (T,) [m] of frames whose bound is above the limit, 0 for others.

    A residual a that lasts T is gone where the centre of mass takes another way: one that bends by a g less
    leaves the old one by a g T² / 8 in the middle and is on it before and after. A tenth of the weight is
    1 mm in 0.1 s and 5 mm in 0.2 s. Residuals of moments count over the arm, as everywhere.

    Parameters
    ----------
    bound
        (T,) what no forces leave less than, NaN without a window [m g].
    limit
        From which a frame counts [m g].
    window
        Length of the window of one frame [s].
    step
        Time between frames [s].
    """
    out = np.zeros(len(bound))
    over = np.flatnonzero(np.nan_to_num(bound) > limit)
    if len(over):
        for stretch in np.split(over, np.flatnonzero(np.diff(over) > 1) + 1):
            time = window + (len(stretch) - 1) * step
            out[stretch] = GRAVITY * float(np.mean(bound[stretch])) * time**2 / 8.0
    return out
