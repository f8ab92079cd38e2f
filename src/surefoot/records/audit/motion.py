"""What a log says about the motion: where feet are loaded and slide, how the body turns and moves."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.loaded import loaded_feet
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion
from surefoot.records.audit.continuity import free_base
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.log import Log


def foot_forces(log: Log) -> FloatArray:
    """Return the measured force on every foot, its contact points added up: (T, n, 3) [N]."""
    owner = log.fact("contact_foot")
    feet = range(len(log.fact("feet")))
    return np.stack([log["forces"][:, owner == k].sum(axis=1) for k in feet], axis=1)


def touching(log: Log) -> BoolArray:
    """Return which feet bear weight: (T, n)."""
    return loaded_feet(foot_forces(log)[..., 2], log.fact("mass") * GRAVITY)


def slips(log: Log, limits: AuditLimits = LIMITS) -> FloatArray:
    """Return how far each contact point has slid since it was last commanded to push: (T, p) [m].

    Integrates the velocity of the foot's material at the contact while loaded, so that rolling is no
    slip and a foot that hops while it slides is not forgiven; zero for a foot in the air on purpose.
    Limits say what is loaded.
    """
    weight = log.fact("mass") * GRAVITY
    loaded = loaded_feet(log["forces"][..., 2], weight, limits.laws.loaded)
    travel = np.cumsum(np.where(loaded[..., None], log["contact_velocities"][..., :2], 0.0), axis=0)
    travel *= log.fact("dt")
    active = np.asarray(log["active"])
    before = np.vstack([np.zeros((1, active.shape[1]), dtype=bool), active[:-1]])
    steps = np.arange(len(log))[:, None]
    # The row in which each contact was last commanded anew; its travel is the zero of the slip.
    since = np.maximum.accumulate(np.where(active & ~before, steps, 0), axis=0)
    start = np.take_along_axis(travel, np.repeat(since[..., None], 2, axis=2), axis=0)
    return np.where(active, np.linalg.norm(travel - start, axis=-1), 0.0)


def finite(log: Log) -> bool:
    """Return whether every state, torque and contact of a log is a finite number."""
    names = ("q", "v", "torques", "forces", "gaps", "contact_velocities", "contact_positions")
    return all(bool(np.isfinite(piece[name]).all()) for piece in log.chunks() for name in names)


def tilt_angles(q: FloatArray) -> FloatArray:
    """Return the turn of the base since the first row of (T, nq) configurations: (T,) [rad]."""
    R = rotation_from_quaternion(q[:, 3:7])
    trace = np.einsum("ij,tij->t", R[0], R)
    # from the chord, which keeps its digits near zero: ||R - R0||² = 2 (3 - trace)
    return np.asarray(2.0 * np.arcsin(np.clip(np.sqrt(np.maximum(3.0 - trace, 0.0)) / 2.0, 0.0, 1.0)))


def heading_velocity(log: Log) -> FloatArray:
    """Return the base's velocity in its heading frame: (T, 3) forward, left [m/s], yaw rate [rad/s].

    Of a robot without a free base, whose q has no orientation, it is that of all its mass along x and y.
    """
    if not free_base(np.asarray(log["q"][:1]), np.asarray(log["v"][:1])):
        out = np.zeros((len(log), 3))
        out[:, :2] = log["momentum"][:, :2] / float(log.fact("mass"))
        return out
    R = rotation_from_quaternion(log["q"][:, 3:7])
    linear = np.einsum("tij,tj->ti", R, log["v"][:, :3])
    angular = np.einsum("tij,tj->ti", R, log["v"][:, 3:6])
    yaw = np.arctan2(R[:, 1, 0], R[:, 0, 0]) + float(log.facts.get("ahead", 0.0))
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack(
        [c * linear[:, 0] + s * linear[:, 1], -s * linear[:, 0] + c * linear[:, 1], angular[:, 2]]
    )


def commanded_excess(log: Log) -> FloatArray:
    """Return how far commanded forces lie outside the controller's cones: (T, p) [N], zero inside."""
    f = log["forces_commanded"]
    return np.asarray(np.maximum(np.hypot(f[..., 0], f[..., 1]) - log.fact("mu_controller") * f[..., 2], 0.0))
