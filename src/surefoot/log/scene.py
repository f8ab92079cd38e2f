"""What a picture of a log shows at an instant: pose, forces and cones; for Foxglove and for Rerun."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.log.log import Log
from surefoot.spatial import GRAVITY, rotation_from_normal

SCENE_PERIOD = 0.02
"""Least time between two pictures of the scene [s]."""
ARROW = 0.5
"""Length of a force of m g [m]."""
CONE = 0.1
"""Height at which a friction cone is drawn [m]."""
SEGMENTS = 16
"""Of a cone's rim."""


@dataclass(frozen=True)
class DrawnContact:
    """A contact that carries.

    Attributes
    ----------
    place
        (3,) world axes [m].
    arrow
        (3,) its force, world axes, in lengths of `ARROW` for m g [m].
    rotation, mu
        Contact frame (3, 3), and friction; infinite where the log does not tell it.
    broken
        Whether its force is outside its cone.
    """

    place: FloatArray
    arrow: FloatArray
    rotation: FloatArray
    mu: float
    broken: bool

    def rim(self) -> FloatArray:
        """Return the rim of its cone: (SEGMENTS + 1, 3) [m]; empty without friction."""
        if not math.isfinite(self.mu):
            return np.empty((0, 3))
        angles = 2.0 * np.pi * np.arange(SEGMENTS + 1) / SEGMENTS
        local = np.column_stack([self.mu * np.cos(angles), self.mu * np.sin(angles), np.ones_like(angles)])
        return np.asarray(self.place + CONE * local @ self.rotation.T)

    def cone_lines(self) -> list[FloatArray]:
        """Return its cone as lines (k, 3): the rim, and every other ray."""
        rim = self.rim()
        return [rim, *(np.array([self.place, p]) for p in rim[:-1:2])] if len(rim) else []


def pictures(time: FloatArray) -> Iterator[int]:
    """Yield the rows of (T,) times that are drawn, `SCENE_PERIOD` apart at least."""
    drawn = -math.inf
    for row, now in enumerate(time.tolist()):
        if abs(now - drawn) >= SCENE_PERIOD - 1e-9:
            drawn = now
            yield row


def pose_of(log: Log) -> Any:
    """Return the base's (T, 7) position and quaternion x, y, z, w; None where the log has none."""
    if "q" in log and log["q"].shape[1] >= 7:
        return log["q"][:, :7]
    if "base_position" in log and "base_orientation" in log:
        return np.hstack([log["base_position"], log["base_orientation"]])
    return None


def weight_of(log: Log) -> float:
    """Return m g [N]; the largest force where the log does not tell the mass."""
    told = float(log.facts.get("mass", 0.0)) * GRAVITY
    if told or "forces" not in log:
        return told or 1.0
    return max(float(np.nan_to_num(log["forces"]).max(initial=0.0)), 1.0)


def contact_names(log: Log) -> list[str]:
    """Return a name for each contact point: its foot's, with a number where a foot has several."""
    count = next((log[n].shape[1] for n in ("forces", "gaps") if n in log), 0)
    owner, feet = log.facts.get("contact_foot"), log.facts.get("feet")
    if owner is None or feet is None or np.size(owner) != count:
        return [f"contact {k}" for k in range(count)]
    names = [str(feet[int(k)]) for k in np.atleast_1d(owner)]
    return [n if names.count(n) == 1 else f"{n}:{names[:k].count(n)}" for k, n in enumerate(names)]


def contacts(log: Log, row: int, weight: float) -> Iterator[DrawnContact]:
    """Yield the contacts that carry in a row; none where the log has no places for them."""
    if "forces" not in log or "contact_positions" not in log:
        return
    forces, places = log["forces"][row], log["contact_positions"][row]
    rows = zip(forces, places, frames_of(log, row), friction_of(log, row).tolist(), strict=True)
    for force, place, R, mu in rows:
        if not (np.isfinite(force).all() and np.isfinite(place).all()) or not force.any():
            continue
        broken = math.hypot(force[0], force[1]) > mu * force[2] * (1.0 + 1e-3)
        yield DrawnContact(np.asarray(place), R @ force / weight * ARROW, R, mu, broken)


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
