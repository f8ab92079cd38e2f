"""What the ground gives back along its normal: a touch never returns more energy than it took.

A force held over a row, f, moves what it acts on from one velocity to the next; the energy that it gives is

    W = f_n dt (v_n + v_n') / 2,

exactly so for an impulse (Stronge's work of the normal force: restitution e <= 1 is sum W <= 0). A contact
that stores energy has taken it before: the sum since touchdown stays below zero at any time.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import releasing_kernel
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.log import Log


def rebound(rows: Rows) -> Measured:
    """Return the energy that touches have given back beyond what they took: (T, p) [J].

    A body on several contacts hands energy from one to another, and from friction to the normal: at fault is
    what all contacts together have given, too, since none was loaded; where that is not among the rows, what
    those have that are loaded now, too. And what the force has given along the gap, where it is known: the
    contact point of a foot that rolls is known to a share of its way only. A foot still in soft ground that
    pushes again has not been away: its touch goes on.
    """
    loaded, dt, after = rows.loaded, rows.dt, rows.setting.after
    limits = rows.setting.limits.rebound
    if rows.has("gaps"):
        loaded = loaded | (rows.gaps < 0.0)
    up = rows.rising
    value, taken = returned_work(rows.normal, up, dt, loaded, after)
    if after is None:  # what is said to be a mean may be either end of it
        for end in (False, True):
            value = np.minimum(value, returned_work(rows.normal, up, dt, loaded, end)[0])
    limit = np.maximum(limits.way * rows.setting.weight, limits.share * taken) + _unloading(rows, loaded)
    any_loaded = rows.over_robot(loaded, np.logical_or)
    chain = _since_touchdown(rows.over_robot(_work(rows), np.add), any_loaded)
    begun = np.logical_or.accumulate(~any_loaded, axis=0)
    normals = rows.over_robot(value, np.add)
    together = np.where(begun, chain, np.minimum(chain, normals))
    if rows.has("gaps"):
        rise = np.diff(rows.gaps, axis=0, append=rows.gaps[-1:])
        along = _since_touchdown(np.where(loaded, rows.normal * rise, 0.0), loaded)
        together = np.minimum(together, along)
    before = np.concatenate([value[:1].repeat(rows.window(limits.return_time), 0), value])[: len(value)]
    returns = (
        value - before > limits.return_share * limit
    )  # the rows that give it back, not the rest of the touch
    return value, limit, (value > limit) & (together > limit) & returns


def throw(rows: Rows) -> Measured:
    """Return the work of touches on contacts that leave faster than the world's law lets them: (T, p) [J].

    By the fact `recoil`, a loaded contact comes out of the ground at no more than so many times the depth to
    which it went in this touch, whatever presses on it; where it slides at v, a convex law opens it by mu v.
    A spring's swing is faster, and what long steps find too late.
    """
    limits, margin = rows.setting.limits, _margin(rows)
    if "recoil" not in rows.log.facts:
        return over(np.zeros(rows.normal.shape), np.inf)
    loaded = rows.loaded | (rows.gaps < margin)
    depth = np.maximum(margin - rows.gaps, 0.0)
    depth = np.maximum(depth, np.append(depth[1:], depth[-1:], axis=0))
    deepest = _peak_since_touchdown(depth, loaded)
    after = rows.setting.after
    first, last = _both_ends(rows.rising, after)
    if after is None:  # a row of means may end unloaded, and be pulled up
        last = np.minimum(last, np.append(last[:1], last[:-1], axis=0))
    recoil = max(float(rows.log.facts["recoil"]), 0.0)
    slides = np.maximum(*(np.hypot(v[..., 0], v[..., 1]) for v in _both_ends(rows.velocities, after)))
    slack = limits.laws.sliding_speed + GRAVITY * rows.dt[:, None]
    fast = last > recoil * deepest + rows.mu * slides + slack
    half = 0.5 * rows.normal * rows.dt[:, None]
    work = half * (np.maximum(first, 0.0) + np.maximum(last, 0.0))
    value = _since_touchdown(np.where(fast & rows.loaded, work, 0.0), loaded)
    taken = -half * (np.minimum(first, 0.0) + np.minimum(last, 0.0))
    taken = _since_touchdown(np.where(rows.loaded, taken, 0.0), loaded)
    limit = np.maximum(limits.rebound.way * rows.setting.weight, limits.rebound.share * taken)
    return value, limit, (value > limit) & fast & rows.loaded


def _margin(rows: Rows) -> FloatArray:
    """Return the gap from which each contact pushes: (p,) or one [m]."""
    return np.asarray(rows.log.facts.get("contact_margin", 0.0), dtype=np.float64)


def _unloading(rows: Rows, loaded: BoolArray) -> FloatArray:
    """Return what soft contacts give back when their load changes: (T, p) [J].

    A contact that is critically damped by its own law throws nothing; but MuJoCo's law sets how it comes out
    of the ground, not the force meanwhile: sunk under little load and left under much it gives up to force
    times depth, and a body on several contacts hands that from one to another.

    In the row in which it opens its force goes on for all of the step, across a gap already.

    `loaded` (T, p) are the touches.
    """
    damped = np.asarray(rows.log.facts.get("critically_damped", np.zeros(rows.points)), dtype=bool)
    if not damped.any() or not rows.has("gaps"):
        return np.zeros(rows.normal.shape)
    force, depth = np.maximum(rows.normal, 0.0), np.maximum(_margin(rows) - rows.gaps, 0.0)
    size = _peak_since_touchdown(force, loaded) * _peak_since_touchdown(depth, loaded)
    size += force * np.maximum(np.append(rows.gaps[1:], rows.gaps[-1:], axis=0) - _margin(rows), 0.0)
    return np.broadcast_to(rows.over_robot(size * damped, np.add), size.shape)


def _peak_since_touchdown(values: FloatArray, loaded: BoolArray) -> FloatArray:
    """Return the highest of (T, p) values >= 0 since each contact was last without load, 0 without it."""
    out = np.empty(values.shape)
    _peaks(values, loaded, out)
    return out


def _work(rows: Rows) -> FloatArray:
    """Return the work of the whole force of every contact in each row: (T, p) [J]."""
    first, last = _both_ends(rows.velocities, rows.setting.after)
    power = reduce(np.add, (rows.forces[..., k] * (first[..., k] + last[..., k]) for k in range(3)))
    work = 0.5 * power * rows.dt[:, None]
    return np.where(rows.loaded, work, 0.0)


def sparse(log: Log, setting: Setting) -> str:
    """Return why touches cannot be judged; empty where rows are close enough."""
    most = setting.limits.rebound.longest_row
    far = (
        f"cannot tell at this rate: rows are {1e3 * setting.dt:.3g} ms apart, a touch is over between two; "
        f"{1e3 * most:.3g} ms could"
    )
    return far if setting.dt > most else ""


def returned_work(
    normal: FloatArray, velocity: FloatArray, dt: FloatArray, loaded: BoolArray, after: bool | None
) -> tuple[FloatArray, FloatArray]:
    """Return the energy given less taken since touchdown, and the energy taken: (T, p) each [J].

    Zero for contacts without load, and in touches whose beginning is not among the rows.

    Parameters
    ----------
    normal, velocity
        (T, p) normal force [N] and velocity along the normal [m/s].
    dt
        (T,) time to the next row [s].
    loaded
        (T, p) where a contact is loaded.
    after
        Whether a row's velocity is that after its force has acted; None for a mean while it acts.
    """
    first, last = _both_ends(velocity, after)
    half = 0.5 * normal * dt[:, None]
    given = np.where(loaded, half * (np.maximum(first, 0.0) + np.maximum(last, 0.0)), 0.0)
    taken = np.where(loaded, -half * (np.minimum(first, 0.0) + np.minimum(last, 0.0)), 0.0)
    if after is False:  # the velocity after the last row is not known
        given[-1:] = taken[-1:] = 0.0
    begun = np.logical_or.accumulate(~loaded, axis=0)
    known = loaded & begun
    return (
        np.where(known, _since_touchdown(given - taken, loaded), 0.0),
        np.where(known, _since_touchdown(taken, loaded), 0.0),
    )


def _both_ends(velocity: FloatArray, after: bool | None) -> tuple[FloatArray, FloatArray]:
    """Return the velocities (T, ...) before and after the force of each row, see `returned_work` [m/s]."""
    if after is None:
        return velocity, velocity
    ends = np.concatenate([velocity[:1], velocity, velocity[-1:]])
    return (ends[:-2], ends[1:-1]) if after else (ends[1:-1], ends[2:])


def _since_touchdown(values: FloatArray, loaded: BoolArray) -> FloatArray:
    """Return the sums of (T, p) values since each contact was last without load, 0 without it."""
    out = np.empty(values.shape)
    _sums(values, loaded, out)
    return out


@releasing_kernel
def _sums(values: FloatArray, loaded: BoolArray, out: FloatArray) -> None:
    """Fill out (T, p) with what `_since_touchdown` returns."""
    for t in range(values.shape[0]):
        for c in range(values.shape[1]):
            before = out[t - 1, c] if t > 0 else 0.0
            out[t, c] = before + values[t, c] if loaded[t, c] else 0.0


@releasing_kernel
def _peaks(values: FloatArray, loaded: BoolArray, out: FloatArray) -> None:
    """Fill out (T, p) with what `_peak_since_touchdown` returns."""
    for t in range(values.shape[0]):
        for c in range(values.shape[1]):
            before = out[t - 1, c] if t > 0 else 0.0
            out[t, c] = max(before, values[t, c]) if loaded[t, c] else 0.0
