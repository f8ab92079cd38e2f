"""The plane that the contact points and gaps of a log show, where it does not name its ground."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.log import Log

ROWS = 1 << 16
"""Rows of a log that are looked at."""
LEVEL = 1e-6
"""Difference of unit vectors that are one [-]."""
MEASURED = 1.0 - 1e-9
"""Recordings measure gaps up to here: what is farther apart is logged as that far [m]."""


def ground_plane(log: Log, share: float, near: float, threshold: float) -> FloatArray | None:
    """Return the plane that contact points and gaps show: normal and height (4,), None for none.

    Where the log does not say what its contacts touch, all that is loaded has to stand on it, and nothing
    may fly over another level: a step is another plane.

    Parameters
    ----------
    log
        With contact_positions, normals and gaps; else None.
    share
        Of the contacts' rows that must show it [-].
    near
        How far their heights may differ [m].
    threshold
        Normal force from which a contact counts as loaded [N].
    """
    if not {"contact_positions", "normals", "gaps"} <= set(log) or not log["gaps"].size:
        return None
    normals, places, gaps = (np.asarray(log[n][:ROWS]) for n in ("normals", "contact_positions", "gaps"))
    mine = on_ground(log, gaps.shape[1]) & (gaps < MEASURED)
    normal = np.nanmedian(normals[mine], axis=0) if mine.any() else np.zeros(3)
    if not abs(float(np.linalg.norm(normal)) - 1.0) < LEVEL:
        return None
    same = (np.abs(normals - normal) < LEVEL).all(axis=2) & mine
    height = np.where(same, places @ normal - gaps, np.nan)
    half = in_the_middle(log, gaps)
    height[half] += 0.5 * gaps[half]
    if not np.isfinite(height).any():
        return None
    level = float(np.nanmedian(height))
    with np.errstate(invalid="ignore"):
        shows = np.abs(height - level) < near
    if share > 0.0 and "contact_with" not in log.facts and "forces" in log:
        loaded = np.asarray(log["forces"][:ROWS])[..., 2] > threshold
        if (loaded & ~shows).any() or _another_level(height, gaps, ~shows & mine):
            return None
    return np.append(normal, level) if float(shows.sum()) >= share * float(mine.sum()) else None


def in_the_middle(log: Log, gaps: FloatArray) -> BoolArray:
    """Return where points of (T, p) gaps are logged in their middle: a recording's, within the margin."""
    margin = np.asarray(log.facts.get("contact_margin", np.zeros(gaps.shape[1])))
    return np.asarray((gaps <= margin) & (gaps != 0.0) & (log.facts.get("kind") == "recording"))


def on_ground(log: Log, points: int) -> BoolArray:
    """Return which contacts (p,) touch what most of them touch; all where the log does not say."""
    names = np.asarray(log.facts.get("contact_with", ()))
    if names.shape != (points,):
        return np.ones(points, dtype=bool)
    kinds, counts = np.unique(names, return_counts=True)
    return np.asarray(names == kinds[np.argmax(counts)])


def _another_level(height: FloatArray, gaps: FloatArray, off: BoolArray) -> bool:
    """Return whether most of what is (T, p) off a plane is above another: its height stays, gaps change."""
    pairs = off[1:] & off[:-1] & np.isfinite(np.diff(height, axis=0))
    if not pairs.any():
        return bool(off.any())
    stays = np.abs(np.diff(height, axis=0)) < 0.5 * np.abs(np.diff(gaps, axis=0)) + LEVEL
    return float(stays[pairs].mean()) > 0.5
