"""Ranges of axes: wide enough to mean something, and what they leave out is marked."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.viz.style import BAD, INK

ROOM = 0.08
"""Free room above and below the curves, as a share of the range."""


def at_least(axis: Any, values: FloatArray, least: float) -> None:
    """Give an axis a y range that holds all values (...), and is no smaller than `least`."""
    low, high = float(np.min(values, initial=np.inf)), float(np.max(values, initial=-np.inf))
    if not low <= high:
        low = high = 0.0
    short = max(least - (high - low), 0.0)
    room = ROOM * max(high - low, least)
    axis.set_ylim(low - 0.5 * short - room, high + 0.5 * short + room)


def most_of(axis: Any, time: FloatArray, values: FloatArray, low: float, high: float, unit: str = "") -> None:
    """Give an axis the y range (low, high), widened a little, and mark what is beyond it with its value.

    Parameters
    ----------
    axis
        Of matplotlib.
    time
        (T,) along x.
    values
        (T,) or (T, k) what is drawn.
    low, high
        Of the range, in the values' unit.
    unit
        Written behind a marked value.
    """
    columns = values.reshape(len(time), -1)
    axis.set_ylim(low, high)
    for extreme, edge, sign, level in ((columns.max(), high, "^", 0.97), (columns.min(), low, "v", 0.03)):
        if (extreme > edge) if edge == high else (extreme < edge):
            row = int(np.argwhere(columns == extreme)[0, 0])
            spot = (time[row], level)
            axis.plot(*spot, sign, color=BAD, ms=6, transform=axis.get_xaxis_transform(), zorder=5)
            axis.annotate(
                f"{extreme:.3g} {unit}".rstrip(), spot, xycoords=axis.get_xaxis_transform(),
                xytext=(6, 0), textcoords="offset points", color=BAD, fontsize=8, va="center", zorder=5,
            )  # fmt: skip


def mark_worst(axis: Any, x: float, y: float, words: str) -> None:
    """Ring a point of an axis and write beside it."""
    axis.plot(x, y, "o", color=BAD, ms=8, mfc="none", mew=1.4, zorder=6)
    left, right = axis.get_xlim()
    late = x > 0.5 * (left + right)
    axis.annotate(
        words, (x, y), xytext=(-8 if late else 8, 6), textcoords="offset points", fontsize=8, color=INK,
        ha="right" if late else "left", zorder=6, bbox={"fc": "white", "ec": "none", "alpha": 0.7, "pad": 1},
    )  # fmt: skip
