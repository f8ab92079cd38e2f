"""Whether momentum, its rate, the centre of mass and the forces of a log are of one motion.

Of whatever a robot is made, over a row of h seconds

    P' = P + h dP/dt,     m (c' - c) = h (P + P') / 2 + a h dP/dt h / 2,     |a| <= 1,

with a from the scheme: 1 where a step moves by the velocity after it (symplectic Euler), -1 by the one before
it, 0 for the trapezium. dP/dt is what forces and weight allow, so half of h times that is all that a scheme
may differ by, at any rate. What lies between the ends of a row, limbs that swing at w on a lever l, adds
l w² h² / 2 to a way, and l w dw to a velocity. No limit here is made from what is judged.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.windows import sliding_mean, sliding_sum
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Measured, Rows, on_body, over
from surefoot.records.audit.within_row import edges, moved_moment, rigid, step_of, swing, turn_speed, turns_of
from surefoot.records.log import Log


def momentum(rows: Rows) -> Measured:
    """Return how far momentum is beside its rate in the column of the body: (T, p + 1) [m/s]."""
    limits, w = rows.setting.limits, rows.window(rows.setting.limits.balance.smooth)
    slips = np.zeros((rows.count, 6))
    rate, dt = step_of(rows, rows.numbers("momentum_rate")), rows.dt[:, None]
    slips[:-1] = np.diff(rows.numbers("momentum"), axis=0) - dt[:-1] * rate[:-1]
    off, turned = (np.linalg.norm(sliding_sum(part, w), axis=1) for part in (slips[:, :3], slips[:, 3:]))
    arm = limits.balance.arm / limits.balance.force
    value = np.fmax(off, turned / arm) / _mass(rows)
    # limbs swing on while they are thrown: l w dw is no rate of a row's start
    spin = turn_speed(rows)
    spin = 0.5 * (spin + np.append(spin[1:], spin[-1:]))  # the mean of a row: one at rest is thrown, too
    thrown = limits.continuity.lever * spin * _spin_change(rows)
    thrown += _turned_within(rows) / arm
    allowed = limits.consistency.impulse * _pushing(rows) * rows.dt / _mass(rows) + thrown
    return over(on_body(rows, value), on_limit(rows, sliding_sum(allowed, w)))


def centre_of_mass(rows: Rows) -> Measured:
    """Return how far the centre of mass is beside its momentum: (T, p + 1), in the body's column [m]."""
    limits, w, dt = rows.setting.limits, rows.window(rows.setting.limits.consistency.time), rows.dt[:, None]
    velocity, com = rows.numbers("momentum")[:, :3] / _mass(rows), rows.numbers("com")
    slips, mean = np.zeros((2, rows.count, 3))
    mean[:-1] = 0.5 * dt[:-1] * (velocity[1:] + velocity[:-1])
    went = np.diff(com, axis=0, append=com[-1:])
    slips[:-1] = went[:-1] - mean[:-1]
    scheme = np.zeros_like(slips)
    force = net_force(rows)
    if force is not None:
        scheme[:-1] = 0.5 * dt[:-1] ** 2 * force[:-1] / _mass(rows)
    off, most = sliding_sum(slips, w), sliding_sum(scheme, w)
    share = (off * most).sum(axis=1) / np.maximum((most**2).sum(axis=1), 1e-30)
    value = np.linalg.norm(off - np.clip(share, -1.0, 1.0)[:, None] * most, axis=1)
    way = np.minimum(*(sliding_sum(np.linalg.norm(part, axis=1), w) for part in (went, mean)))
    known = swing(rows) + edge_forces(rows) / _mass(rows)
    within = 0.5 * rows.dt**2 * (known if force is not None else _pushing(rows) / _mass(rows))
    if rows.setting.means:  # stages go on by velocities between, and beside, those at the ends of a row
        change = np.linalg.norm(np.diff(velocity, axis=0, append=velocity[-1:]), axis=1)
        within = within + 0.5 * rows.dt * change
    limit = limits.consistency.way + limits.consistency.drift * way + sliding_sum(within, w)
    return over(on_body(rows, value), on_limit(rows, limit))


