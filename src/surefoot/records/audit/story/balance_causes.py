"""Causes that only show in how balance is lost.

Feet that land too late or too far, a gait that is too slow for its speed, a controller that believes in
another body or another posture than there is: nothing in a log names them. They are what is left where nothing
from outside and no motor explains a fall, and are told by the first time that the capture point, com + com
velocity sqrt(h / g), leaves the feet (Pratt et al. 2006): from there on only a step catches the body.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.world_causes import spans

REACH = 0.8
"""Way of the body in a stance, over its height, from which the gait is too slow for the speed."""
SAG = 0.08
"""Share of its height by which a body sinks that its controller holds for lighter than it is."""


def capture_outside(s: Signals) -> FloatArray:
    """Return how far the capture point is outside the feet's hull: (T,) [m], zero inside, NaN in the air."""
    from scipy.spatial import ConvexHull, QhullError

    along = _level_axes(s)
    points = s.com + s.com_velocity * np.sqrt(max(s.height, 1e-3) / 9.81)
    capture, places = points @ along.T, s.positions @ along.T
    feet = s.is_foot & ~s.on_movable
    out = np.full(len(s.time), np.nan)
    stride = max(1, s.rows(0.01))
    for t in range(0, len(out), stride):
        if not (s.loaded[t] & feet).any():
            continue
        at = places[t][feet]
        try:
            planes = ConvexHull(at).equations
            distance = float((planes[:, :2] @ capture[t] + planes[:, 2]).max())
        except (QhullError, ValueError):
            distance = float(np.linalg.norm(at - capture[t], axis=1).min())
        out[t : t + stride] = max(distance, 0.0)
    return out


def _level_axes(s: Signals) -> FloatArray:
    """Return two axes (2, 3) across gravity."""
    other = np.eye(3)[int(np.abs(s.up).argmin())]
    first = np.cross(s.up, other)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(s.up, first)])


def left_the_feet(s: Signals) -> int | None:
    """Return the row from which on the capture point stays outside the feet until the end or a fall."""
    outside = np.nan_to_num(capture_outside(s)) > 0.02 * max(s.height, 0.1)
    long = [(a, b) for a, b in spans(outside, s.rows(0.05)) if (b - a) * s.dt > 0.1]
    return long[0][0] if long else None


def steps(s: Signals) -> list[tuple[int, int]]:
    """Return (row, contact) of every landing of a foot after a swing of 50 ms or more, by time."""
    out = []
    for k in np.flatnonzero(s.is_foot & ~s.on_movable):
        for start, end in spans(~s.loaded[:, k]):
            if start > 0 and end < len(s.time) and (end - start) * s.dt > 0.05:
                out.append((end, int(k)))
    return sorted(out)


def placement(s: Signals) -> Iterator[Sign]:
    """Yield a foot that landed where the capture point was out of its reach."""
    row = left_the_feet(s)
    landed = [] if row is None else [(t, k) for t, k in steps(s) if t <= row + s.rows(0.15)]
    if row is None or not landed or slow_for_speed(s, row):
        return
    t, k = landed[-1]
    words = f"the capture point leaves the feet at {s.time[row]:.2f} s, after {s.links[k]} has landed"
    yield Sign(float(s.time[t]), s.links[k], words, 0.3)


def slow(s: Signals) -> Iterator[Sign]:
    """Yield feet that stay on the ground for longer than the body takes to leave them."""
    row = left_the_feet(s)
    if row is not None and slow_for_speed(s, row):
        words = f"at {_speed(s, row):.2f} m/s the body outruns feet that stand for {_stance(s, row):.2f} s"
        yield Sign(float(s.time[row]), "body", words, 0.35)


def slow_for_speed(s: Signals, row: int) -> bool:
    """Return whether the body goes farther in a stance, about a row, than legs reach."""
    return len(steps(s)) > 0 and _speed(s, row) * _stance(s, row) > REACH * max(s.height, 0.05)


def _speed(s: Signals, row: int) -> float:
    before = slice(max(0, row - s.rows(0.3)), row + 1)
    level = s.com_velocity[before] - np.outer(s.com_velocity[before] @ s.up, s.up)
    return float(np.linalg.norm(level.mean(axis=0)))


def _stance(s: Signals, row: int) -> float:
    """Return the mean time on the ground of stances that ended before a row, or are on then [s]."""
    times = []
    for k in np.flatnonzero(s.is_foot & ~s.on_movable):
        on: BoolArray = s.loaded[: row + 1, k]
        times += [(b - a) * s.dt for a, b in spans(on) if a > 0]
    return float(np.mean(times)) if times else 0.0


def wrong_mass(s: Signals) -> Iterator[Sign]:
    """Yield a body that sinks, or rises, from the start on though nothing is at its limits."""
    if not s.loaded.any() or s.height <= 0.0 or not s.torques.shape[1]:
        return
    first = int(s.loaded.any(axis=1).argmax())
    until = min(len(s.time), first + s.rows(0.5))
    sag = float(s.up @ (s.com[first] - s.com[until - 1]))
    if abs(sag) > SAG * s.height and float(s.lean[until - 1]) < 0.5 * s.limits.lean:
        way = "sinks" if sag > 0.0 else "rises"
        words = f"the body {way} by {100.0 * abs(sag):.1f} cm in {(until - first) * s.dt:.2g} s"
        yield Sign(float(s.time[first]), "body", words, abs(sag) / s.height)


def bias(s: Signals) -> Iterator[Sign]:
    """Yield that a standing body is driven to one side from the start, by torques that hold it there."""
    row = left_the_feet(s) if s.torques.shape[1] else None
    if row is None or steps(s):
        return
    drift = (s.com[row] - s.com[0]) @ _level_axes(s).T
    words = (
        f"it stands, and is driven {100.0 * float(np.linalg.norm(drift)):.0f} cm to one side until it tips"
    )
    yield Sign(float(s.time[0]), "body", words, 0.2)
