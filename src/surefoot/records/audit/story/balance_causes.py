"""Causes that only show in how balance is lost.

Feet that land too late or too far, a gait that is too slow for its speed, a controller that believes in
another body or another posture than there is: nothing in a log names them. They are what is left where
nothing from outside and no motor explains a fall, and are told by the first time that the capture point, com
+ com velocity sqrt(h / g), leaves the feet (Pratt et al. 2006): from there on only a step catches the body.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import joined_runs
from surefoot.records.audit.story.control_causes import at_limit
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals

REACH = 0.8
"""Way of the body in a stance, over its height, from which the gait is too slow for the speed."""
TIPS = 1.6
"""Times sqrt(h / g) that a body stands on two feet of four before it cannot be caught."""


def left_the_feet(s: Signals) -> int | None:
    """Return the row from which on the capture point stays outside the feet until the end or a fall."""
    outside = np.nan_to_num(s.capture_outside) > 0.02 * max(s.height, 0.1)
    long = [(a, b) for a, b in joined_runs(outside, s.rows(0.05)) if (b - a) * s.dt > 0.1]
    return long[0][0] if long else None


def steps(s: Signals) -> list[tuple[int, int]]:
    """Return (row, contact) of every landing of a foot after a swing of 50 ms or more, by time."""
    out = []
    for k in np.flatnonzero(s.is_foot & ~s.on_movable):
        for start, end in joined_runs(~s.loaded[:, k]):
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
    feet = s.is_foot & ~s.on_movable
    owners = sorted({s.links[k] for k in np.flatnonzero(feet)})
    down = [s.loaded[:, np.array([link == one for link in s.links]) & feet].any(axis=1) for one in owners]
    standing = np.sum(down, axis=0) if down else np.zeros(len(s.time))
    if len(owners) >= 3:
        tips = TIPS * s.pendulum_time
        row = s.first((standing > 0) & (standing <= 2), s.rows(tips))
        if row is not None and row > 0:
            words = f"it stands on two feet for more than {tips:.2f} s, in which it tips over them"
            yield Sign(float(s.time[row]), "body", words, 0.4)
            return
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
        times += [(b - a) * s.dt for a, b in joined_runs(on) if a > 0]
    return float(np.mean(times)) if times else 0.0


def pull_at_rest(s: Signals) -> FloatArray | None:
    """Return the mean force (3,) that moves a body in its first moments, over its weight.

    None unless it stands at rest at first, on contacts that do not give way.
    """
    on = s.loaded.any(axis=1)
    if "momentum_rate" not in s or not on.any() or not s.torques.shape[1] or s.height <= 0.0:
        return None
    first = int(on.argmax())
    begun = slice(first, first + s.rows(0.15))
    at_rest = float(np.linalg.norm(s.com_velocity[first])) < 0.05 and first * s.dt < 0.02
    firm = bool((np.where(s.loaded[begun], s.gaps[begun], 0.0) > -s.limits.depth).all())
    return s.numbers("momentum_rate")[begun, :3].mean(axis=0) / s.weight if at_rest and firm else None


def wrong_mass(s: Signals) -> Iterator[Sign]:
    """Yield that the controller says so, or that torques for another body push one at rest from the start."""
    believed = s.log.facts.get("mass_controller")
    if believed is not None and abs(float(believed) - s.mass) > s.limits.payload * s.mass:
        words = f"the controller believes in {float(believed):.3g} kg, there are {s.mass:.3g}"
        yield Sign(float(s.time[0]), s.base, words, 1.0)
        return
    pull = pull_at_rest(s)
    if pull is None:
        return
    up = float(pull @ s.up)
    level = float(np.linalg.norm(pull - up * s.up))
    sags = up < 0.0 and level < s.limits.drives and at_limit(s)[: s.rows(0.15)].any()
    if not sags and (abs(up) > s.limits.lifts or level > s.limits.drives):
        words = f"at rest its feet push it by {up:+.0%} of its weight upwards and {level:.0%} sideways"
        yield Sign(float(s.time[0]), s.base, words, abs(up) + level)


def bias(s: Signals) -> Iterator[Sign]:
    """Yield that a standing body is driven to one side from the start, by torques that hold it there."""
    pull = pull_at_rest(s)
    row = left_the_feet(s)
    if row is None or steps(s) or not s.torques.shape[1]:
        return
    if pull is not None and float(np.linalg.norm(pull - (pull @ s.up) * s.up)) < 0.2 * s.limits.drives:
        return
    drift = (s.com[row] - s.com[0]) @ s.level_axes.T
    words = f"it is driven {100.0 * float(np.linalg.norm(drift)):.0f} cm to one side until it tips"
    yield Sign(float(s.time[0]), s.base, words, 0.2)
