"""MuJoCo's contacts of a step as contact points that keep their places in a log's rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.simulation.record_softness import SoftContact, declared, hardest_landing, soft_contact
from surefoot.terrain.frames import surface_frames

FAR = 1.0
"""Gaps are measured up to here; what is farther apart is as far as that [m]."""
_FIELDS = 14
_GAP, _MU = 12, 13
"""A contact as a row: force, velocity, position, normal (three each), gap, friction."""


@dataclass(frozen=True)
class Slot:
    """A contact point of the log: two geoms, and which of their contacts.

    Attributes
    ----------
    geom, other
        Of the robot, and what it touches.
    """

    geom: int
    other: int


class Contacts:
    """All contacts of a recording, one row each, in arrays that grow."""

    def __init__(self) -> None:
        self._steps = np.zeros(1024, dtype=np.int64)
        self._slots = np.zeros(1024, dtype=np.int64)
        self._rows = np.zeros((1024, _FIELDS))
        self._count = 0

    def add(self, step: int, found: list[tuple[int, FloatArray]]) -> None:
        """Take the contacts of a step: slot and row (14,) of each."""
        need = self._count + len(found)
        while need > len(self._steps):
            self._steps, self._slots = np.tile(self._steps, 2), np.tile(self._slots, 2)
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])
        for slot, row in found:
            self._steps[self._count], self._slots[self._count] = step, slot
            self._rows[self._count] = row
            self._count += 1

    def arrays(self, steps: int, slots: int) -> dict[str, Any]:
        """Return the channels of the contacts, NaN where a contact was open but for its force of zero."""
        table = np.full((steps, slots, _FIELDS), np.nan)
        table[..., :3] = 0.0
        table[self._steps[: self._count], self._slots[: self._count]] = self._rows[: self._count]
        return {
            "forces": table[..., :3].copy(),
            "contact_velocities": table[..., 3:6].copy(),
            "contact_positions": table[..., 6:9].copy(),
            "normals": table[..., 9:12].copy(),
            "gaps": table[..., _GAP].copy(),
            "contact_friction": table[..., _MU].copy(),
        }


class Slots:
    """Finds the contact point of every contact: the same geoms, and the nearest place on the robot's.

    Attributes
    ----------
    inner
        Contacts of the robot with itself so far.
    moments
        Whether a contact had torsional or rolling friction.
    soft
        What the model declares of the contact points' softness.
    """

    def __init__(self, mujoco: Any, model: Any, bodies: IntArray) -> None:
        self._mujoco, self._model = mujoco, model
        self._robot = np.isin(model.geom_bodyid, bodies)
        self._slots: list[Slot] = []
        self._places: list[FloatArray] = []
        self._friction: list[float] = []
        self._of: dict[tuple[int, int], list[int]] = {}
        self.inner, self.moments = 0, False
        self.soft: dict[int, SoftContact] = {}

    @property
    def count(self) -> int:
        """Number of contact points so far."""
        return len(self._slots)

    def read(self, data: Any) -> list[tuple[int, FloatArray]]:
        """Return slot and row (14,) of every contact between the robot and anything else."""
        out: list[tuple[int, FloatArray]] = []
        taken: set[int] = set()
        force = np.zeros(6)
        for c in range(data.ncon):
            contact = data.contact[c]
            first, second = int(contact.geom[0]), int(contact.geom[1])
            if first < 0 or second < 0 or contact.exclude:
                continue  # flex, or a gap that gives no force
            if self._robot[first] and self._robot[second]:
                self.inner += 1
            elif self._robot[first] or self._robot[second]:
                self._mujoco.mj_contactForce(self._model, data, c, force)
                self.moments |= bool(force[3:].any())
                row = self._row(data, contact, force, bool(self._robot[second]))
                geom, other = (second, first) if self._robot[second] else (first, second)
                slot = self._slot(data, geom, other, row, taken)
                if slot not in self.soft:
                    self._declare(slot, contact)
                out.append((slot, row))
        return out

    def _row(self, data: Any, contact: Any, force: FloatArray, second: bool) -> FloatArray:
        """Return a contact as a row; MuJoCo's force acts on its second geom, along its normal first."""
        axes = contact.frame.reshape(3, 3)
        sign = 1.0 if second else -1.0
        normal = sign * axes[0]
        mine, theirs = (1, 0) if second else (0, 1)
        velocity = material_velocity(self._model, data, int(contact.geom[mine]), contact.pos)
        velocity -= material_velocity(self._model, data, int(contact.geom[theirs]), contact.pos)
        frame = frames_of(normal[None])[0]
        row = np.empty(_FIELDS)
        row[:3] = frame.T @ (sign * (axes.T @ force[:3]))
        row[3:6] = frame.T @ velocity
        row[6:9], row[9:12] = contact.pos, normal
        row[_GAP] = contact.dist
        row[_MU] = contact.friction[0] if contact.dim > 1 else 0.0
        return row

    def _slot(self, data: Any, geom: int, other: int, row: FloatArray, taken: set[int]) -> int:
        """Return the free slot of two geoms that was last nearest on the robot's geom, or a new one."""
        R = data.geom_xmat[geom].reshape(3, 3)
        place = R.T @ (row[6:9] - data.geom_xpos[geom])
        known = self._of.setdefault((geom, other), [])
        free = [k for k in known if k not in taken]
        if free:
            slot = min(free, key=lambda k: float(np.sum((self._places[k] - place) ** 2)))
        else:
            slot = len(self._slots)
            known.append(slot)
            self._slots.append(Slot(geom, other))
            self._places.append(place)
            self._friction.append(float(row[_MU]))
        self._places[slot] = place
        taken.add(slot)
        return slot

    def _declare(self, slot: int, contact: Any) -> None:
        soft = soft_contact(self._mujoco, self._model, self._bodies_of(slot), contact)
        if soft is not None:
            self.soft[slot] = soft

    def _bodies_of(self, slot: int) -> tuple[int, int]:
        """Return the bodies of the robot's geom and of what it touches."""
        of = self._model.geom_bodyid
        return int(of[self._slots[slot].geom]), int(of[self._slots[slot].other])

    def softness(self, qpos: FloatArray, points: dict[str, Any], load: float) -> dict[str, float]:
        """Return the facts `sinking`, `creep` and `stopping` under a load [N], see `record_softness`."""
        pairs = [self._bodies_of(k) for k in range(self.count)]
        landing = hardest_landing(self._mujoco, self._model, pairs, qpos, points)
        return declared(list(self.soft.values()), load, landing)

    def fill_open(self, qpos: FloatArray, qvel: FloatArray, points: dict[str, Any]) -> None:
        """Write what is known of open contact points into a recording of (T, nq) and (T, nv) rows."""
        friction = points["contact_friction"]
        points["contact_friction"] = np.where(np.isnan(friction), np.array(self._friction), friction)
        OpenGaps(self._mujoco, self._model, self._slots, self._places).fill(qpos, qvel, points)

    def feet(self) -> list[str]:
        """Return the names of the robot's geoms that touched something."""
        return list(dict.fromkeys(self._name(slot.geom) for slot in self._slots))

    def foot_of(self) -> list[int]:
        """Return the index in `feet` of every contact point."""
        feet = self.feet()
        return [feet.index(self._name(slot.geom)) for slot in self._slots]

    def others(self) -> list[str]:
        """Return the names of what every contact point touches."""
        return [self._name(slot.other) for slot in self._slots]

    def _name(self, geom: int) -> str:
        model = self._model
        body = str(model.body(int(model.geom_bodyid[geom])).name)
        return str(model.geom(geom).name) or f"{body or 'body'}:{geom}"


