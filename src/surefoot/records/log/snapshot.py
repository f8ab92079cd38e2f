"""What a picture of a log shows at an instant: pose, contact frames and friction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, rotation_from_normal
from surefoot.records.log.log import Log


def pose_of(log: Log) -> Any:
    """Return the base's (T, 7) position and quaternion x, y, z, w; None where the log has none."""
    if "q" in log and log["q"].shape[1] >= 7:
        return log["q"][:, :7]
    if "base_position" in log and "base_orientation" in log:
        return np.hstack([log["base_position"], log["base_orientation"]])
    return None


def weight_of(log: Log) -> float:
    """Return m g [N]; the largest force where the log does not tell the mass."""
    weight = float(log.facts.get("mass", 0.0)) * GRAVITY
    if weight or "forces" not in log:
        return weight or 1.0
    return max(float(np.nan_to_num(log["forces"]).max(initial=0.0)), 1.0)


def contact_names(log: Log) -> list[str]:
    """Return a name for each contact point, see `point_names`; numbers where the log names no feet."""
    count = next((log[n].shape[1] for n in ("forces", "gaps") if n in log), 0)
    owner, feet = log.facts.get("contact_foot"), log.facts.get("feet")
    if owner is None or feet is None or np.size(owner) != count:
        return [f"contact {k}" for k in range(count)]
    return point_names(feet, np.atleast_1d(owner).astype(int).tolist())


def point_names(feet: Sequence[object], owner: Sequence[int]) -> list[str]:
    """Return the names of the feet of contact points, with a number where a foot has several."""
    names = [str(feet[k]) for k in owner]
    return [n if names.count(n) == 1 else f"{n}:{names[:k].count(n)}" for k, n in enumerate(names)]


def frames_of(log: Log, row: int) -> FloatArray:
    """Return the contact frames of a row, those of level ground where the log has none: (p, 3, 3)."""
    out = np.tile(np.eye(3), (len(contact_names(log)), 1, 1))
    if "normals" in log:
        for k, normal in enumerate(log["normals"][row]):
            size = float(np.linalg.norm(normal))
            if 0.0 < size < math.inf:
                out[k] = rotation_from_normal(normal / size)
    return out


def friction_of(log: Log, row: int) -> FloatArray:
    """Return the friction under every contact, infinite where the log does not tell it: (p,)."""
    if "contact_friction" in log:
        mu = np.asarray(log["contact_friction"][row], dtype=np.float64)
    else:
        mu = np.full(len(contact_names(log)), float(log["mu"][row]) if "mu" in log else math.inf)
    return np.where(np.isfinite(mu) & (mu >= 0.0), mu, math.inf)
