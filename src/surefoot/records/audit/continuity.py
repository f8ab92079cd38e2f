"""Whether positions, velocities and gaps of a log are those of one motion.

Over any time a configuration changes by the integral of its velocity. Whichever rule a simulator takes,
q' = q + dt v or q' = q + dt v', the trapezium (v + v') / 2 differs from it by half of dt times the change of
velocity, and over any number of rows by no more than that of one.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.numerics.windows import sliding_mean, sliding_sum
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.places import anew
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.audit.within_row import edges, rigid, swing, whirling
from surefoot.records.log import Log

BASE = 7
"""Numbers of a free base in a configuration: place and quaternion (x, y, z, w)."""


def state(rows: Rows) -> Measured:
    """Return the way by which positions are not those that velocities lead to: (T, p + 1) [m]."""
    value, limit = np.zeros((2, rows.count, rows.points + 1))
    q, v = rows.numbers("q"), rows.numbers("v")
    slips = state_slips(q, v, rows.dt, rows.setting.limits.records.unit_quaternion)
    if slips is not None:
        limits = rows.setting.limits.continuity
        scale = levers(q, v, limits.lever)
        w = rows.window(limits.time)
        speed = np.abs(v)
        if free_base(q, v, rows.setting.limits.records.unit_quaternion):  # world's axes, where v has its own
            speed[:, :3] = np.linalg.norm(v[:, :3], axis=1, keepdims=True)
        # what a stop takes a joint back by is no velocity: with it or without it
        off = np.minimum(*(np.abs(sliding_sum(one, w)) for one in (slips, _without_stops(rows, slips, q))))
        off, step = off * scale, speed * scale * rows.dt[:, None]
        # The trapezium may be half a change of velocity off, at most the highest step in the window; the rest
        # is drift.
        bound = limits.way + rows.setting.step_depth + _highest(step, w) + limits.drift * sliding_sum(step, w)
        worst = np.argmax(off / bound, axis=1)[:, None]
        value[:, -1:] = np.take_along_axis(off, worst, axis=1)
        limit[:, -1:] = np.take_along_axis(bound, worst, axis=1)
    return value, limit, value > limit


def _without_stops(rows: Rows, slips: FloatArray, q: FloatArray) -> FloatArray:
    """Return slips (T, nv) without what joints beyond their stops are taken back by, which is no velocity."""
    robot = rows.setting.robot
    if robot is None or q.shape[1] != BASE + robot.joints:
        return slips
    low, high = (
        np.asarray(end)[BASE:] for end in (robot.model.lowerPositionLimit, robot.model.upperPositionLimit)
    )
    out, angles = slips.copy(), q[:, BASE:]
    below, above = np.maximum(low - angles, 0.0), np.maximum(angles - high, 0.0)
    own = out[:, robot.base_dof :]
    own -= np.clip(own, -above, below)
    return out


def gap_rate(rows: Rows) -> Measured:
    """Return the way by which gaps are not those that their contacts' velocities lead to: (T, p) [m]."""
    limits = rows.setting.limits.continuity
    up, w = rows.velocities[..., 2], rows.window(limits.gap_time)
    slips = gap_slips(rows.gaps, up, rows.dt, rows.setting.after)
    value = np.abs(sliding_sum(np.where(anew(rows), 0.0, slips), w))
    if rows.log.facts.get("kind") == "recording":  # gaps of several points of a geom change places
        value[:, [not rows.setting.single(k) for k in range(rows.points)]] = 0.0
    step = np.abs(up) * rows.dt[:, None]
    touched = sliding_sum(np.where(edges(rows), _highest(step, 1), 0.0), w)
    if rows.setting.means:  # a mean of stages is that of no instant
        touched += sliding_sum(np.abs(np.diff(up, axis=0, append=up[-1:])) * rows.dt[:, None], w)
    # a point of a limb that swings goes on along an arc
    touched += sliding_sum(0.5 * rows.dt**2 * swing(rows), w)[:, None]
    limit = limits.gap + _highest(step, w) + touched + limits.drift * sliding_sum(step, w)
    return over(value, np.where(whirling(rows, w)[:, None], np.inf, limit))


