"""A proof, in one compiled pass, that rows of contacts break no law that looks at contacts alone.

The audit's measures are taken here in their simplest form, and limits without what the audit adds to them
(velocities that are open, soft contacts that unload, gaps that close within a row): what holds here holds
there. Whatever is not proven is judged by the audit's own functions; no law is called broken here.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.records.audit.batch.row_limits import (
    ALL_LAWS,
    APART,
    BRAKES,
    CONE,
    CONES,
    CREEP,
    CREEPS,
    DEEP,
    DEPTHS,
    DRIVES,
    FALL,
    GAP,
    GAPS,
    LATE,
    LEAST,
    MARGIN,
    MU,
    PULL,
    PULLS,
    RECOIL,
    RETURNS,
    SHARE,
    SINKS,
    SLIDE,
    SLIDES,
    SWINGS,
    THRESHOLD,
    THROWS,
    TOUCHES,
    TURN,
    WEIGHT,
    F,
    V,
)
from surefoot.records.audit.batch.signs_in_rows import SIGN_SPIKE, SIGN_THROW, find_spikes, find_throws
from surefoot.records.audit.slides import WORST, slide_on


@inline_kernel
def _grip(row: FloatArray, at: IntArray) -> float:
    """Return what friction gives against the slip, over the normal force, see `cones.grip`."""
    mu = float(max(row[at[MU]], 0.0))
    if at[TURN] < 0:
        return mu
    x, y = row[at[V]], row[at[V] + 1]
    speed = math.hypot(x, y)
    if not speed > 0.0:
        return mu
    c, s = math.cos(row[at[TURN]]), math.sin(row[at[TURN]])
    return float(mu * max(abs(c * x + s * y), abs(c * y - s * x)) / speed)


@inline_kernel
def _slip(row: FloatArray, later: FloatArray, at: IntArray, dt: float, damping: float, least: float) -> float:
    """Return the share of a row's velocity that is no creep, see `Rows.creep` and `Rows.slip`."""
    x, y = row[at[V]], row[at[V] + 1]
    speed = math.hypot(x, y)
    creep = 0.0
    if damping > 0.0:
        along = ((later[at[V]] - x) * x + (later[at[V] + 1] - y) * y) / max(speed, 1e-300)
        creep = max(row[at[CREEP]], 0.0) / damping + max(-along, 0.0) / dt / damping
    return max(1.0 - max(creep, least) / max(speed, 1e-300), 0.0)


@inline_kernel
def _open_way(table: FloatArray, at: IntArray, dt: FloatArray, c: int, t: int) -> float:
    """Return the change of a contact's velocity along the ground to the next row, as a way [m]."""
    if t < 0 or t + 1 >= len(dt):
        return 0.0
    x = table[t + 1, c, at[V]] - table[t, c, at[V]]
    y = table[t + 1, c, at[V] + 1] - table[t, c, at[V] + 1]
    return float(dt[t] * math.hypot(x, y))


@inline_kernel
def _add_ways(
    table: FloatArray, at: IntArray, dt: FloatArray, c: int, damping: float, swings: IntArray, means: bool,
    limits: FloatArray, spare: FloatArray,
) -> bool:  # fmt: skip
    """Write sums over rows into (rows + 1, 12) `spare`, and return whether the contact ever slips under load.

    Way (two), friction's work, the most of it, what velocities leave open of ways, and of work; then force
    (three), slip (two) and grip of each row, for `slides.slide_on`.
    """
    n, before, slips = len(dt), False, False
    spare[0, :6] = 0.0
    for t in range(n):
        row = table[t, c]
        normal = row[at[F] + 2]
        loaded = normal > limits[THRESHOLD]
        left = _slip(row, table[min(t + 1, n - 1), c], at, dt[t], damping, limits[CREEPS])
        x, y, grip = left * row[at[V]], left * row[at[V] + 1], _grip(row, at)
        on = loaded and (before or t == 0)
        a, b = (x * dt[t], y * dt[t]) if on else (0.0, 0.0)
        way = _open_way(table, at, dt, c, t)
        way = max(way, _open_way(table, at, dt, c, t - 1)) if means else 0.5 * way
        way = way if loaded else 0.0
        spare[t + 1, 0], spare[t + 1, 1] = spare[t, 0] + a, spare[t, 1] + b
        spare[t + 1, 2] = spare[t, 2] + row[at[F]] * a + row[at[F] + 1] * b
        spare[t + 1, 3] = spare[t, 3] + grip * normal * math.hypot(a, b)
        spare[t + 1, 4] = spare[t, 4] + way
        spare[t + 1, 5] = spare[t, 5] + grip * normal * way
        still = swings[t] != 0
        for k in range(3):
            spare[t, 6 + k] = row[at[F] + k]
        spare[t, 9], spare[t, 10], spare[t, 11] = (0.0, 0.0, grip) if still else (x, y, grip)
        slips = slips or (loaded and (x != 0.0 or y != 0.0))
        before = loaded
    return slips


