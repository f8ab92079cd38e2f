"""MuJoCo's contacts of a step as contact points that keep their places in a log's rows."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.mechanics import frames_on
from surefoot.worlds.mujoco.record_model import body_name
from surefoot.worlds.mujoco.record_softness import (
    SoftContact,
    declare_softness,
    hardest_landing,
    soft_contact,
)

FAR = 1.0
"""Gaps are measured up to here; what is farther apart is as far as that [m]."""
_FIELDS = 19
_WHERE = slice(3, 12)
_GAP, _MU, _MOMENTS, _TURN, _CREEP = 12, 13, slice(14, 17), 17, 18
"""A contact as a row: force, velocity, position, normal (three each), gap, friction, moments (three), turn of
its friction pyramid, creep."""
_CHANNELS: dict[str, Any] = {
    "forces": slice(0, 3), "contact_velocities": slice(3, 6), "contact_positions": slice(6, 9),
    "normals": slice(9, 12), "gaps": _GAP, "contact_friction": _MU,
}  # fmt: skip


@dataclass
class Slot:
    """A contact point of the log: two geoms, and which of their contacts.

    Attributes
    ----------
    pair
        Geoms of the robot, and of what it touches.
    bodies
        Theirs.
    place
        Where the last contact was, in the axes of the robot's geom (3,) [m].
    friction
        Of the first contact.
    margin
        Its gap from which it pushes [m].
    rolling
        (3,) friction of its moments about the contact axes: rolling, rolling, torsional [m].
    soft
        What the model declares of its softness, None for what is no softness.
    """

    pair: tuple[int, int]
    bodies: tuple[int, int]
    place: FloatArray
    friction: float
    margin: float
    rolling: FloatArray
    soft: SoftContact | None


class Slots:
    """All contacts of a recording by contact point: the same geoms, and the nearest place on the robot's.

    What open contact points did is found by going through the configurations again, in data of its own.

    Attributes
    ----------
    inner
        Contacts of the robot with itself so far.
    inner_now
        Force between links of the robot in the step that is read [N], and the two bodies of the hardest.
    """

    def __init__(self, mujoco: Any, model: Any, bodies: IntArray, mount: Sequence[int]) -> None:
        self._mujoco, self._model = mujoco, model
        self._robot = np.isin(model.geom_bodyid, bodies)
        self._mount = np.isin(model.geom_bodyid, mount)
        self._slots: list[Slot] = []
        self._of: dict[tuple[int, int], list[int]] = {}
        self._found: list[tuple[int, int]] = []  # step and contact point of each row
        self._rows: list[FloatArray] = []
        self._now: dict[int, list[tuple[float, FloatArray]]] = {}  # weights and rows of this step's instants
        self._pyramids = model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
        self.inner = 0
        self.inner_now: tuple[float, tuple[int, int]] = 0.0, (-1, -1)
        self._hardest = 0.0

    @property
    def count(self) -> int:
        """Number of contact points so far."""
        return len(self._slots)

    def read(self, data: Any, weight: float) -> FloatArray:
        """Take every contact between the robot and anything else at an instant of a step, with its weight.

        Returns what their forces put on the joints (nv,).
        """
        taken: set[int] = set()
        force, joints = np.zeros(6), np.zeros(self._model.nv)
        for c in range(data.ncon):
            contact = data.contact[c]
            first, second = int(contact.geom[0]), int(contact.geom[1])
            if first < 0 or second < 0 or contact.exclude:
                continue  # flex, or a gap that gives no force
            own = self._robot[[first, second]]
            if own.all() or (own.any() and self._mount[[first, second]].any()):
                self.inner += 1
                self._mujoco.mj_contactForce(self._model, data, c, force)
                self._add_inner(weight * float(np.linalg.norm(force[:3])), first, second)
            elif own.any():
                self._mujoco.mj_contactForce(self._model, data, c, force)
                pair = (second, first) if self._robot[second] else (first, second)
                row = self._row(data, contact, force, pair, joints)
                k = self._slot(data, contact, pair, row, taken)
                self._now.setdefault(k, []).append((weight, self._with_creep(data, contact, row, k)))
        return joints

    def _add_inner(self, force: float, first: int, second: int) -> None:
        """Add a force [N] between two geoms of the robot to `inner_now`."""
        total, bodies = self.inner_now
        if force >= self._hardest:
            self._hardest = force
            bodies = int(self._model.geom_bodyid[first]), int(self._model.geom_bodyid[second])
        self.inner_now = total + force, bodies

    def close(self, step: int) -> None:
        """Write what the instants of a step were: mean forces, gaps at its first touch."""
        self.inner_now, self._hardest = (0.0, (-1, -1)), 0.0
        for k, instants in self._now.items():
            weights, rows = (np.array(part) for part in zip(*instants, strict=True))
            mean, loads = rows[0].copy(), weights * np.linalg.norm(rows[:, :3], axis=1)
            if loads.any():  # where, and how fast, while it pushed: work and moments are those of the step
                mean[_WHERE] = loads @ rows[:, _WHERE] / loads.sum()
                mean[9:12] /= np.linalg.norm(mean[9:12])
            for part in (slice(0, 3), _MOMENTS, _CREEP):
                mean[part] = weights @ rows[:, part]
            self._found.append((step, k))
            self._rows.append(mean)
        self._now = {}

    def arrange(self) -> None:
        """Put the contact points in the order of the model's geoms, once nothing more is read."""
        order = sorted(range(self.count), key=lambda k: (self._slots[k].pair, k))
        place = {k: at for at, k in enumerate(order)}
        self._slots = [self._slots[k] for k in order]
        self._found = [(step, place[k]) for step, k in self._found]

    def arrays(self, steps: int) -> dict[str, Any]:
        """Return the channels of the contacts, NaN where a contact was open but for its force of zero."""
        table = np.full((steps, self.count, _FIELDS), np.nan)
        table[..., :3] = 0.0
        if self._rows:
            table[tuple(np.transpose(self._found))] = self._rows
        out = {name: table[..., part].copy() for name, part in _CHANNELS.items()}
        more: dict[str, Any] = {"contact_creep": _CREEP}
        if any(slot.rolling.any() for slot in self._slots):
            more["contact_moments"] = _MOMENTS
        if self._pyramids:
            more["pyramid_turn"] = _TURN
        return out | {name: np.nan_to_num(table[..., part]) for name, part in more.items()}

    def facts(self, foot_geoms: Container[int]) -> dict[str, Any]:
        """Return what the model says of the contacts, point by point; `foot_geoms` those that are feet."""
        names = [[self.name(geom) for geom in slot.pair] for slot in self._slots]
        feet = list(dict.fromkeys(own for own, _ in names))
        out: dict[str, Any] = {
            "feet": feet, "contact_foot": [feet.index(own) for own, _ in names],
            "contact_with": [other for _, other in names],
            "cone": "pyramidal" if self._pyramids else "elliptic",
        }  # fmt: skip
        own, others = ([slot.bodies[k] for slot in self._slots] for k in (0, 1))
        out["contact_body"] = [body_name(self._model, b) for b in own]
        out["contact_is_foot"] = np.array([float(slot.pair[0] in foot_geoms) for slot in self._slots])
        out["contact_other_moves"] = np.array([float(self._model.body_weldid[b] != 0) for b in others])
        if any(slot.rolling.any() for slot in self._slots):
            out["moment_friction"] = np.array([slot.rolling for slot in self._slots])
        if any(slot.margin for slot in self._slots):
            out["contact_margin"] = np.array([slot.margin for slot in self._slots])
        soft = [slot.soft for slot in self._slots]
        out["contact_damping"] = np.array([0.0 if one is None else one.friction_damping for one in soft])
        out["critically_damped"] = np.array([float(one is not None and not one.rebounds) for one in soft])
        return out

    def _row(
        self, data: Any, contact: Any, force: FloatArray, pair: tuple[int, int], joints: FloatArray
    ) -> FloatArray:
        """Return a contact as a row, and add what its force puts on the joints (nv,).

        MuJoCo's force acts on its second geom, along its normal first.
        """
        axes = contact.frame.reshape(3, 3)
        sign = 1.0 if pair[0] == int(contact.geom[1]) else -1.0
        normal = sign * axes[0]
        velocity = relative_velocity(self._model, data, pair, contact.pos)
        frame = frames_on(normal)
        world, body = sign * (axes.T @ force[:3]), int(self._model.geom_bodyid[pair[0]])
        self._mujoco.mj_applyFT(self._model, data, world, np.zeros(3), contact.pos, body, joints)
        row = np.zeros(_FIELDS)
        row[:3] = frame.T @ world
        row[3:6] = frame.T @ velocity
        row[6:9], row[9:12] = contact.pos, normal
        row[_GAP] = contact.dist
        row[_MU] = contact.friction[0] if contact.dim > 1 else 0.0
        row[_MOMENTS] = frame.T @ (sign * (axes.T @ force[3:]))
        along = frame.T @ axes[1]
        row[_TURN] = np.arctan2(along[1], along[0])
        return row

    def _with_creep(self, data: Any, contact: Any, row: FloatArray, k: int) -> FloatArray:
        """Return a row with R f_t / b, the speed of a contact that MuJoCo's friction holds."""
        slot, at = self._slots[k], int(contact.efc_address)
        if slot.soft is not None and at >= 0 and contact.dim > 1 and slot.soft.friction_damping > 0.0:
            R = float(data.efc_R[at] / (2.0 * row[_MU] ** 2) if self._pyramids else data.efc_R[at + 1])
            row[_CREEP] = R * np.hypot(row[0], row[1]) / slot.soft.friction_damping
        return row

    def _slot(self, data: Any, contact: Any, pair: tuple[int, int], row: FloatArray, taken: set[int]) -> int:
        """Return the free contact point of two geoms that was last nearest on the robot's, or a new one."""
        R = data.geom_xmat[pair[0]].reshape(3, 3)
        place = R.T @ (row[6:9] - data.geom_xpos[pair[0]])
        known = self._of.setdefault(pair, [])
        free = [k for k in known if k not in taken]
        if free:
            slot = min(free, key=lambda k: float(np.sum((self._slots[k].place - place) ** 2)))
            self._slots[slot].place = place
        else:
            slot = len(self._slots)
            known.append(slot)
            friction, dim = contact.friction, int(contact.dim)
            rolling = np.array([friction[3], friction[4], friction[2]]) * [dim > 4, dim > 4, dim > 3]
            bodies = int(self._model.geom_bodyid[pair[0]]), int(self._model.geom_bodyid[pair[1]])
            soft = soft_contact(self._mujoco, self._model, bodies, contact)
            margin = float(contact.includemargin)
            self._slots.append(Slot(pair, bodies, place, float(row[_MU]), margin, rolling, soft))
        taken.add(slot)
        return slot

    def softness(self, qpos: FloatArray, points: dict[str, Any], load: float) -> dict[str, float]:
        """Return the facts `sinking`, `creep` and `stopping` under a load [N], see `record_softness`."""
        pairs = [slot.bodies for slot in self._slots]
        landing = hardest_landing(self._mujoco, self._model, pairs, qpos, points)
        return declare_softness([slot.soft for slot in self._slots if slot.soft is not None], load, landing)

    def fill_open(self, qpos: FloatArray, qvel: FloatArray, points: dict[str, Any]) -> None:
        """Write what is known of open contact points into a recording of (T, nq) and (T, nv) rows."""
        friction = points["contact_friction"]
        known = np.array([slot.friction for slot in self._slots])
        points["contact_friction"] = np.where(np.isnan(friction), known, friction)
        mujoco, model, data = self._mujoco, self._model, self._mujoco.MjData(self._model)
        for t in np.flatnonzero(np.isnan(points["gaps"]).any(axis=1)).tolist():
            if not (np.isfinite(qpos[t]).all() and np.isfinite(qvel[t]).all()):
                continue
            data.qpos[:], data.qvel[:] = qpos[t], qvel[t]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_comVel(model, data)
            self._fill_row(data, {name: array[t] for name, array in points.items()})

    def _fill_row(self, data: Any, row: dict[str, Any]) -> None:
        """Write where the open contact points of one step were, how far apart, how fast."""
        closed = np.flatnonzero(~np.isnan(row["gaps"])).tolist()
        for k in np.flatnonzero(np.isnan(row["gaps"])).tolist():
            slot = self._slots[k]
            partner = next((c for c in closed if self._slots[c].pair == slot.pair), None)
            if partner is None:
                place, normal, gap = self._apart(data, slot)
            else:
                place, normal, gap = self._beside(data, slot, partner, row)
            row["contact_positions"][k], row["normals"][k], row["gaps"][k] = place, normal, gap
            velocity = relative_velocity(self._model, data, slot.pair, place)
            row["contact_velocities"][k] = frames_on(normal).T @ velocity

    def _apart(self, data: Any, slot: Slot) -> tuple[FloatArray, FloatArray, float]:
        """Return the nearest point of the robot's geom, the direction to it, and the gap."""
        (geom, other), segment = slot.pair, np.zeros(6)
        try:
            gap = float(self._mujoco.mj_geomDistance(self._model, data, other, geom, FAR, segment))
        except Exception:  # MuJoCo's own error for shapes that it cannot measure
            gap = FAR
        way = segment[3:] - segment[:3]
        size = float(np.linalg.norm(way))
        if gap >= FAR or size < 1e-12:
            return _point(data, slot), np.array([0.0, 0.0, 1.0]), gap
        return segment[3:].copy(), way / (size if gap > 0.0 else -size), gap

    def _beside(
        self, data: Any, slot: Slot, partner: int, row: dict[str, Any]
    ) -> tuple[FloatArray, FloatArray, float]:
        """Return the same for a point whose geoms touch in another point: against that contact's plane."""
        place, normal = _point(data, slot), row["normals"][partner].copy()
        over = float(normal @ (place - row["contact_positions"][partner]) + row["gaps"][partner])
        return place, normal, over

    def name(self, geom: int) -> str:
        """Return the name of a geom, else its body's with its number."""
        model = self._model
        body = str(model.body(int(model.geom_bodyid[geom])).name)
        return str(model.geom(geom).name) or f"{body or 'body'}:{geom}"


def _point(data: Any, slot: Slot) -> FloatArray:
    """Return where the material that last touched is now."""
    geom = slot.pair[0]
    return np.asarray(data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ slot.place)


def relative_velocity(model: Any, data: Any, pair: tuple[int, int], place: FloatArray) -> FloatArray:
    """Return the velocity of a geom's material at a place over another's, world axes: (3,) [m/s]."""
    moving = []
    for body in model.geom_bodyid[list(pair)].tolist():
        turn, arm = data.cvel[body], place - data.subtree_com[model.body_rootid[body]]
        moving.append(turn[3:] + np.cross(turn[:3], arm))
    return np.asarray(moving[0] - moving[1])