def no_plane(log: Log, setting: Setting) -> str:
    """Return why the change of gaps cannot be judged; empty on a plane."""
    return "" if setting.plane else "the ground is not known to be a plane"


def contact_velocity(rows: Rows) -> Measured:
    """Return how far contact velocities are from those of the robot's joints: (T, p) [m/s]."""
    rest, value, limit = rows.unexplained, np.zeros(rows.normal.shape), np.full(rows.normal.shape, np.inf)
    moving = rest.velocities if rest is not None else _of_one_body(rows)
    if moving is not None:
        own, after = np.einsum("tpji,tspj->stpi", rows.frames, moving)
        limits = rows.setting.limits.continuity
        w, off = rows.window(limits.smooth), rows.velocities - own
        # a row may have the velocity before its force, after it, or a mean of both
        change = after - own
        # of a touch within a row of means nobody knows how much of it the change takes
        off = _less_of(off, change, *((-1.0, 2.0) if rows.setting.means else (0.0, 1.0)))
        # what is after it may be so where the row begins, where it ends, or on the way: limbs whirl on
        ahead = np.append(moving[1:, 0], moving[-1:, 1], axis=0)
        there = np.einsum("tpji,tpj->tpi", rows.frames, ahead) - after
        off = _less_of(off, np.nan_to_num(there), 0.0, 1.0)
        value = np.nan_to_num(np.linalg.norm(sliding_mean(off, w), axis=-1))
        size = np.nan_to_num(np.linalg.norm(own, axis=-1))
        limit = limits.velocity + limits.velocity_share * _highest(size, w)
        if rows.setting.means:  # a mean over the part of its row that touches
            touching = sliding_sum(edges(rows).astype(np.float64), w + 2) > 0.0
            open_speed = _highest(np.nan_to_num(np.linalg.norm(change, axis=-1)), w)
            limit = np.where(touching, np.inf, limit + open_speed)
        # against what moves by itself they are not those of the robot's joints
        moves = np.asarray(rows.log.facts.get("contact_other_moves", np.zeros(rows.points))) > 0.0
        limit = np.where(moves | whirling(rows, w)[:, None], np.inf, limit)
    return over(value, limit)


def _less_of(off: FloatArray, part: FloatArray, least: float, most: float) -> FloatArray:
    """Return `off` (..., 3) less that multiple of `part`, within bounds, which leaves least of it."""
    size = np.maximum((part**2).sum(axis=-1), 1e-24)
    share = np.clip((off * part).sum(axis=-1) / size, least, most)
    return np.asarray(off - share[..., None] * part)


def no_kinematics(log: Log, setting: Setting) -> str:
    """Return why contact velocities cannot be held against the state; empty where they can.

    One rigid body on ground that stands still needs no model.
    """
    if not setting.why_no_motion:
        return ""
    if not rigid(log) or "contact_positions" not in log or "normals" not in log:
        return setting.why_no_motion
    if setting.ground is None or any("more bodies move" in line for line in setting.notes):
        return "what the body touches is not known to stand still"
    return ""


def _of_one_body(rows: Rows) -> FloatArray | None:
    """Return the velocities of a rigid body's material at its contact points, see `UnexplainedForces`.

    (T, 2, p, 3) before and after the step to the next row; None for what is not one body.
    """
    if not rigid(rows.log) or not rows.has("contact_positions", "normals"):
        return None
    q, v = rows.numbers("q"), rows.numbers("v")
    R = rotation_from_quaternion(q[:, 3:BASE])
    linear, angular = (np.einsum("tij,tj->ti", R, part) for part in (v[:, :3], v[:, 3:]))
    arm = rows.numbers("contact_positions") - q[:, None, :3]
    out = np.empty((rows.count, 2, *arm.shape[1:]))
    for k, later in enumerate((0, 1)):
        at = np.minimum(np.arange(rows.count) + later, rows.count - 1)
        out[:, k] = linear[at, None] + np.cross(angular[at, None], arm)
    return out