@inline_kernel
def _slides_hold(
    table: FloatArray, at: IntArray, dt: FloatArray, c: int, damping: float, swings: IntArray, means: bool,
    limits: FloatArray, window: int, rules: tuple[float, float, float], spare: FloatArray, state: FloatArray,
) -> bool:  # fmt: skip
    """Return whether work, dissipation and slow slides of one contact hold; `spare` is (rows + 1, 12)."""
    n, open_ = len(dt), 0.0
    if not _add_ways(table, at, dt, c, damping, swings, means, limits, spare):
        return True
    for t in range(n):
        first, end = max(t - (window - 1) // 2, 0), min(t + window // 2 + 1, n)
        way = math.hypot(spare[end, 0] - spare[first, 0], spare[end, 1] - spare[first, 1])
        work, most = spare[end, 2] - spare[first, 2], spare[end, 3] - spare[first, 3]
        unsure = spare[end, 4] - spare[first, 4]
        open_ = max(open_, unsure)
        bound = max(limits[LATE], limits[DRIVES] * most) + max(spare[end, 5] - spare[first, 5], 0.0)
        if not work <= MARGIN * bound:
            return False
        share = min(max((limits[BRAKES] * most + work) / max(most, 1e-12), 0.0), 1.0)
        if most > 0.0 and not way * share <= MARGIN * (limits[SLIDE] + unsure):
            return False
    forces, slips = spare[:n, 6:9].copy().reshape((n, 1, 3)), np.zeros((n, 1, 3))
    grips = spare[:n, 11].copy().reshape((n, 1))
    for t in range(n):
        slips[t, 0, 0], slips[t, 0, 1] = spare[t, 9], spare[t, 10]
    slide_on(state, forces, slips, grips, dt, limits[THRESHOLD], limits[WEIGHT], rules[0], rules[1], rules[2])
    whole = spare[n, 4] if means else open_
    return bool(state[0, WORST] <= MARGIN * (limits[SLIDE] + whole))


@inline_kernel
def _add_unloading(
    table: FloatArray, used: IntArray, at: IntArray, n: int, damped: FloatArray, margins: FloatArray,
    threshold: float,
) -> FloatArray:  # fmt: skip
    """Return what all damped contacts may give back when their load changes (n,) [J]: peak force times depth.

    As the audit's `restitution` counts it.
    """
    out = np.zeros(n)
    for k in range(len(used)):
        force = depth = 0.0
        for t in range(n if damped[k] > 0.0 else 0):
            normal, gap = table[t, used[k], at[F] + 2], table[t, used[k], at[GAP]]
            if not (normal > threshold or gap < 0.0):
                force = depth = 0.0
                continue
            force, depth = max(force, normal), max(depth, margins[k] - gap)
            out[t] += force * depth
    return out


@inline_kernel
def _touches_hold(
    table: FloatArray, at: IntArray, dt: FloatArray, c: int, means: bool, unloads: FloatArray,
    limits: FloatArray,
) -> bool:  # fmt: skip
    """Return whether no touch of a contact gives back more than it took, and what damped ones unload.

    Means may be the velocities at either end of their rows, too: the least of the three counts.
    """
    n, begun, taken = len(dt), False, 0.0
    mean = early = late = 0.0
    for t in range(n):
        row = table[t, c]
        normal, gap = row[at[F] + 2], row[at[GAP]]
        if not (normal > limits[THRESHOLD] or gap < 0.0):
            begun, mean, early, late, taken = True, 0.0, 0.0, 0.0, 0.0
            continue
        if not begun:
            continue
        now, half = row[at[V] + 2], 0.5 * normal * dt[t]
        if t < n - 1:
            late += half * (now + table[t + 1, c, at[V] + 2])
        early += half * (table[max(t - 1, 0), c, at[V] + 2] + now)
        mean += 2.0 * half * now
        value = min(mean, early, late) if means else late
        taken -= 2.0 * half * min(now, 0.0) if means else 0.0
        bound = max(limits[RETURNS], limits[SHARE] * taken) + unloads[t]
        if not value <= MARGIN * bound:
            return False
    return True


@kernel
def rows_hold(
    table: FloatArray, used: IntArray, at: IntArray, dt: FloatArray, swings: IntArray, damping: FloatArray,
    damped: FloatArray, margins: FloatArray, limits: FloatArray, how: tuple[int, bool, bool],
    rules: tuple[float, float, float], states: FloatArray, signs: FloatArray, rows: BoolArray,
) -> int:  # fmt: skip
    """Return which laws (bits) are not proven to hold in all rows; write what signs tell.

    Parameters
    ----------
    table
        (T or more, contacts, fields), of which `used` (k,) are looked at, with columns `at` (6,).
    dt, swings
        (T,) length of each row [s], and whether soft contacts may swing then.
    damping
        (k,) rate at which soft friction brakes [1/s]; 0 for none.
    damped
        (k,) 1 for contacts that are critically damped, else 0.
    margins
        (k,) gaps from which contacts push [m].
    limits, how, rules
        See `limits_of`.
    states
        (k, 9) of `slides.start_slides`; overwritten.
    signs, rows
        (signs, 4) and (signs, T) of `signs_in_rows.start_signs`; written.
    """
    n, spare, open_ = len(dt), np.zeros((len(dt) + 1, 12)), 0
    window, means, touches = how
    unloads = _add_unloading(table, used, at, n, damped, margins, limits[THRESHOLD])
    for k in range(len(used)):
        c, busy = used[k], False
        for t in range(n):
            row = table[t, c]
            x, y, normal, gap = row[at[F]], row[at[F] + 1], row[at[F] + 2], row[at[GAP]]
            tangential = math.hypot(x, y)
            sizes = tangential + normal + gap + row[at[MU]]
            if not math.isfinite(sizes + row[at[V]] + row[at[V] + 1] + row[at[V] + 2]):
                return ALL_LAWS
            if not normal >= -limits[PULL]:
                open_ |= PULLS
            near = max(-row[at[V] + 2], 0.0) * dt[t]
            if t > 0:
                near = max(near, -table[t - 1, c, at[V] + 2] * dt[t - 1])
            near += limits[FALL]
            if not gap >= -limits[SWINGS if swings[t] else DEEP] - (near if limits[SINKS] > 0.0 else 0.0):
                open_ |= DEPTHS
            needed = tangential / max(normal, limits[THRESHOLD])
            if not needed <= limits[CONE] * max(row[at[MU]], limits[LEAST]):
                open_ |= CONES
            acts = max(abs(normal), tangential) > limits[THRESHOLD]
            if acts and not gap <= MARGIN * (limits[APART] + margins[k] + near):
                open_ |= GAPS
            busy = busy or acts or gap < 0.0
        if not busy:
            continue
        if not open_ & SLIDES and not _slides_hold(
            table, at, dt, c, damping[k], swings, means, limits, window, rules, spare, states[k : k + 1]
        ):
            open_ |= SLIDES
        if touches and not open_ & TOUCHES and not _touches_hold(
            table, at, dt, c, means, unloads, limits
        ):  # fmt: skip
            open_ |= TOUCHES
        if limits[RECOIL] < math.inf and not open_ & THROWS and not find_throws(
            table, at, dt, k, c, margins[k], means, limits, signs[SIGN_THROW], rows[SIGN_THROW]
        ):  # fmt: skip
            open_ |= THROWS
    find_spikes(table, used, at, n, limits, signs[SIGN_SPIKE], rows[SIGN_SPIKE])
    return open_


(DEEPEST, LOADED, LOAD, CREPT, FASTEST, FAST_ROW, FAST_CONTACT, ACROSS, TOUCHED) = range(9)
"""Figures of rows: depth [m], whether any contact is loaded, loads [N] and loads times creep [N m/s]; of
touchdowns the highest speed along the normal [m/s], its row and contact, the highest across it [m/s], and the
depth of their first rows [m]."""


@kernel
def read_figures(
    table: FloatArray, used: IntArray, at: IntArray, time: FloatArray, damping: FloatArray, threshold: float,
    hard: float, settling: float, means: bool, swings: IntArray, out: FloatArray,
) -> None:  # fmt: skip
    """Write figures (9,) of rows, and in which of them (T,) soft contacts may swing; see `rows_hold`.

    `hard` is the speed of a touchdown from which they do [m/s], `settling` how long [s].
    """
    n, landed = len(time), -math.inf
    out[:] = 0.0
    for t in range(n):
        for k in range(len(used)):
            row = table[t, used[k]]
            gap, normal, down = row[at[GAP]], row[at[F] + 2], -row[at[V] + 2]
            out[DEEPEST] = max(out[DEEPEST], -gap)
            if normal > threshold:
                out[LOADED] = 1.0
            if normal > 0.0:
                out[LOAD] += normal
                if damping[k] > 0.0:
                    out[CREPT] += normal * row[at[CREEP]] / damping[k]
            if gap > 0.0:
                continue
            if down > hard:
                landed = time[t]
            if t > 0 and table[t - 1, used[k], at[GAP]] <= 0.0:
                continue
            aside = math.hypot(row[at[V]], row[at[V] + 1])
            if means and t > 0:
                old = table[t - 1, used[k]]
                down = max(down, -old[at[V] + 2])
                aside = max(aside, math.hypot(old[at[V]], old[at[V] + 1]))
            out[ACROSS], out[TOUCHED] = max(out[ACROSS], aside), max(out[TOUCHED], -gap)
            if down > out[FASTEST]:
                out[FASTEST], out[FAST_ROW], out[FAST_CONTACT] = down, t, k
        swings[t] = settling > 0.0 and time[t] - landed <= settling
