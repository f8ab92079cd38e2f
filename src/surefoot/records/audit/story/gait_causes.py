"""Causes that lie in a gait: feet that land elsewhere or later than so far, stances that last too long.

A gait repeats itself, so that a foot's own landings tell where it belongs: in front of the centre of mass by
so much, after a swing of so long. What a changed velocity asks of a foothold (half of the way of a stance,
and a part to slow down) is no misplacement.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import joined_runs
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals

REACH = 0.8
"""Way over its height that a body goes in a stance on a leg 8 % longer, between both ends of its reach."""


class Landing(NamedTuple):
    """A foot that lands: rows of its lift and landing, and the foothold and velocity (2,) [m, m/s].

    Both are along the body's heading and across it; the foothold is seen from the centre of mass.
    """

    lifted: int
    row: int
    place: FloatArray
    velocity: FloatArray


def landings(s: Signals) -> dict[str, list[Landing]]:
    """Return link to its landings after swings of 50 ms or more, by time."""
    out = {}
    for link, down in s.feet_down.items():
        mine = s.ground_feet & np.array([x == link for x in s.links])
        out[link] = [_landing(s, mine, start, end, s.heading[end]) for start, end in _swings(s, down)]
    return out


def _swings(s: Signals, down: BoolArray) -> list[tuple[int, int]]:
    """Return the rows of lift and landing of swings of more than 50 ms; loads of less than 20 ms are none."""
    least = s.rows(0.02)
    stances = [(a, b) for a, b in joined_runs(down, least) if b - a >= least]
    first = [(0, stances[0][0])] if stances and stances[0][0] > 0 else []
    found = [*first, *((lifted, landed) for (_, lifted), (landed, _) in pairwise(stances))]
    return [(lifted, landed) for lifted, landed in found if (landed - lifted) * s.dt > 0.05]


def _landing(s: Signals, mine: BoolArray, lifted: int, row: int, turn: FloatArray) -> Landing:
    on = mine & s.loaded[row]
    place = s.positions[row][on].mean(axis=0) - s.com[row]
    return Landing(lifted, row, turn @ place, turn @ s.com_velocity[row])


def walks(s: Signals, until: int | None = None) -> bool:
    """Return whether a foot ever lands after a swing, before a row if one is given."""
    end = len(s.time) if until is None else until
    return any(landed < end for down in s.feet_down.values() for _, landed in _swings(s, down))


def left_the_feet(s: Signals) -> int | None:
    """Return the row from which on the capture point stays outside the feet until the end or a fall."""
    outside = np.nan_to_num(s.capture_outside) > 0.02 * max(s.height, 0.1)
    long = [(a, b) for a, b in joined_runs(outside, s.rows(0.05)) if (b - a) * s.dt > 0.1]
    return long[0][0] if long else None


def placement(s: Signals) -> Iterator[Sign]:
    """Yield the foot that lands beside where it landed before, or later than its swings before.

    One foot's wrong step disturbs the others' later ones: told is the one that went wrong first, a foot set
    down elsewhere from its lift on, a late one from when it was due; of those of a moment the worst.
    """
    found: list[tuple[float, Sign]] = []
    for link, landed in landings(s).items():
        for sign in (_late(s, link, landed), beside(s, link, landed)):
            if sign is not None:
                found.append((sign.time if sign.since is None else sign.since, sign))
    first = min((begun for begun, _ in found), default=0.0)
    of_first = [sign for begun, sign in found if begun <= first + s.limits.brief]
    yield from sorted(of_first, key=lambda x: -x.strength)[:1]


def late_catch(s: Signals) -> Iterator[Sign]:
    """Yield a foot whose step did not catch the body: the capture point was out of its reach."""
    row, landed = left_the_feet(s), landings(s)
    if row is None or len(landed) < 2 or slow_for_speed(s, row):
        return
    last = [(x.row, link) for link, one in landed.items() for x in one if x.row <= row + s.rows(0.15)]
    if last:
        t, link = max(last)
        words = f"the capture point leaves the feet at {s.time[row]:.2f} s, after {link} has landed"
        yield Sign(float(s.time[t]), link, words, 0.3)


def beside(s: Signals, link: str, landed: list[Landing]) -> Sign | None:
    """Return the first landing of a foot that is far from where it landed before."""
    for k in range(s.limits.landings, len(landed)):
        before = landed[max(0, k - 3) : k]
        middle = np.median([x.place for x in before], axis=0)
        spread = max(float(np.linalg.norm(x.place - middle)) for x in before)
        speed = np.median([x.velocity for x in before], axis=0)
        way = landed[k].place - middle
        amiss = float(np.linalg.norm(way - _way_of_change(way, landed[k].velocity - speed, s.limits.follows)))
        limit = s.limits.beside * s.height + spread
        if amiss > limit:
            words = (
                f"{link} lands {100.0 * float(np.linalg.norm(way)):.0f} cm from where it has landed before "
                f"({100.0 * way[0]:+.0f} cm ahead, {100.0 * way[1]:+.0f} cm to the left)"
            )
            begun = float(s.time[landed[k].lifted])
            return Sign(float(s.time[landed[k].row]), link, words, amiss / limit, begun)
    return None


def _way_of_change(way: FloatArray, change: FloatArray, follows: float) -> FloatArray:
    """Return the part (2,) of a foothold's way that a change of velocity asks for: along it, and so far."""
    size = float(np.linalg.norm(change))
    if size <= 0.0:
        return np.zeros(2)
    along = min(max(float(way @ change) / size, 0.0), follows * size)
    return np.asarray(along * change / size)