def state_slips(
    q: FloatArray, v: FloatArray, dt: FloatArray, unit: float = LIMITS.records.unit_quaternion
) -> FloatArray | None:
    """Return how far each step of the configuration is from what the velocities say: (T, nv) [m, rad].

    The turn of a free base is in its own axes, its way in the world's. None where the numbers of a
    configuration are neither those of its velocity nor those with a free base. The last row is zero.

    Parameters
    ----------
    q, v
        (T, nq), (T, nv) Pinocchio's order.
    dt
        (T,) time to the next row [s].
    unit
        How far from one a quaternion's length may be [-].
    """
    floating = free_base(q, v, unit)
    if not floating and q.shape[1] != v.shape[1]:
        return None
    out = np.zeros(v.shape)
    step, mean = dt[:-1, None], 0.5 * (v[:-1] + v[1:])
    first = 6 if floating else 0
    out[:-1, first:] = np.diff(q[:, BASE if floating else 0 :], axis=0) - step * mean[:, first:]
    if floating:
        R = rotation_from_quaternion(q[:, 3:BASE])
        world = np.einsum("tij,tj->ti", R, v[:, :3])
        out[:-1, :3] = np.diff(q[:, :3], axis=0) - 0.5 * step * (world[:-1] + world[1:])
        out[:-1, 3:6] = _turns(R) - step * mean[:, 3:6]
    return out


def levers(q: FloatArray, v: FloatArray, lever: float) -> FloatArray:
    """Return the factors (nv,) that make ways of velocity components: `lever` [m/rad] of angles.

    Rows of q are (T, nq), of v (T, nv).
    """
    scale = np.full(v.shape[1], lever)
    scale[: q.shape[1] - v.shape[1] and 3] = 1.0  # of a free base, the place
    return scale


def gap_slips(gaps: FloatArray, velocity: FloatArray, dt: FloatArray, after: bool | None) -> FloatArray:
    """Return how far each step of the gaps is from what the contacts' velocities say: (T, p) [m].

    On a plane, where the contact is the lowest point of a round foot, or a corner. The last row is zero.

    Parameters
    ----------
    gaps, velocity
        (T, p) [m] and their velocity along the normal [m/s].
    dt
        (T,) time to the next row [s].
    after
        Whether a row's velocity is that after its force has acted; None for a mean while it acts.
    """
    out = np.zeros(gaps.shape)
    out[:-1] = np.diff(gaps, axis=0) - dt[:-1, None] * (velocity[1:] if after is False else velocity[:-1])
    return out


def free_base(q: FloatArray, v: FloatArray, unit: float = LIMITS.records.unit_quaternion) -> bool:
    """Return whether rows of configurations (T, nq) and velocities (T, nv) begin with a free base's.

    `unit` is how far from one a quaternion's length may be [-].
    """
    if q.shape[1] < BASE or q.shape[1] != v.shape[1] + 1:
        return False
    return bool(np.abs(np.linalg.norm(q[:, 3:BASE], axis=1) - 1.0).max(initial=0.0) < unit)


def _turns(R: FloatArray) -> FloatArray:
    """Return the turn from each rotation (T, 3, 3) to the next one, in its own axes: (T - 1, 3) [rad]."""
    S = np.einsum("tji,tjk->tik", R[:-1], R[1:])
    sine = 0.5 * np.stack([S[:, 2, 1] - S[:, 1, 2], S[:, 0, 2] - S[:, 2, 0], S[:, 1, 0] - S[:, 0, 1]], axis=1)
    size = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(size, 0.5 * (np.trace(S, axis1=1, axis2=2) - 1.0))
    return np.asarray(sine * np.where(size > 1e-12, angle / np.maximum(size, 1e-12), 1.0)[:, None])


def _highest(values: FloatArray, rows: int) -> FloatArray:
    """Return the highest of (T, c) values in a window of so many steps about each row, both ends of each."""
    from scipy.ndimage import maximum_filter1d

    return np.asarray(maximum_filter1d(values, 2 * (rows // 2) + 3, axis=0, mode="nearest"))
