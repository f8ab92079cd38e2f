"""What may happen between the two ends of a row, by the largest second difference that forces allow.

A row holds what is so at its start, and mean forces. When within it a touch began is not known: what falls
freely for an unknown share of it has a velocity that is known to half of g dt, and a place to half of g dt².
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.windows import sliding_sum
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.logged_robot import LoggedRobot
from surefoot.records.audit.rows import Rows
from surefoot.records.log import Log

RIGID = 6
"""Velocity components of a body that has no joints."""


def fall(rows: Rows) -> float:
    """Return the acceleration of what falls freely in the log [m/s²]."""
    return float(np.linalg.norm(rows.log.facts.get("gravity", (0.0, 0.0, -GRAVITY))))


def way_to_touch(rows: Rows) -> FloatArray:
    """Return how far contacts may come nearer to the ground in each row before its force acts: (T, p) [m].

    By the velocity before the force: that of the row, of the row before it where a row has those after it.
    Without velocities by the way of the row before.
    """
    dt = rows.dt[:, None]
    if rows.has("contact_velocities"):
        nearing = np.maximum(-rows.rising, 0.0) * dt
        nearing[1:] = np.maximum(nearing[1:], nearing[:-1])
    else:
        nearing = np.maximum(-np.diff(rows.gaps, axis=0, prepend=rows.gaps[:1]), 0.0)
    return np.asarray(nearing + fall(rows) * dt**2)


def edges(rows: Rows) -> BoolArray:
    """Return over which rows' steps (T, p) loads begin or end: loaded, but not on both sides."""
    loaded = rows.loaded
    inside = loaded.copy()
    inside[1:] &= loaded[:-1]
    inside[:-1] &= loaded[1:]
    return np.asarray(step_of(rows, loaded & ~inside))


def step_of(rows: Rows, values: Any) -> Any:
    """Return (T, ...) values of forces at the rows of their steps: a row earlier where they are late."""
    return np.concatenate([values[1:], values[-1:]]) if rows.setting.late else values


def moved_moment(rows: Rows) -> FloatArray:
    """Return what a turn within a row makes of the contacts' moments about the centre of mass: (T,) [N m].

    The body turns by w h, and its contact points with it. Where forces are means over the row, they are so at
    means of places: weight and contacts go on meanwhile.
    """
    com, place = rows.numbers("com"), rows.numbers("contact_positions")
    size = rows.force_sizes
    out = np.einsum("tp,tp->t", size, rows.arms) * turn_speed(rows) * rows.dt
    if rows.setting.means:
        went, wandered = (np.linalg.norm(np.gradient(part, axis=0), axis=-1) for part in (com, place))
        out = out + (size.sum(axis=1) + rows.setting.weight) * went + (size * wandered).sum(axis=1)
    return np.asarray(out)


def turn_speed(rows: Rows) -> FloatArray:
    """Return the speed at which the fastest part turns, as far as the log tells: (T,) [rad/s]."""
    return np.asarray(np.abs(turns_of(rows)).max(axis=1, initial=0.0))


def swing(rows: Rows) -> FloatArray:
    """Return what limbs on the log's lever accelerate by as they swing: (T,) [m/s²]; zero of one body.

    A limb turns by its joints together: the two fastest turns are added, as of the base and a joint; those at
    the end of a row where they are faster, as a step may move by them.
    """
    if rigid(rows.log):
        return np.zeros(rows.count)
    turns = np.sort(np.abs(turns_of(rows)), axis=1)
    speed = turns[:, -2:].sum(axis=1)
    speed = np.maximum(speed, np.append(speed[1:], speed[-1:]))
    return np.asarray(rows.setting.limits.continuity.lever * speed**2)


def limb_turns(rows: Rows, robot: LoggedRobot) -> FloatArray:
    """Return how far the link of each contact may turn within each row: (T, p) [rad].

    By the base's and its joints' speeds added up, those of slides [m/s] on a lever of one metre.
    """
    speed = np.abs(rows.numbers("v"))
    base = np.linalg.norm(speed[:, 3:6], axis=1)
    limb = speed[:, robot.base_dof :] @ robot.support[:, robot.base_dof :].T.astype(np.float64)
    return np.asarray((base[:, None] + limb) * rows.dt[:, None])


def whirling(rows: Rows, wide: int) -> BoolArray:
    """Return which rows (T,) have one within `wide` in which a joint whirls, see `LoggedRobot.whirls`."""
    return sliding_sum(rows.once(_whirls).astype(np.float64), 2 * wide + 3) > 0.0


def _whirls(rows: Rows) -> BoolArray:
    """Return in which rows a joint whirls: (T,); in none where no robot is known."""
    robot = rows.setting.robot
    if robot is None or "v" not in rows.log:
        return np.zeros(rows.count, dtype=bool)
    return robot.whirls(rows.numbers("v"), rows.dt)


def turns_of(rows: Rows) -> FloatArray:
    """Return the log's angular velocities: (T, k) [rad/s]; of slides their speeds [m/s]."""
    if "v" not in rows.log:
        return np.zeros((rows.count, 0))
    v = rows.numbers("v")
    free = v.shape[1] >= RIGID and ("q" not in rows.log or rows.log["q"].shape[1] == v.shape[1] + 1)
    return v[:, 3:] if free else v


def rigid(log: Log) -> bool:
    """Return whether a log is that of one rigid body: its state has no joints."""
    return {"q", "v"} <= set(log) and log["v"].shape[1] == RIGID and log["q"].shape[1] == RIGID + 1
