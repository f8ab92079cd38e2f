"""Episodes of one length as the columns of one log, and what every check found in each of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.records.audit.batch.environments import UNKNOWN_MASS, Environments
from surefoot.records.audit.batch.exploits import EXPLOITS
from surefoot.records.audit.checks import CHECKS, Check
from surefoot.records.audit.coverage import NEVER_LOADED, coverage_of, why_unsure_of
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.audit.log_context import OF_POINTS, Setting, ground_of, setting_of
from surefoot.records.audit.row_velocities import ROWS, velocities_after_each
from surefoot.records.audit.rows import Rows, lacking, pieces
from surefoot.records.audit.slide_count import SlideCount
from surefoot.records.log import Log

SIDE_BY_SIDE = tuple(check for check in CHECKS if check.by_contact)
"""Checks that judge several robots at once."""
_LOST = "numbers that are not finite"


@dataclass(frozen=True)
class Found:
    """What was found in n episodes; C are the checks of `SIDE_BY_SIDE`.

    Attributes
    ----------
    rows
        (n, C) rows of each in which a limit is exceeded.
    value, limit
        (n, C) where that is by most, or where it comes nearest; NaN for what was not judged.
    row, contact
        (n, C) row of the arrays, and contact, of that.
    reward
        (n, C) reward of those rows.
    reasons
        (n,) why one cannot tell whether an episode without such rows is lawful; empty if it is.
    coverage
        (n,) law to the reason why it was not judged.
    """

    rows: IntArray
    value: FloatArray
    limit: FloatArray
    row: IntArray
    contact: IntArray
    reward: FloatArray
    reasons: list[str]
    coverage: list[dict[str, str]]


@dataclass(frozen=True)
class _Alike:
    """Episodes that may be judged together: places (n,), `Setting.after`, and their planes (n, 4) or None."""

    which: IntArray
    after: bool | None
    planes: FloatArray | None


def judge(
    given: Environments, episodes: IntArray, limits: AuditLimits, reward: FloatArray | None
) -> Iterator[tuple[IntArray, Found]]:
    """Yield which of (n, 3) episodes of one length were judged together, and what was found in them.

    `reward` is that of every environment and row (T, N).
    """
    columns = {name: given.columns(name, episodes) for name in given.arrays}
    base = setting_of(given.episode_log(episodes[0]), None, limits)
    for alike in _alike(given, columns, base, episodes):
        mine = {name: array[:, alike.which] for name, array in columns.items()}
        paid = None
        if reward is not None:
            paid = np.stack([reward[a:b, k] for k, a, b in episodes[alike.which].tolist()], axis=1)
        yield alike.which, _judge_columns(given, episodes[alike.which], mine, base, alike, paid)


def _alike(
    given: Environments, columns: dict[str, FloatArray], base: Setting, episodes: IntArray
) -> Iterator[_Alike]:
    """Yield which of n episodes may be judged together.

    Those with numbers that are not finite each alone, and so are single contacts, whose flights are judged;
    the others by what their velocities and their ground are taken to be.
    """
    n = len(episodes)
    alone = np.full(n, given.points == 1)
    for array in columns.values():
        alone |= ~np.isfinite(array).all(axis=(0, *range(2, array.ndim)))
    after = _after(columns, base)
    planes = [_plane(given, episode, base) for episode in episodes] if set(columns) >= _PLACED else [None] * n
    kinds: dict[tuple[int, int, bool], list[int]] = {}
    for k in range(n):
        kinds.setdefault((k if alone[k] else -1, int(after[k]), planes[k] is None), []).append(k)
    for (_, late, flat), which in kinds.items():
        known = None if flat else np.stack([plane for k in which if (plane := planes[k]) is not None])
        yield _Alike(np.array(which), None if base.after is None else bool(late), known)


_PLACED = {"contact_positions", "normals", "gaps"}
"""Channels that show a ground's plane."""


def _after(columns: dict[str, FloatArray], base: Setting) -> BoolArray:
    """Return (n,) what `velocities_after` says of each."""
    n = columns["forces"].shape[1]
    if base.dt <= 0.0 or not {"gaps", "contact_velocities"} <= set(columns):
        return np.zeros(n, dtype=bool)
    parts = (columns["gaps"], columns["contact_velocities"][..., 2], columns["forces"][..., 2])
    gaps, up, normal = (part[:ROWS].reshape(min(ROWS, len(part)), -1) for part in parts)
    return velocities_after_each(gaps, up, normal, base.dt, base.limits.records.clear, n)