def acceleration(rows: Rows) -> Measured:
    """Return the force that the centre of mass misses: (T, p + 1), in the column of the body [N].

    Second differences of places over a time T, m (c(t + T) - 2 c(t) + c(t - T)) / T², are means of the force,
    weighted by a triangle over both sides; which of two rows a force moves is the scheme's.
    """
    force, limits, weight = net_force(rows), rows.setting.limits, rows.setting.weight
    w = max(1, min(rows.window(limits.consistency.time), (rows.count - 1) // 2))
    value, limit = np.zeros(rows.count), np.full(rows.count, np.inf)
    if force is None or rows.count < 2 * w + 2:
        return over(on_body(rows, value), limit[:, None])
    com, mid = rows.numbers("com"), slice(w, rows.count - w)
    bend = (com[2 * w :] - 2.0 * com[mid] + com[: -2 * w]) * (_mass(rows) / (w * rows.setting.dt) ** 2)
    mean = _triangle(force, w)
    off, late = bend - mean[mid], mean[w - 1 : rows.count - w - 1] - mean[mid]
    share = (off * late).sum(axis=1) / np.maximum((late**2).sum(axis=1), 1e-30)
    value[mid] = np.linalg.norm(off - np.clip(share, 0.0, 1.0)[:, None] * late, axis=1)
    even = np.abs(rows.dt / rows.setting.dt - 1.0) < limits.records.same_dt
    known = sliding_sum((~even).astype(np.float64), 2 * w + 2) == 0.0
    swung = swing(rows) * _mass(rows) / w
    late_touch = 0.5 * sliding_sum(edge_forces(rows), 2 * w + 1) / w**2
    limit[known] = (limits.balance.force * weight + sliding_max(swung, w) + late_touch)[known]
    return over(on_body(rows, value), on_limit(rows, limit))


def pressing(rows: Rows) -> Measured:
    """Return the moment that forces at their contact points lack: (T, p + 1), in the body's column [N m]."""
    w = rows.window(rows.setting.limits.balance.smooth)
    value = np.linalg.norm(sliding_mean(rows.left_over[:, 3:], w), axis=1)
    size = rows.force_sizes.sum(axis=1) + rows.setting.weight
    allowed = rows.setting.limits.consistency.press * size + moved_moment(rows)
    return over(on_body(rows, np.nan_to_num(value)), on_limit(rows, sliding_mean(allowed, w)))


def net_force(rows: Rows) -> FloatArray | None:
    """Return what the log says to act on the whole robot: (T, 3) [N]; None where it does not say."""
    if not rows.has("forces", "normals"):
        return None
    out = np.array(step_of(rows, rows.world_forces.sum(axis=1)))
    out += rows.setting.weight / GRAVITY * np.asarray(rows.log.facts.get("gravity", (0.0, 0.0, -GRAVITY)))
    if "wrench_applied" in rows.log:
        out += rows.numbers("wrench_applied")[:, :3]
    elif "push" in rows.log:
        out += rows.numbers("push")
    if "free_wrenches" not in rows.log.facts:
        return out
    free = np.asarray(rows.log.facts["free_wrenches"])[:, :3]
    return np.asarray(out @ free.T @ free)


def edge_forces(rows: Rows) -> FloatArray:
    """Return the forces that begin or end within their rows, nobody knows when: (T,) [N]."""
    if not rows.has("forces"):
        return np.zeros(rows.count)
    return np.asarray((step_of(rows, rows.force_sizes) * edges(rows)).sum(axis=1))


def uneven(log: Log, setting: Setting) -> str:
    """Return why the acceleration of the centre of mass cannot be judged; empty where it can."""
    if len(log) < 6:
        return "too few rows"
    most = setting.limits.consistency.time
    if setting.dt > most:
        return (
            f"cannot tell at this rate: rows are {1e3 * setting.dt:.3g} ms apart, {1e3 * most:.3g} ms could"
        )
    return ""


def _mass(rows: Rows) -> float:
    return rows.setting.weight / GRAVITY


def _pushing(rows: Rows) -> FloatArray:
    """Return the sum of all forces' sizes and the weight: (T,) [N]."""
    out = np.full(rows.count, rows.setting.weight)
    if rows.has("forces"):
        out += rows.force_sizes.sum(axis=1)
    if "wrench_applied" in rows.log:
        out += np.linalg.norm(rows.numbers("wrench_applied")[:, :3], axis=1)
    return out


def _turned_within(rows: Rows) -> FloatArray:
    """Return what a turn within a row makes of the angular velocity, on the arm of contacts: (T,) [m²/s].

    Of a body whose inertia is m r² at most, r the arm of its contacts: h w (r² w h w / 2 + h r f / m).
    """
    if not rows.has("contact_positions", "forces") or "com" not in rows.log:
        return np.zeros(rows.count)
    arm = float(np.where(rows.loaded, rows.arms, 0.0).max(initial=0.0))
    turn = turn_speed(rows) * rows.dt
    moment = rows.dt * arm * (_pushing(rows) - rows.setting.weight) / _mass(rows)
    return np.asarray(turn * (0.5 * arm**2 * turn_speed(rows) * turn + moment))


def _spin_change(rows: Rows) -> FloatArray:
    """Return the change of the fastest turn over each row: (T,) [rad/s]; zero of one body."""
    turns = turns_of(rows)
    if rigid(rows.log):
        return np.zeros(rows.count)
    change = np.abs(np.diff(turns, axis=0, append=turns[-1:]))
    return np.asarray(change.max(axis=1, initial=0.0))


def _triangle(values: FloatArray, rows: int) -> FloatArray:
    """Return means of (T, c) values by a triangle of so many rows on either side of each: (T, c)."""
    from scipy.ndimage import convolve1d

    sides = np.concatenate([np.arange(1, rows + 1), np.arange(rows - 1, 0, -1)]) / rows**2
    return np.asarray(convolve1d(values, sides, axis=0, mode="constant"))


def sliding_max(values: FloatArray, rows: int) -> FloatArray:
    """Return the highest of (T,) values in so many rows on either side of each: (T,)."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(values, 2 * rows + 1, mode="nearest"))


def on_limit(rows: Rows, limit: FloatArray) -> FloatArray:
    """Return (T,) limits of the body in the last of p + 1 columns, the contacts' infinite."""
    out = np.full((rows.count, rows.points + 1), np.inf)
    out[:, -1] = limit
    return out
