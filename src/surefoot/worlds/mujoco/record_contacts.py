"""MuJoCo's contacts of a step as contact points that keep their places in a log's rows."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.worlds.mujoco.record_capture import RawBlock
from surefoot.worlds.mujoco.record_contact_rows import (
    CHANNELS,
    CREEP,
    FIELDS,
    MOMENTS,
    MU,
    TURN,
    OuterContacts,
    contact_rows,
    decoded_forces,
    mean_rows,
)
from surefoot.worlds.mujoco.record_instants import Instants, Kinematics
from surefoot.worlds.mujoco.record_model import body_name, geom_name
from surefoot.worlds.mujoco.record_softness import (
    SoftContact,
    declare_response,
    declare_softness,
    hardest_landing,
    soft_contact,
)


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
    place: tuple[float, float, float]
    friction: float
    margin: float
    rolling: FloatArray
    soft: SoftContact | None


class Slots:
    """All contacts of a recording by contact point: the same geoms, and the nearest place on the robot's.

    Contacts are read in blocks of steps, in their order. What open contact points did is found by going
    through the configurations again, in data of its own.

    Attributes
    ----------
    inner
        Contacts of the robot with itself so far.
    """

    def __init__(self, mujoco: Any, model: Any, bodies: IntArray, mount: Sequence[int]) -> None:
        self._mujoco, self._model = mujoco, model
        self._robot = np.isin(model.geom_bodyid, bodies)
        self._mount = np.isin(model.geom_bodyid, mount)
        self._slots: list[Slot] = []
        self._of: dict[tuple[int, int], list[int]] = {}
        self._found: list[IntArray] = []  # step and contact point of each row
        self._rows: list[FloatArray] = []
        self._pyramids = model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
        self.inner = 0

    @property
    def points(self) -> Sequence[Slot]:
        """The contact points so far."""
        return self._slots

    @property
    def count(self) -> int:
        """Number of contact points so far."""
        return len(self._slots)

    def sort(self, raw: RawBlock) -> tuple[IntArray, IntArray]:
        """Return which contacts (c,) are of the robot with anything else, and which (k,) inside the robot."""
        geom = raw.contacts["geom"]
        real = (geom >= 0).all(axis=1) & (raw.contacts["exclude"] == 0)  # flex, or a gap that gives no force
        own, fixed = self._robot[geom], self._mount[geom]
        inside = own.all(axis=1) | (own.any(axis=1) & fixed.any(axis=1))
        inner = np.flatnonzero(real & inside)
        return np.flatnonzero(real & own.any(axis=1) & ~inside), inner

    def read(self, instants: Instants, at: Kinematics, outer: OuterContacts, first: int) -> None:
        """Take the contacts of a block of steps, the first of which has a number in the recording."""
        if not len(outer.which):
            return
        rows = contact_rows(self._model, instants.raw, at, outer)
        geoms = outer.pair[:, 0]
        arm = outer.place - at.geom_xpos[outer.row, geoms]
        places = np.einsum("cji,cj->ci", at.geom_xmat[outer.row, geoms], arm)
        slot = self._assign(instants.raw.contacts[outer.which], outer, rows, places)
        rows[:, CREEP] = self._creep(instants.raw, outer.which, rows, slot)
        step = instants.step[outer.row]
        if len(instants.step) > len(instants.solver_error):
            step, slot, rows = mean_rows(step, slot, rows, instants.weight[outer.row])
        self._found.append(np.stack([step + first, slot], axis=1))
        self._rows.append(rows)

    def inner_forces(self, instants: Instants, which: IntArray) -> tuple[FloatArray, IntArray]:
        """Return the force between links of the robot (steps,) [N], and the two bodies that press most."""
        raw, steps = instants.raw, len(instants.solver_error)
        total, bodies = np.zeros(steps), np.full((steps, 2), -1)
        self.inner += len(which)
        if len(which):
            row = raw.contact_row[which]
            size = (
                np.linalg.norm(decoded_forces(raw, self._pyramids)[which, :3], axis=1) * instants.weight[row]
            )
            step = instants.step[row]
            np.add.at(total, step, size)
            order = np.lexsort((np.arange(len(size)), size, step))  # the hardest of a step is its last
            bodies[step[order]] = self._model.geom_bodyid[raw.contacts["geom"][which[order]]]
        return total, bodies

    def outer(self, raw: RawBlock, which: IntArray) -> OuterContacts:
        """Return what is known without kinematics of (c,) contacts with anything else.

        MuJoCo's force acts on its second geom, along its normal first.
        """
        contacts = raw.contacts[which]
        geom = contacts["geom"]
        second = self._robot[geom[:, 1]]
        pair = np.where(second[:, None], geom[:, ::-1], geom)
        sign = np.where(second, 1.0, -1.0)
        force = decoded_forces(raw, self._pyramids)[which]
        axes = contacts["frame"].reshape(-1, 3, 3)
        world = sign[:, None] * np.einsum("cji,cj->ci", axes, force[:, :3])
        moment = sign[:, None] * np.einsum("cji,cj->ci", axes, force[:, 3:])
        place = np.ascontiguousarray(contacts["pos"])
        return OuterContacts(which, raw.contact_row[which], pair, sign, axes, world, moment, place)

    def arrange(self) -> None:
        """Put the contact points in the order of the model's geoms, once nothing more is read."""
        order = sorted(range(self.count), key=lambda k: (self._slots[k].pair, k))
        place = {k: at for at, k in enumerate(order)}
        self._slots = [self._slots[k] for k in order]
        turn = np.array([place[k] for k in range(self.count)], dtype=np.int64)
        self._found = [np.stack([found[:, 0], turn[found[:, 1]]], axis=1) for found in self._found]

    def arrays(self, steps: int) -> dict[str, Any]:
        """Return the channels of the contacts, NaN where a contact was open but for its force of zero."""
        table = np.full((steps, self.count, FIELDS), np.nan)
        table[..., :3] = 0.0
        if self._rows:
            step, slot = np.concatenate(self._found).T
            table[step, slot] = np.concatenate(self._rows)
        out = {name: table[..., part].copy() for name, part in CHANNELS.items()}
        more: dict[str, Any] = {"contact_creep": CREEP}
        if any(slot.rolling.any() for slot in self._slots):
            more["contact_moments"] = MOMENTS
        if self._pyramids:
            more["pyramid_turn"] = TURN
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
        out["contact_other_moves"] = np.array([float(can_move(self._model, b)) for b in others])
        if any(slot.rolling.any() for slot in self._slots):
            out["moment_friction"] = np.array([slot.rolling for slot in self._slots])
        if any(slot.margin for slot in self._slots):
            out["contact_margin"] = np.array([slot.margin for slot in self._slots])
        soft = [slot.soft for slot in self._slots]
        out["contact_damping"] = np.array([0.0 if one is None else one.friction_damping for one in soft])
        out["critically_damped"] = np.array([float(one is not None and not one.rebounds) for one in soft])
        return out

    def _creep(self, raw: RawBlock, which: IntArray, rows: FloatArray, slot: IntArray) -> FloatArray:
        """Return R f_t / b, the speed of contacts that MuJoCo's friction holds."""
        soft = [one.soft for one in self._slots]
        damping = np.array([0.0 if one is None else max(one.friction_damping, 0.0) for one in soft])[slot]
        contacts = raw.contacts[which]
        on = (contacts["efc_address"] >= 0) & (contacts["dim"] > 1) & (damping > 0.0)
        with np.errstate(all="ignore"):
            if self._pyramids:
                R = raw.constraint(0)[1][which] / (2.0 * rows[:, MU] ** 2)
            else:
                R = raw.constraint(1)[1][which]
            return np.where(on, R * np.hypot(rows[:, 0], rows[:, 1]) / damping, 0.0)

    def _assign(self, contacts: Any, outer: OuterContacts, rows: FloatArray, places: FloatArray) -> IntArray:
        """Return each contact's point: of its geoms the free one that was last nearest, or a new one."""
        out, taken, now = np.zeros(len(places), dtype=np.int64), set[int](), -1
        pairs, where = outer.pair.tolist(), places.tolist()
        for c, row in enumerate(outer.row.tolist()):
            if row != now:
                now, taken = row, set()
            x, y, z = where[c]
            pair = (pairs[c][0], pairs[c][1])
            best, least = -1, np.inf
            for k in self._of.setdefault(pair, []):
                if k in taken:
                    continue
                a, b, d = self._slots[k].place
                far = (a - x) ** 2 + (b - y) ** 2 + (d - z) ** 2
                if best < 0 or far < least:
                    best, least = k, far
            if best < 0:
                best = self._add(contacts[c], pair, float(rows[c, MU]))
            self._slots[best].place = (x, y, z)
            taken.add(best)
            out[c] = best
        return out

    def _add(self, contact: Any, pair: tuple[int, int], mu: float) -> int:
        """Make a new contact point of what MuJoCo says of its first contact, and return its number."""
        model, slot = self._model, len(self._slots)
        friction, dim = contact["friction"], int(contact["dim"])
        rolling = np.array([friction[3], friction[4], friction[2]]) * [dim > 4, dim > 4, dim > 3]
        bodies = int(model.geom_bodyid[pair[0]]), int(model.geom_bodyid[pair[1]])
        told = SimpleNamespace(**{name: contact[name] for name in contact.dtype.names})
        soft, margin = soft_contact(self._mujoco, model, bodies, told), float(contact["includemargin"])
        self._of[pair].append(slot)
        self._slots.append(Slot(pair, bodies, (0.0, 0.0, 0.0), mu, margin, rolling, soft))
        return slot

    def softness(
        self, qpos: FloatArray, points: dict[str, Any], load: float, energy: float
    ) -> dict[str, float]:
        """Return what the model declares of its softness under a load [N], see `record_softness`.

        `energy` is the most kinetic energy that the robot had [J].
        """
        pairs = [slot.bodies for slot in self._slots]
        landing = hardest_landing(self._mujoco, self._model, pairs, qpos, points)
        soft = [slot.soft for slot in self._slots if slot.soft is not None]
        return declare_softness(soft, load, landing, energy) | declare_response(soft, load)

    def name(self, geom: int) -> str:
        """Return the name of a geom, else its body's with its number."""
        return geom_name(self._model, geom)


def can_move(model: Any, body: int) -> bool:
    """Return whether a body moves by joints, or by hand (mocap)."""
    while body and int(model.body_mocapid[body]) < 0:
        if int(model.body_jntnum[body]):
            return True
        body = int(model.body_parentid[body])
    return body != 0
