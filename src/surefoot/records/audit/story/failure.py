"""How a run went wrong, if it did: what a story has to explain."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.told import Event

SLIDE_TIME = 0.5
"""Time within which a slide has to go so far that it matters [s]."""


def touch_down_of_links(s: Signals) -> BoolArray:
    """Return (T, p) where links that are no feet press on ground that stands still."""
    return np.asarray(s.loaded & ~s.is_foot & ~s.on_movable)


def fall(s: Signals) -> Event | None:
    """Return the first sign that a robot with a free base fell: it leans, is low, or lies on a link."""
    if not s.floating or len(s.time) < 2:
        return None
    limits, least = s.limits, s.rows(s.limits.brief)
    lost = (s.com[0] - s.com) @ s.up
    if s.positions.shape[1] and s.loaded.any():
        # over the ground under it, which may slope or step
        under = np.where(s.loaded & ~s.on_movable, s.positions @ s.up, np.inf).min(axis=1, initial=np.inf)
        over = s.com @ s.up - np.where(np.isfinite(under), under, np.inf)
        lost = np.where(np.isfinite(over), s.height - over, 0.0)
    lain = touch_down_of_links(s)
    always = lain[: s.rows(0.05)].any(axis=0)  # what lies on a link from the start has not fallen by it
    signs = {
        "lean": s.lean > limits.lean,
        "low": lost > limits.drop * max(s.height, 1e-3),
        "link": (lain & ~always).any(axis=1),
    }
    at = {name: row for name, sign in signs.items() if (row := s.first(sign, least)) is not None}
    if not at or ("lean" not in at and "low" not in at):
        return None
    row = min(at.values())
    sign = next(name for name in at if at[name] == row)
    link = s.links[int(np.argmax((lain & ~always)[row]))] if sign == "link" else "body"
    words = {
        "lean": f"the base leans by {np.degrees(s.lean[row]):.0f} deg",
        "low": f"the centre of mass is {lost[row]:.2f} m lower, of {s.height:.2f} m",
        "link": f"{link} is on the ground",
    }
    return Event("fell", float(s.time[row]), link, words[sign])


def slide(s: Signals) -> Event | None:
    """Return the first slide of feet that goes on for more than a bit."""
    if s.bolted and s.torques.shape[1]:
        return None  # a hand that slides does not fall
    if not s.sliding.any() or (s.on_movable.any() and not s.torques.shape[1]):
        return None  # what cannot move by itself slides where it is pushed
    if s.thrown:
        return None
    way, found = _slide_ways(s), slid_far(s)
    if found is None:
        return None
    row, k = found
    first = max(row - s.rows(SLIDE_TIME), 0)
    begun = first + int(s.sliding[first : row + 1, k].argmax())
    total = float(way[-1].max())
    return Event("slides", float(s.time[begun]), s.names[k], f"{total:.2f} m with its friction used up")


def _slide_ways(s: Signals) -> FloatArray:
    """Return how far contacts have slid with their friction used up: (T, p) [m]."""
    return np.asarray(np.cumsum(s.slip_speed * s.sliding * s.dt, axis=0))


def slid_far(s: Signals) -> tuple[int, int] | None:
    """Return row and contact of the first slide that is long enough to matter; it began some time before."""
    way, window = _slide_ways(s), s.rows(SLIDE_TIME)
    before = np.concatenate([np.zeros((min(window, len(way)), way.shape[1])), way[:-window]])
    far = np.argwhere(way - before > s.limits.slide)
    return (int(far[0, 0]), int(far[0, 1])) if len(far) else None


def stray(s: Signals) -> Event | None:
    """Return when a robot that is commanded a velocity is no more where that leads, by far."""
    if "command" not in s or not s.floating or s.height <= 0.0:
        return None
    command = s.numbers("command")[:, :2]
    asked = np.einsum("ti,tij->tj", command, s.heading)
    due = np.cumsum(asked * s.dt, axis=0)
    went = s.com - s.com[0]
    off = np.linalg.norm(went - np.outer(went @ s.up, s.up) - due, axis=1)
    path = np.cumsum(np.linalg.norm(command, axis=1) * s.dt)
    row = s.first(off > s.limits.strays * s.height + 0.5 * path, s.rows(s.limits.brief))
    if row is None:
        return _short_way(s, due, went) or _lean_to_the_end(s)
    words = f"it is {off[row]:.2f} m from where its command leads, which is {path[row]:.2f} m away"
    return Event("strays", float(s.time[row]), "body", words)


def _short_way(s: Signals, due: FloatArray, went: FloatArray) -> Event | None:
    """Return that less than half of a way of some length, (T, 3) due and gone, has been gone in the end."""
    length = float(np.linalg.norm(due[-1]))
    if length < s.limits.strays * s.height or float(went[-1] @ due[-1]) > 0.5 * length**2:
        return None
    gone = float(went[-1] @ due[-1]) / length
    words = f"it has gone {gone:.2f} m of the {length:.2f} m that its command leads"
    return Event("strays", float(s.time[-1]), "body", words)


def _lean_to_the_end(s: Signals) -> Event | None:
    """Return since when a robot leans until the end, if it does."""
    upright = s.lean < s.limits.crooked
    row = len(upright) - int(np.argmax(upright[::-1]))
    if not upright.any() or (len(upright) - row) * s.dt < s.limits.lies:
        return None
    words = f"the base leans by {np.degrees(s.lean[row:].mean()):.0f} deg to the end"
    return Event("stands crooked", float(s.time[row]), "body", words)
