"""The contacts of one MjData over an episode: buffers that are kept, and the log of what they hold."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import entry_point
from surefoot.records import LIMITS, BatchReport, ContactProof, ContactRows, ContactWorld, Log
from surefoot.worlds.mujoco.episode import contact_pass as passes
from surefoot.worlds.mujoco.episode import contact_writing as step
from surefoot.worlds.mujoco.episode.contact_writing import FIRST, OTHER, OWN, SEEN
from surefoot.worlds.mujoco.memory_places import all_memory, contact_struct, place_of
from surefoot.worlds.mujoco.record_contact_rows import CHANNELS, CREEP, FIELDS, GAP, MOMENTS, MU, TURN
from surefoot.worlds.mujoco.record_model import geom_name
from surefoot.worlds.mujoco.record_places import StepPlaces
from surefoot.worlds.mujoco.record_softness import (
    DeclaredSoftness,
    HardestLanding,
    SoftContact,
    declare_at_rest,
    declare_response,
    declare_softness,
    hardest_landing,
    inverse_mass,
    soft_contact,
)
from surefoot.worlds.mujoco.record_tree import BodyTree

ROWS, POINTS = 256, 8
"""Rows and contact points that there is room for at the start."""
MEMORY = 64 << 20
"""Bytes of rows beyond which an episode is judged in parts."""
UNKNOWN = ("contact_positions", "normals")
"""Channels of a contact that a log of an episode has not."""
MOST_TOLD = 1000
"""Choices of contact points of which is kept what the model says of them."""


class PairContact(NamedTuple):
    """What MuJoCo declares of the contacts of two geoms: softness, the gap from which they push [m], rolling.

    `rolling` is (3,) friction of the moments about the contact axes [m]; `soft` None for what is no softness.
    """

    soft: SoftContact | None
    margin: float
    rolling: FloatArray


class ContactRecorder:
    """Rows of the contacts of a robot in an MjData, one a step that `take` is called after.

    Parameters
    ----------
    mujoco, model, data
        The module and its own; nothing is changed in them.
    robot
        Name of the body at the robot's root; None for that with the most actuators.

    Attributes
    ----------
    missed
        How often time moved without a step that was seen.
    turned
        How often it ran back: somebody, or MuJoCo itself, reset the state.
    parts
        Logs of the episode's rows that were cut off: before its state was reset, or for memory's sake.
    paused
        Whether steps are passed over.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any, robot: str | None = None) -> None:
        self.mujoco, self.model, self.data = mujoco, model, data
        self.tree = BodyTree(mujoco, model, robot)
        self._look = StepPlaces(mujoco, model, data)
        self._runge_kutta = int(mujoco.mjtIntegrator.mjINT_RK4)  # to look it up takes as long as a proof
        self._pyramids = model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
        self._at = self._places()
        self._columns = np.array([0, 3, GAP, MU, TURN if self._pyramids else -1, CREEP])
        parts = np.zeros(model.ngeom, dtype=np.int64)
        parts[np.isin(model.geom_bodyid, self.tree.bodies)] = 1
        parts[np.isin(model.geom_bodyid, self.tree.mount)] = 2
        self._kinds = model.geom_bodyid.astype(np.int64), parts, model.body_rootid.astype(np.int64)
        self._clock, self._tail = np.zeros(1), np.zeros(2, dtype=np.int64)
        self._last = np.zeros(9 * model.nbody + 12 * model.ngeom + model.nq)
        self.parts: list[Log] = []
        self._proof: ContactProof | None = None
        self.paused = False
        self._pairs: list[tuple[int, int]] = []
        self._declares: dict[tuple[int, int], PairContact] = {}
        self._known: dict[SoftContact | None, SoftContact | None] = {}
        self._point_facts_known: dict[bytes, dict[str, Any]] = {}
        self._declared: dict[bytes, DeclaredSoftness] = {}
        self._spare = mujoco.MjData(model)
        self._pass, self._keep = (
            entry_point(passes.take_step, *passes.PASS_TYPES),
            entry_point(passes.keep_last, *passes.KEEP_TYPES),
        )  # fmt: skip
        self._rows: tuple[FloatArray, ...] = ()
        self._points: tuple[Any, ...] = ()
        self._make_room(ROWS, POINTS)
        self.begin()

    def _places(self) -> IntArray:
        """Return where the pass finds what it reads, see `contact_writing.ALL_PLACES`."""
        model, data = self.model, self.data
        fields: Any = contact_struct(self.mujoco).fields
        at = np.zeros(step.ALL_PLACES, dtype=np.int64)
        for k, name in (
            (step.CVEL, "cvel"), (step.CENTRES, "subtree_com"), (step.GEOM_PLACES, "geom_xpos"),
            (step.GEOM_AXES, "geom_xmat"), (step.QPOS, "qpos"),
        ):  # fmt: skip
            at[k] = place_of(getattr(data, name))
        for k, name, size in (
            (step.DIST, "dist", 8), (step.POS, "pos", 8), (step.FRAME, "frame", 8),
            (step.MARGIN, "includemargin", 8), (step.FRICTION, "friction", 8), (step.DIM, "dim", 4),
            (step.GEOM, "geom", 4), (step.EXCLUDE, "exclude", 4), (step.ADDRESS, "efc_address", 4),
        ):  # fmt: skip
            at[k] = fields[name][1] // size
        at[step.STRUCT] = contact_struct(self.mujoco).itemsize // 8
        at[[step.PYRAMIDS, step.BODIES, step.GEOMS]] = self._pyramids, model.nbody, model.ngeom
        at[step.POSITIONS] = model.nq
        return at

    def _make_room(self, rows: int, points: int) -> None:
        """Take memory for rows and contact points, those that there are included."""
        fresh = (
            np.zeros((rows, points, FIELDS)), np.zeros((rows, 2)), np.zeros((rows, self.model.nq)),
        )  # fmt: skip
        kinds = np.full((points, 4), -1, dtype=np.int64)
        local, plane = np.zeros((points, 3)), np.zeros((points, 9))
        if self._tail[0] or self._tail[1]:
            n, p = self._tail.tolist()
            fresh[0][:n, :p] = self._rows[0][:n, :p]
            for new, old in zip(fresh[1:], self._rows[1:], strict=True):
                new[:n] = old[:n]
            for new, old in zip((kinds, local, plane), self._points, strict=False):
                new[:p] = old[:p]
        self._rows, self._points = fresh, (kinds, local, plane, np.zeros((14, 3)))
        arrays = (
            self._look.at, self._at, *self._kinds, self._clock, self._tail, self._last, *self._points, *fresh
        )  # fmt: skip
        places = [place_of(array) for array in arrays]
        sizes = rows, points, self.model.nq, self.model.ngeom, self.model.nbody, len(self._last)
        self._given = *all_memory(), np.array([*places, *sizes], dtype=np.int64)

    @property
    def count(self) -> int:
        """Number of rows of the episode so far."""
        return int(self._tail[0])

    @property
    def touched(self) -> bool:
        """Whether anything touched in the rows so far."""
        return bool((self._points[0][: self._tail[1], FIRST] >= 0).any())

    @property
    def last(self) -> float:
        """Time after the last step that was seen [s]."""
        return float(self._clock[0])

    @property
    def full(self) -> bool:
        """Whether the rows take so much memory that they should be judged."""
        return self._rows[0].nbytes >= MEMORY and self.count >= len(self._rows[0]) - 1

    def begin(self) -> None:
        """Begin an episode in the data's present state."""
        self._tail[:] = self.missed = self.turned = 0
        self.parts, self._proof, self._pairs = [], None, []
        self._points[0][:, SEEN:] = -1
        self._clock[0] = self.data.time
        self._keep(all_memory()[0], self._at, self._last)

    def part(self) -> None:
        """Put the rows so far into `parts`, and go on with the episode."""
        if self.count:
            self.parts.append(self.log())
        self._tail[0] = 0
        self._points[0][:, SEEN:] = -1

    def take(self, length: float = 0.0) -> None:
        """Take the step that the data has just made, of a length [s]; 0 for the model's."""
        if not self._look.known:
            self._look.refresh()
        found = self._pass(*self._given, length)
        if found < 0:
            found = self._take_again(found, length)
        if found > len(self._pairs):
            self._describe(found)

    def _take_again(self, found: int, length: float) -> int:
        """Make room for a step, or see what became of the clock, and take it."""
        while found < 0:
            if found == passes.NO_ROOM:
                rows, points = self._rows[0].shape[:2]
                more = self._tail[1] + int(self.data.ncon) > points
                grow = not more and self.count >= rows
                self._make_room(2 * rows if grow else rows, max(2 * points, 8) if more else points)
            else:
                begun = self.data.time - (length or self.model.opt.timestep)
                if begun < self.last - 1e-9:
                    self.part()
                    self.turned += 1
                else:
                    self.missed += 1
                self._clock[0] = begun
            found = self._pass(*self._given, length)
        return found

    def _describe(self, count: int) -> None:
        """Note what MuJoCo says of the contacts at points that are new."""
        kinds = self._points[0]
        for s in range(len(self._pairs), count):
            pair = (int(kinds[s, OWN]), int(kinds[s, OTHER]))
            if pair not in self._declares:
                self._declares[pair] = self._read_contact(pair)
            self._pairs.append(pair)

    def _read_contact(self, pair: tuple[int, int]) -> PairContact:
        """Return what MuJoCo says of the present contact of two geoms."""
        contacts = self.data.contact
        same = (np.sort(contacts.geom, axis=1) == np.sort(pair)).all(axis=1)
        c = int(np.flatnonzero(same)[0])
        told = {n: getattr(contacts, n)[c] for n in ("solref", "solreffriction", "solimp", "friction")}
        dim, friction = int(contacts.dim[c]), told["friction"]
        bodies = [int(self.model.geom_bodyid[geom]) for geom in pair]
        soft = soft_contact(self.mujoco, self.model, bodies, SimpleNamespace(dim=dim, **told))
        turns = np.array([friction[3], friction[4], friction[2]]) * [dim > 4, dim > 4, dim > 3]
        # one value for all that are alike: what is worked out of it is worked out once
        return PairContact(self._known.setdefault(soft, soft), float(contacts.includemargin[c]), turns)

    def _of(self, point: int) -> PairContact:
        """Return what is declared of a contact point."""
        return self._declares[self._pairs[point]]

    @property
    def _used(self) -> IntArray:
        """(k,) contact points that touched in the episode, in the order of the model's geoms."""
        kinds = self._points[0]
        used = np.flatnonzero(kinds[: self._tail[1], FIRST] >= 0)
        return used[np.lexsort((used, kinds[used, OTHER], kinds[used, OWN]))]

    def prove(
        self, unsure: str = "", reward: Callable[[], FloatArray | None] = lambda: None
    ) -> BatchReport | None:
        """Return the report of the rows so far if they are proven to break no law, else None.

        `unsure` is why they are not called lawful all the same; `reward` gives what each row was paid (T,).
        """
        used, n = self._used, self.count
        self._proof = None
        if not len(used) or self.missed or any(self._of(k).rolling.any() for k in used.tolist()):
            return None
        told, mass = self._point_facts(used), self.mass
        soft = self._softness_of(used, mass * self._gravity)
        rows = ContactRows(self._rows[0], used, self._columns, self._rows[1][:n])
        world = ContactWorld(
            told["contact_damping"], told["critically_damped"], told["margins"], mass, self._gravity,
            soft.settling, declare_response(soft.contacts, soft.load).get("recoil", math.inf), self.means,
        )  # fmt: skip
        proof = ContactProof(rows, world)
        self._proof, sinking = proof, soft.resting
        if proof.deepest > max(LIMITS.laws.penetration, sinking):
            landing = self._landing_of(proof, used)
            sinking = max((s.sinking(soft.load, landing) for s in soft.contacts), default=0.0)
        return proof.report(sinking, soft.creep, soft.stopping * proof.across, unsure, reward)

    @property
    def held(self) -> frozenset[str]:
        """Laws that `prove` has proven in the rows so far, where it could not prove all."""
        return frozenset() if self._proof is None else self._proof.held

    def _landing_of(self, proof: ContactProof, used: IntArray) -> HardestLanding | None:
        """Return the hardest touchdown, as heavy as the fastest contact alone: others only make it deeper."""
        qpos = self._rows[2][proof.row]
        where = self._rows[0][proof.row, used[proof.contact]]
        if not proof.fastest > 0.0 or not np.isfinite([*qpos, *where]).all():
            return None
        self._spare.qpos[:] = qpos
        geoms = self._points[0][used[proof.contact], : OTHER + 1]
        mass = inverse_mass(
            self.mujoco,
            self.model,
            self._spare,
            self.model.geom_bodyid[geoms].tolist(),
            where[6:9],
            where[9:12],
        )
        depth = min(proof.touched, proof.fastest * float(self.model.opt.timestep))
        return HardestLanding(proof.fastest, proof.across, depth, mass)

    def _softness_of(self, used: IntArray, load: float) -> DeclaredSoftness:
        """Return what contact points declare under a load [N]; what no touchdown changes is kept."""
        key = self._points[0][used, : OTHER + 1].tobytes()
        known = self._declared.get(key)
        if known is None or known.load != load:
            if len(self._declared) >= MOST_TOLD:
                self._declared.clear()
            known = self._declared[key] = declare_at_rest(self._soft_of(used), load)
        return known

    def _soft_of(self, used: IntArray) -> list[SoftContact]:
        """Return what is declared of the softness of contact points, once for those that are alike."""
        soft = (self._of(k).soft for k in used.tolist())
        return [*{id(s): s for s in soft if s is not None}.values()]

    @property
    def mass(self) -> float:
        """Mass of the robot [kg]."""
        return float(self.model.body_mass[self.tree.bodies].sum())

    @property
    def _gravity(self) -> float:
        return math.hypot(*self.model.opt.gravity.tolist())

    def log(self) -> Log:
        """Return the rows so far as a log: contacts that touched, and what the model says of them."""
        n, used = self.count, self._used
        table, times = self._rows[0][:n, used], self._rows[1][:n].copy()
        told = self._point_facts(used)
        points = {name: np.ascontiguousarray(table[..., part]) for name, part in CHANNELS.items()}
        # of open contact points places and normals are not known
        arrays: dict[str, Any] = {"time": times[:, 0]}
        arrays |= {name: array for name, array in points.items() if name not in UNKNOWN}
        damping = told["contact_damping"]
        arrays["contact_creep"] = np.maximum(table[..., CREEP], 0.0) / np.where(
            damping > 0.0, damping, np.inf
        )
        if self._pyramids:
            arrays["pyramid_turn"] = np.ascontiguousarray(table[..., TURN])
        if "moment_friction" in told:
            arrays["contact_moments"] = np.ascontiguousarray(table[..., MOMENTS])
        return Log(arrays, self._facts(used, told, points))

    def _point_facts(self, used: IntArray) -> dict[str, Any]:
        """Return what the model says of contact points, k of them."""
        key = self._points[0][used, : OTHER + 1].tobytes()
        if key in self._point_facts_known:
            return self._point_facts_known[key]
        model, kinds = self.model, self._points[0]
        names = [geom_name(model, int(kinds[k, OWN])) for k in used]
        feet = list(dict.fromkeys(names))
        soft = [self._of(k).soft for k in used]
        out: dict[str, Any] = {
            "feet": feet, "contact_foot": [feet.index(name) for name in names],
            "contact_with": [geom_name(model, int(kinds[k, OTHER])) for k in used],
            "contact_damping": np.array([0.0 if s is None else s.friction_damping for s in soft]),
            "critically_damped": np.array([float(s is not None and not s.rebounds) for s in soft]),
        }  # fmt: skip
        if any(self._of(k).rolling.any() for k in used.tolist()):
            out["moment_friction"] = np.array([self._of(k).rolling for k in used])
        out["margins"] = np.array([self._of(k).margin for k in used])
        if len(self._point_facts_known) >= MOST_TOLD:
            self._point_facts_known.clear()
        self._point_facts_known[key] = out
        return out

    def _facts(self, used: IntArray, told: dict[str, Any], points: dict[str, Any]) -> dict[str, Any]:
        """Return the facts of the rows so far."""
        mujoco, model, kinds = self.mujoco, self.model, self._points[0]
        mass, gravity = self.mass, np.array(model.opt.gravity)
        facts: dict[str, Any] = {
            "source": "MuJoCo", "mass": mass, "dt": float(np.median(self._rows[1][: self.count, 1])),
            "gravity": gravity,
            "robot": self.tree.title, "cone": "pyramidal" if self._pyramids else "elliptic", **told,
        }  # fmt: skip
        margins = facts.pop("margins")
        if margins.any():
            facts["contact_margin"] = margins
        if self.means:
            facts["velocities"] = "mean"
        if self.missed:
            facts["unseen_steps"] = self.missed
        bodies = [tuple(pair) for pair in model.geom_bodyid[kinds[used, : OTHER + 1]].tolist()]
        landing = hardest_landing(mujoco, model, bodies, self._rows[2][: self.count], points, self._spare)
        soft, load = self._soft_of(used), mass * self._gravity
        facts |= declare_softness(soft, load, landing) | declare_response(soft, load)
        return {name: fact for name, fact in facts.items() if np.size(fact)}

    @property
    def means(self) -> bool:
        """Whether a step has several instants, of which the last alone is taken."""
        return int(self.model.opt.integrator) == self._runge_kutta