def _plane(given: Environments, episode: IntArray, base: Setting) -> FloatArray | None:
    """Return the plane (4,) that an episode's contacts show, None for none."""
    weight = float(given.weights[episode[0]])
    return ground_of(given.episode_log(episode), base.limits, base.sinking, weight)[1]


def _judge_columns(
    given: Environments, episodes: IntArray, columns: dict[str, FloatArray], base: Setting, alike: _Alike,
    reward: FloatArray | None,
) -> Found:  # fmt: skip
    """Judge n episodes whose channels are (L, n, ...), with their reward (L, n)."""
    n = columns["forces"].shape[1]
    log = _wide_log(given, episodes, columns)
    setting = _wide_setting(given, base, alike)
    found = judge_log(log, setting, coverage_of(log, setting), n, reward)
    found.row[:] += episodes[:, 1:2]
    energy = np.array([check.unit in ("N", "J") for check in SIDE_BY_SIDE])
    scale = np.where(energy, given.weights[episodes[:, 0], None], 1.0)
    return replace(found, value=found.value * scale, limit=found.limit * scale)


def judge_log(
    log: Log, setting: Setting, coverage: dict[str, str], n: int, reward: FloatArray | None
) -> Found:
    """Judge a log of n episodes side by side, with their reward (T, n) if there is one; see `Found`."""
    found = start_found(n, coverage)
    slides, loaded, lost = SlideCount(setting), np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    used = [c for c in SIDE_BY_SIDE if not coverage.get(c.name, "") and not lacking(log, c.needs)]
    for rows in pieces(log, setting):
        at = rows.first + rows.core.start
        loaded |= rows.loaded[rows.core].any(axis=0).reshape(n, -1).any(axis=1)
        lost |= rows.not_finite[rows.core].any()
        with np.errstate(over="ignore", invalid="ignore"):
            for check in used:
                take_found(found, check, rows, at, reward)
            if _slides(used):
                slides.add(rows)
    if _slides(used):
        take_slides(found, slides, len(log))
    return replace(found, reasons=reasons_of(setting, coverage, len(log), loaded, lost))


def _slides(used: list[Check]) -> bool:
    return any(check.name == "dissipation" for check in used)


def start_found(n: int, coverage: dict[str, str]) -> Found:
    """Return what was found of n episodes before any row."""
    size = (n, len(SIDE_BY_SIDE))
    whole = [np.zeros(size, dtype=np.int64) for _ in range(3)]
    unknown = [np.full(size, np.nan) for _ in range(2)]
    return Found(
        whole[0], unknown[0], unknown[1], whole[1], whole[2], np.zeros(size), [""] * n, [coverage] * n
    )


def _wide_log(given: Environments, episodes: IntArray, columns: dict[str, FloatArray]) -> Log:
    """Return n episodes as one log, the forces over their robots' weights."""
    length, n = columns["forces"].shape[:2]
    weights = given.weights[episodes[:, 0]]
    arrays = {
        name: array.reshape(length, n * given.points, *array.shape[3:]) for name, array in columns.items()
    }
    arrays["forces"] = (columns["forces"] / weights[:, None, None]).reshape(length, -1, 3)
    # as log_from_arrays counts
    time = given.dt * np.arange(float(given.rows))[episodes[0, 1] : episodes[0, 2]]
    facts = dict(given.facts)
    for name in OF_POINTS:  # one robot's contacts: those of all are alike
        if np.ndim(facts.get(name, 0.0)) > 0:
            facts[name] = np.concatenate([np.asarray(facts[name])] * n)
    return Log({"time": time, **arrays}, facts)


def _wide_setting(given: Environments, base: Setting, alike: _Alike) -> Setting:
    """Return what is known of n episodes as one log, whose weight is one."""
    n, planes = len(alike.which), alike.planes
    ground = None if planes is None else np.repeat(planes, given.points, axis=0)
    named = "terrain" in given.facts and base.plane
    return replace(
        base, names=base.names * n, owner=np.arange(n * given.points), weight=1.0, after=alike.after,
        ground=ground, plane=named or ground is not None, robots=n,
        doubts=base.doubts if given.weighed else (*base.doubts, UNKNOWN_MASS),
    )  # fmt: skip


