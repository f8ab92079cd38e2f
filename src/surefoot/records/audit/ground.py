"""The plane that the contact points and gaps of a log show, where it does not name its ground."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.log import Log

LEVEL = 1e-6
"""Difference of unit vectors that are one [-]."""
MEASURED = 1.0 - 1e-9
"""Recordings measure gaps up to here: what is farther apart is logged as that far [m]."""


def ground_plane(log: Log, share: float, near: float) -> FloatArray | None:
    """Return the plane that contact points and gaps show: normal and height (4,), None for none.

    Parameters
    ----------
    log
        With contact_positions, normals and gaps; else None.
    share
        Of the contacts' rows that must show it [-].
    near
        How far their heights may differ [m].
    """
    if not {"contact_positions", "normals", "gaps"} <= set(log) or not log["gaps"].size:
        return None
    normals, places, gaps = (np.asarray(log[n][: 1 << 16]) for n in ("normals", "contact_positions", "gaps"))
    normal = np.nanmedian(normals.reshape(-1, 3), axis=0)
    length = float(np.linalg.norm(normal))
    if not abs(length - 1.0) < LEVEL:
        return None
    same = (np.abs(normals - normal) < LEVEL).all(axis=2) & (gaps < MEASURED)
    height = np.where(same, places @ normal - gaps, np.nan)
    if not np.isfinite(height).any():
        return None
    level = float(np.nanmedian(height))
    with np.errstate(invalid="ignore"):
        shows = float((np.abs(height - level) < near).sum() / max((gaps < MEASURED).sum(), 1))
    return np.append(normal, level) if shows >= share else None