def frames_of(normals: FloatArray) -> FloatArray:
    """Return Surefoot's contact frames of (n, 3) unit normals: (n, 3, 3), the normal last."""
    frames = np.empty((len(normals), 3, 3))
    surface_frames(np.ascontiguousarray(normals), frames)
    return frames


class OpenGaps:
    """Fills in the contact points that were open at a step: where they were, how far apart, how fast.

    Goes through the configurations again in data of its own.
    """

    def __init__(self, mujoco: Any, model: Any, slots: list[Slot], places: list[FloatArray]) -> None:
        self._mujoco, self._model, self._slots, self._places = mujoco, model, slots, places
        self._data = mujoco.MjData(model)
        self._segment = np.zeros(6)

    def fill(self, qpos: FloatArray, qvel: FloatArray, points: dict[str, Any]) -> None:
        """Write the open contact points of (T, nq) states into the channels of `Contacts.arrays`."""
        mujoco, model, data = self._mujoco, self._model, self._data
        for t in np.flatnonzero(np.isnan(points["gaps"]).any(axis=1)).tolist():
            if not (np.isfinite(qpos[t]).all() and np.isfinite(qvel[t]).all()):
                continue
            data.qpos[:], data.qvel[:] = qpos[t], qvel[t]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            row = {name: array[t] for name, array in points.items()}
            closed = np.flatnonzero(~np.isnan(row["gaps"])).tolist()
            for k in np.flatnonzero(np.isnan(row["gaps"])).tolist():
                partner = next((c for c in closed if self._slots[c] == self._slots[k]), None)
                place, normal, gap = self._apart(k) if partner is None else self._beside(k, partner, row)
                row["contact_positions"][k], row["normals"][k], row["gaps"][k] = place, normal, gap
                velocity = material_velocity(model, data, self._slots[k].geom, place)
                velocity -= material_velocity(model, data, self._slots[k].other, place)
                row["contact_velocities"][k] = frames_of(normal[None])[0].T @ velocity

    def _apart(self, k: int) -> tuple[FloatArray, FloatArray, float]:
        """Return the nearest point of the robot's geom, the direction to it, and the gap."""
        slot, data = self._slots[k], self._data
        try:
            gap = float(
                self._mujoco.mj_geomDistance(self._model, data, slot.other, slot.geom, FAR, self._segment)
            )
        except Exception:  # MuJoCo's own error for shapes that it cannot measure
            gap = FAR
        way = self._segment[3:] - self._segment[:3]
        size = float(np.linalg.norm(way))
        if gap >= FAR or size < 1e-12:
            return self._point(k), np.array([0.0, 0.0, 1.0]), gap
        return self._segment[3:].copy(), way / (size if gap > 0.0 else -size), gap

    def _beside(self, k: int, partner: int, row: dict[str, Any]) -> tuple[FloatArray, FloatArray, float]:
        """Return the same for a point whose geoms touch in another point: against that contact's plane."""
        place, normal = self._point(k), row["normals"][partner].copy()
        over = float(normal @ (place - row["contact_positions"][partner]) + row["gaps"][partner])
        return place, normal, over

    def _point(self, k: int) -> FloatArray:
        """Return where the material that last touched is now."""
        geom = self._slots[k].geom
        R = self._data.geom_xmat[geom].reshape(3, 3)
        return np.asarray(self._data.geom_xpos[geom] + R @ self._places[k])


def material_velocity(model: Any, data: Any, geom: int, place: FloatArray) -> FloatArray:
    """Return the velocity of a geom's material at a place, world axes: (3,) [m/s]."""
    body = int(model.geom_bodyid[geom])
    turn = data.cvel[body]
    arm = place - data.subtree_com[model.body_rootid[body]]
    return np.asarray(turn[3:] + np.cross(turn[:3], arm))
