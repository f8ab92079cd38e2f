"""What a walk came to: velocity tracking, footfalls, commanded and measured forces, and a verdict."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.simulation.log import Log
from surefoot.simulation.summary import measured, summarise
from surefoot.spatial import GRAVITY, rotation_from_quaternion

SETTLED = 2.0
"""Time after which the velocity should be the commanded one [s]."""
TRACKING_SHARE = 0.1
"""The mean velocity counts as the commanded one within this share of it ..."""
TRACKING_FLOOR = 0.03
"""... or within this, for components that should be small [m/s, rad/s]."""
AXES = ("forward", "left", "turn")
FOLLOWED_SHARE = 0.5
"""A robot that misses more than this share of the commanded velocity did not walk as it was told ..."""
FOLLOWED_FLOOR = 0.05
"""... unless it misses less than this [m/s, rad/s]."""


def heading_velocity(log: Log) -> FloatArray:
    """Return the base's velocity in its heading frame: (T, 3) forward, left [m/s], yaw rate [rad/s]."""
    R = rotation_from_quaternion(log["q"][:, 3:7])
    linear = np.einsum("tij,tj->ti", R, log["v"][:, :3])
    angular = np.einsum("tij,tj->ti", R, log["v"][:, 3:6])
    yaw = np.arctan2(R[:, 1, 0], R[:, 0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack(
        [c * linear[:, 0] + s * linear[:, 1], -s * linear[:, 0] + c * linear[:, 1], angular[:, 2]]
    )


def commanded_excess(log: Log) -> FloatArray:
    """Return how far commanded forces lie outside the controller's cones: (T, p) [N], zero inside."""
    f = log["forces_commanded"]
    return np.asarray(
        np.maximum(np.hypot(f[..., 0], f[..., 1]) - log.facts["mu_controller"] * f[..., 2], 0.0)
    )


def touching(log: Log) -> BoolArray:
    """Return which feet carry more than 2 % of the weight: (T, n)."""
    owner = np.asarray(log.facts["contact_foot"])
    feet = range(len(log.facts["feet"]))
    normal = np.stack([log["forces"][:, owner == k, 2].sum(axis=1) for k in feet], axis=1)
    return np.asarray(normal > 0.02 * log.facts["mass"] * GRAVITY)


def summarise_walk(log: Log) -> dict[str, Any]:
    """Return the summary of a walk, ready for JSON.

    The keys of `surefoot.simulation.summary.summarise` that fit, and: walked (to the end, at half of the
    commanded velocity at least; the outcome is "did not follow" if it was slower), velocity (per axis:
    commanded and measured mean after `SETTLED` seconds, error, within), commanded_cone_excess [N],
    footfalls per foot, duty per foot, distance [m], tilt_max_deg.
    """
    out = summarise(log)
    for key in ("stood", "base", "attained_share", "normal_force_total_mean"):
        out.pop(key)
    ended = str(log.facts["outcome"]) if measured(log) else "invalid"
    out["velocity"] = _tracking(log)
    done = "walked" if _followed(out["velocity"]) else "did not follow"
    out["outcome"] = done if ended == "done" else ended
    out["walked"] = out["outcome"] == "walked"
    out["gait"] = log.facts["gait"]
    out["commanded_cone_excess"] = float(commanded_excess(log).max())
    out["feasible_share"] = float(np.mean(log["attained"]))
    q = log["q"]
    up = rotation_from_quaternion(q[:, 3:7])[:, :, 2]
    out["tilt_max_deg"] = float(np.degrees(np.arccos(np.clip(up[:, 2].min(), -1.0, 1.0))))
    out["distance"] = float(np.linalg.norm(np.diff(q[:, :2], axis=0), axis=1).sum())
    out["climb"] = float(q[-1, 2] - q[0, 2])
    down = touching(log)
    falls = (down[1:] & ~down[:-1]).sum(axis=0)
    for k, foot in enumerate(out["feet"]):
        foot["footfalls"], foot["duty"] = int(falls[k]), float(down[:, k].mean())
    out["notes"] = list(log.facts.get("notes", []))
    return out


def _tracking(log: Log) -> dict[str, Any]:
    """Return the mean velocities after the start, against the commanded ones."""
    late = log["time"] >= SETTLED
    if not late.any():
        late = np.ones(len(log), dtype=bool)
    wanted, measured = log["command"][late].mean(axis=0), heading_velocity(log)[late].mean(axis=0)
    rows: dict[str, Any] = {}
    for k, axis in enumerate(AXES):
        error = float(measured[k] - wanted[k])
        allowed = max(TRACKING_SHARE * abs(float(wanted[k])), TRACKING_FLOOR)
        rows[axis] = {
            "commanded": float(wanted[k]),
            "measured": float(measured[k]),
            "error": error,
            "within": bool(abs(error) <= allowed),
        }
    rows["within"] = all(rows[axis]["within"] for axis in AXES)
    return rows


def _followed(velocity: dict[str, Any]) -> bool:
    """Tell whether the mean velocity is what was commanded by half at least, along the ground and turning."""
    for axes in (("forward", "left"), ("turn",)):
        wanted = float(np.linalg.norm([velocity[axis]["commanded"] for axis in axes]))
        missed = float(np.linalg.norm([velocity[axis]["error"] for axis in axes]))
        if missed > max(FOLLOWED_SHARE * wanted, FOLLOWED_FLOOR):
            return False
    return True
