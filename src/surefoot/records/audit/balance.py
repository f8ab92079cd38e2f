"""Newton and Euler for the whole robot, where its momentum is in the log: no model of it is needed.

    d/dt (p, L) = sum of contact forces and moments + (m g, 0) + the log's pushes, thrust and drag,

L about the centre of mass. What is left over is a force that no contact gave: hidden, or gravity that is
compensated.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.rows import Measured, Rows, on_body, over, sliding_mean
from surefoot.records.audit.within_row import moved_moment


def left_over(rows: Rows) -> FloatArray:
    """Return the wrench about the centre of mass that nothing in the log explains: (T, 6) [N, N m].

    Along what holds the root (a planar robot's bearings) it is zero.
    """
    com, facts = rows.numbers("com"), rows.log.facts
    out = rows.numbers("momentum_rate").copy()
    force = np.einsum("tpij,tpj->tpi", rows.frames, rows.forces)
    arm = rows.numbers("contact_positions") - com[:, None]
    out[:, :3] -= force.sum(axis=1) + rows.setting.weight / GRAVITY * np.asarray(
        facts.get("gravity", (0.0, 0.0, -GRAVITY))
    )
    out[:, 3:] -= np.cross(arm, force).sum(axis=1)
    if "contact_moments" in rows.log:
        out[:, 3:] -= np.einsum("tpij,tpj->ti", rows.frames, rows.numbers("contact_moments"))
    if "wrench_applied" in rows.log:
        out -= rows.numbers("wrench_applied")
    # A planar robot's bearings carry what they like: rows that are not free are projected out.
    free = np.asarray(facts.get("free_wrenches", np.eye(6)))
    return np.asarray(out @ free.T @ free)


def balance(rows: Rows) -> Measured:
    """Return the force that the momentum leaves unexplained, in the column of the body: (T, p + 1) [N]."""
    rest, weight, limits = left_over(rows), rows.setting.weight, rows.setting.limits.balance
    w, long = rows.window(limits.smooth), rows.window(limits.ringing_time)
    force, moment = (np.linalg.norm(sliding_mean(part, w), axis=-1) for part in (rest[:, :3], rest[:, 3:]))
    moment = np.maximum(moment - sliding_mean(moved_moment(rows), w), 0.0)
    rings = np.sqrt(sliding_mean((rest[:, :3] ** 2).sum(axis=1), long))
    value = np.fmax(force, moment * (limits.force / limits.arm))
    value = np.fmax(value, rings * (limits.force / limits.ringing))
    return over(on_body(rows, np.nan_to_num(value)), limits.force * weight)
