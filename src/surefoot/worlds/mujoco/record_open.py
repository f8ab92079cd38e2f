"""What contact points of a recording did in steps in which they were open: gap, place and speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import frames_on
from surefoot.worlds.mujoco.record_contact_rows import relative_velocities
from surefoot.worlds.mujoco.record_contacts import Slot

FAR = 1.0
"""Gaps are measured up to here; what is farther apart is as far as that [m]."""
ROWS = 1024
"""Rows that are gone through at once."""


class OpenContacts:
    """Goes through the configurations of a recording again, in data of its own.

    Parameters
    ----------
    mujoco, model
        The module and the model.
    slots
        The contact points.
    """

    def __init__(self, mujoco: Any, model: Any, slots: Sequence[Slot]) -> None:
        self._mujoco, self._model, self._slots = mujoco, model, slots
        self._data = mujoco.MjData(model)

    def fill(self, qpos: FloatArray, qvel: FloatArray, points: dict[str, Any]) -> None:
        """Write what is known of open contact points into a recording of (T, nq) and (T, nv) rows."""
        friction = points["contact_friction"]
        known = np.array([slot.friction for slot in self._slots])
        points["contact_friction"] = np.where(np.isnan(friction), known, friction)
        finite = np.isfinite(qpos).all(axis=1) & np.isfinite(qvel).all(axis=1)
        rows = np.flatnonzero(np.isnan(points["gaps"]).any(axis=1) & finite)
        for first in range(0, len(rows), ROWS):
            self._fill_rows(rows[first : first + ROWS].tolist(), qpos, qvel, points)

    def _fill_rows(self, rows: list[int], qpos: FloatArray, qvel: FloatArray, points: dict[str, Any]) -> None:
        """Fill some rows: places and gaps one by one, speeds together."""
        mujoco, model, data, gaps = self._mujoco, self._model, self._data, points["gaps"]
        cvel, centres = (np.zeros((len(rows), *a.shape)) for a in (data.cvel, data.subtree_com))
        at: list[tuple[int, int, int]] = []
        for i, t in enumerate(rows):
            data.qpos[:], data.qvel[:] = qpos[t], qvel[t]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            cvel[i], centres[i] = data.cvel, data.subtree_com
            missing = np.isnan(gaps[t]).tolist()
            closed = {self._slots[k].pair: k for k in range(len(missing) - 1, -1, -1) if not missing[k]}
            for k in (k for k, gone in enumerate(missing) if gone):
                slot = self._slots[k]
                partner = closed.get(slot.pair)
                if partner is None:
                    place, normal, gap = self._apart(slot)
                else:
                    place, normal, gap = self._beside(slot, partner, t, points)
                points["contact_positions"][t, k], points["normals"][t, k], gaps[t, k] = place, normal, gap
                at.append((i, t, k))
        row, time, slot_of = np.array(at).T
        velocities = relative_velocities(
            model, SimpleNamespace(cvel=cvel, subtree_com=centres), row,
            np.array([slot.pair for slot in self._slots])[slot_of],
            points["contact_positions"][time, slot_of],
        )  # fmt: skip
        frames = frames_on(points["normals"][time, slot_of])
        points["contact_velocities"][time, slot_of] = np.einsum("cji,cj->ci", frames, velocities)

    def _apart(self, slot: Slot) -> tuple[FloatArray, FloatArray, float]:
        """Return the nearest point of the robot's geom, the direction to it, and the gap."""
        (geom, other), segment = slot.pair, np.zeros(6)
        try:
            gap = float(self._mujoco.mj_geomDistance(self._model, self._data, other, geom, FAR, segment))
        except Exception:  # MuJoCo's own error for shapes that it cannot measure
            gap = FAR
        way = segment[3:] - segment[:3]
        size = math.sqrt(float(way @ way))
        if gap >= FAR:
            return self._point(slot), np.array([0.0, 0.0, 1.0]), gap
        if size < 1e-12:  # they just touch, and what touches later may be far from here
            return segment[3:], self._plane_normal(other), gap
        return segment[3:], way / (size if gap > 0.0 else -size), gap

    def _plane_normal(self, geom: int) -> FloatArray:
        """Return the normal of a geom that is a plane, upwards for others."""
        if int(self._model.geom_type[geom]) != int(self._mujoco.mjtGeom.mjGEOM_PLANE):
            return np.array([0.0, 0.0, 1.0])
        return np.array(self._data.geom_xmat[geom].reshape(3, 3)[:, 2])

    def _beside(
        self, slot: Slot, partner: int, row: int, points: dict[str, Any]
    ) -> tuple[FloatArray, FloatArray, float]:
        """Return the same for a point whose geoms touch in another point: against that contact's plane."""
        place, normal = self._point(slot), points["normals"][row, partner]
        over = float(normal @ (place - points["contact_positions"][row, partner]))
        return place, normal, over + float(points["gaps"][row, partner])

    def _point(self, slot: Slot) -> FloatArray:
        """Return where the material that last touched is now."""
        geom, data = slot.pair[0], self._data
        return np.asarray(data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ np.array(slot.place))