def take_found(found: Found, check: Check, rows: Rows, first: int, reward: FloatArray | None) -> None:
    """Add what a check finds in a piece whose core begins at row `first` of n episodes.

    `reward` is that of every row and episode (T, n).
    """
    c, n = SIDE_BY_SIDE.index(check), len(found.rows)
    given_value, given_limit, given_bad = check.judge(rows)
    shape = (len(given_bad), n, given_bad.shape[1] // n)
    value, limit, bad = given_value.reshape(shape), given_limit.reshape(shape), given_bad.reshape(shape)
    over = value - limit
    if not (rows.all_finite and np.isfinite(over).all()):
        lost = rows.not_finite[rows.core, :-1].reshape(over.shape)
        over = np.where(lost | np.isnan(over), -np.inf, over)
    robots, most = np.arange(n), reduce(np.maximum, np.moveaxis(over, 2, 0))
    row = most.argmax(axis=0)
    contact = over[row, robots].argmax(axis=1)
    now, before = over[row, robots, contact], found.value[:, c] - found.limit[:, c]
    better = ~(now <= before)
    found.value[better, c] = value[row, robots, contact][better]
    found.limit[better, c] = limit[row, robots, contact][better]
    found.row[better, c], found.contact[better, c] = first + row[better], contact[better]
    if bad.any():
        flagged = reduce(np.logical_or, np.moveaxis(bad, 2, 0))
        found.rows[:, c] += flagged.sum(axis=0)
        if reward is not None:
            found.reward[:, c] += np.where(flagged, reward[first : first + len(flagged)], 0.0).sum(axis=0)


def take_slides(found: Found, slides: SlideCount, length: int) -> None:
    """Add slides that are too long, too slow for a window to show: they last as long as their episode."""
    c = next(k for k, check in enumerate(SIDE_BY_SIDE) if check.name == "dissipation")
    n = len(found.rows)
    ways, most = (part.reshape(n, -1) for part in (slides.ways, slides.limits))
    late = (ways > most) & (found.rows[:, c] == 0)[:, None]
    for k in np.flatnonzero(late.any(axis=1)).tolist():
        contact = int(np.argmax(np.where(late[k], ways[k] - most[k], -np.inf)))
        found.rows[k, c] = length
        found.value[k, c], found.limit[k, c] = ways[k, contact], most[k, contact]
        found.row[k, c], found.contact[k, c] = 0, contact


def reasons_of(
    setting: Setting, coverage: dict[str, str], length: int, loaded: BoolArray, lost: BoolArray
) -> list[str]:
    """Return why one cannot tell of each of n episodes, were no law broken; empty for none.

    `loaded` and `lost` are (n,): whether a contact ever carries, and whether numbers are not finite.
    """
    why = why_unsure_of(setting, coverage, length)
    return [
        _LOST if bad else why or ("" if some else NEVER_LOADED)
        for some, bad in zip(loaded, lost, strict=True)
    ]


def reward_shares(found: Found, reward: FloatArray | None) -> dict[str, float]:
    """Return the shares of a reward (T, n) that came from the rows of exploits; none without one."""
    total = 0.0 if reward is None else float(np.nansum(reward))
    if total == 0.0:
        return {}
    places = {check.name: k for k, check in enumerate(SIDE_BY_SIDE)}
    each = {name: [places[c] for c in checks if c in places] for name, checks in EXPLOITS.items()}
    # the joints' work is no matter of contacts
    return {
        name: _reward_of_most(found.rows[:, at], found.reward[:, at]) / total
        for name, at in each.items()
        if at
    }


def _reward_of_most(rows: IntArray, reward: FloatArray) -> float:
    """Return the reward of n episodes from rows that checks (n, k) find: of each by that which finds most.

    Rewards may be negative: the largest of several checks' would be that of the check that finds nothing.
    """
    most = np.argmax(rows, axis=1)[:, None]
    return float(np.take_along_axis(reward, most, axis=1).sum())