def _late(s: Signals, link: str, landed: list[Landing]) -> Sign | None:
    """Return the first landing of a foot that comes later after its lift, or its last landing, than before.

    A foot that scuffs lifts late and swings no longer than before: the time between its landings tells of it.
    """
    rows = np.array([x.row for x in landed])
    lifted = np.array([x.lifted for x in landed])
    since = np.concatenate([[0], rows[:-1]])
    for k in range(s.limits.landings, len(landed)):
        for begun, known in ((lifted, lifted[:k] > 0), (since, since[:k] > 0)):
            before = (rows - begun)[:k][known]
            if len(before) < s.limits.landings - 1:
                continue
            due = int(begun[k] + np.median(before))
            lasts, late = int(rows[k] - begun[k]), (rows[k] - due) * s.dt
            if lasts > s.limits.later * before.max() and late > s.limits.brief:
                words = f"{link} lands {1e3 * late:.0f} ms later than its steps before"
                return Sign(float(s.time[due]), link, words, lasts / float(s.limits.later * before.max()))
    return None


def slow(s: Signals) -> Iterator[Sign]:
    """Yield feet that stay on the ground for so long that the body outruns them."""
    row = left_the_feet(s)
    if next(tips(s), None) is None and row is not None and slow_for_speed(s, row):
        words = f"at {_speed(s, row):.2f} m/s the body outruns feet that stand for {_stance(s, row):.2f} s"
        yield Sign(float(s.time[row]), "body", words, 1.0)


def tips(s: Signals) -> Iterator[Sign]:
    """Yield the first stance on one point, or two feet of several, that lasts until the body tips over."""
    down = s.feet_down
    if not walks(s) and len(down) < 3:
        return
    if len(down) == 1:
        stands, most = [next(iter(down.values()))], "one foot"
        longest = s.limits.tips_on_one * s.pendulum_time
    else:
        stands, most = list(_on_two(list(down.values()))), "two feet"
        longest = s.limits.tips_on_two * s.pendulum_time
    rows = [row for on in stands if (row := s.first(on, s.rows(longest))) is not None]
    if not rows or s.rows(longest) < 2:
        return
    row = min(rows)
    words = f"it stands on {most} for more than {longest:.2f} s, in which it tips over"
    yield Sign(float(s.time[row]), "body", words, 1.0, shown=float(s.time[row]) + longest)


def _on_two(down: list[BoolArray]) -> Iterator[BoolArray]:
    """Yield where (T,) two feet at most stand, of three or more, while two others both stay in the air."""
    if len(down) < 3:
        return
    on = np.stack(down, axis=1)
    few = on.any(axis=1) & (on.sum(axis=1) <= 2)
    for one in range(len(down)):
        for other in range(one):
            yield few & ~on[:, one] & ~on[:, other]


def slow_for_speed(s: Signals, row: int) -> bool:
    """Return whether the body goes farther in a stance, about a row, than legs reach."""
    return walks(s) and _speed(s, row) * _stance(s, row) > REACH * max(s.height, 0.05)


def _speed(s: Signals, row: int) -> float:
    before = slice(max(0, row - s.rows(0.3)), row + 1)
    level = s.com_velocity[before] - np.outer(s.com_velocity[before] @ s.up, s.up)
    return float(np.linalg.norm(level.mean(axis=0)))


def _stance(s: Signals, row: int) -> float:
    """Return the mean time on the ground of stances that ended before a row, or are on then [s]."""
    times = [
        (b - a) * s.dt for down in s.feet_down.values() for a, b in joined_runs(down[: row + 1]) if a > 0
    ]
    return float(np.mean(times)) if times else 0.0
