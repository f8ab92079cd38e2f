"""Raw copies of what MuJoCo held at every step of a loop: no arithmetic, a few microseconds each.

All arrays of an MjData with a fixed size go into one flat row; contacts are copied as MuJoCo's own structs,
constraint forces behind each other. What they mean is worked out later, for many rows at once.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import entry_point
from surefoot.worlds.mujoco.record_copy import (
    CONTACT_TYPES,
    COPY_TYPES,
    STEP_TYPES,
    MemoryTable,
    copy_contacts,
    copy_parts,
    copy_step,
)

START = ("qpos", "qvel", "act", "qacc_warmstart")
"""Arrays of the state that a step starts from."""
DURING = (
    "qacc", "qfrc_actuator", "qfrc_applied", "qfrc_passive", "qfrc_gravcomp", "qfrc_fluid", "qfrc_bias",
    "qfrc_constraint", "ctrl", "actuator_length", "actuator_velocity", "xfrc_applied", "mocap_pos",
    "mocap_quat",
)  # fmt: skip
"""Arrays that still hold what acted in a step when it has been made."""
CONTACT = (
    "dist", "pos", "frame", "includemargin", "friction", "solref", "solreffriction", "solimp", "dim", "geom",
    "exclude", "efc_address",
)  # fmt: skip
"""Fields of an MjContact that are read."""


class Scheme(IntEnum):
    """How a step was integrated."""

    EULER, IMPLICIT, RK4 = range(3)


class RawSteps:
    """Rows of raw copies of one MjData.

    Parameters
    ----------
    mujoco, model, data
        The module and its own.
    room
        Number of rows that there is room for at first.
    again
        Whether steps are to be made again that MuJoCo does not keep as a whole.

    Attributes
    ----------
    start
        (s,) the state that the next step starts from, see `remember`.
    count, room
        Number of rows so far, and how many there is room for.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any, room: int, again: bool = True) -> None:
        self._mujoco, self._model, self._data, self._option = mujoco, model, data, model.opt
        kinds = mujoco.mjtIntegrator
        state = {name: getattr(data, name) for name in START}
        kept = {name: getattr(data, name) for name in DURING}
        if model.opt.integrator in (kinds.mjINT_IMPLICIT, kinds.mjINT_IMPLICITFAST):
            kept["qDeriv"] = data.qDeriv
        self._start_table = MemoryTable(list(state.values()))
        self._table = MemoryTable([*kept.values(), *state.values()])
        self.start = np.zeros(self._start_table.size)
        shapes = {f"start_{name}": view.shape for name, view in state.items()}
        shapes |= {name: view.shape for name, view in kept.items()}
        shapes |= {f"end_{name}": view.shape for name, view in state.items()}
        shapes["contact_joints"] = (model.nv,)
        # What MuJoCo can make a step again from: needed where it does not keep all of it.
        self._pgs = model.opt.solver == mujoco.mjtSolver.mjSOL_PGS
        self._again = again
        self._whole_state = again and bool(self._pgs or model.opt.integrator == kinds.mjINT_RK4)
        self._spec = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        self._state = np.zeros(mujoco.mj_stateSize(model, self._spec))
        if self._whole_state:
            shapes["state"] = self._state.shape
        self._fields: dict[str, tuple[slice, tuple[int, ...]]] = {}
        at = 0
        for name, shape in shapes.items():
            size = int(np.prod(shape, dtype=np.int64))
            self._fields[name] = slice(at, at + size), shape
            at += size
        self.room, self.count = room, 0
        self._flat, self._times = np.zeros((room, at)), np.zeros((room, 2))
        # first contact, their number, first constraint, their number, scheme, whether the solver may be off
        self._places = np.zeros((room, 6), dtype=np.int64)
        self._states: dict[int, FloatArray] = {}
        self._struct: np.dtype[Any] | None = None
        self._contacts, self._efc = np.zeros((0, 1)), np.zeros((2, 0))
        self._next = 0, 0
        self._niter = data.solver_niter
        self._constraint, self._joints = self._fields["qfrc_constraint"][0], self._fields["contact_joints"][0]
        self._copy = entry_point(copy_parts, *COPY_TYPES)
        self._copy_step = entry_point(copy_step, *STEP_TYPES)
        self._copy_contacts = entry_point(copy_contacts, *CONTACT_TYPES)

    def remember(self) -> None:
        """Keep the state that the next step starts from."""
        self._copy(self._start_table.base, self._start_table.parts, self.start)

    def start_from_last(self) -> None:
        """Let the next step start where the last one ended."""
        if self.count:
            first, end = self._fields["end_qpos"][0].start, self._fields["contact_joints"][0].start
            self.start[:] = self._flat[self.count - 1, first:end]

    def take(self, time: float, step: float, scheme: int) -> None:
        """Copy what the data holds of a step that started at a time and had a length [s]."""
        data, at = self._data, self.count
        nefc, ncon = data.nefc, data.ncon
        contacts, rows = self._next
        self._copy_step(
            self._table.base, self._table.parts, self.start, self._flat, at, self._times, time, step,
            self._places, contacts, ncon, rows, nefc, scheme,
        )  # fmt: skip
        if nefc:
            self._take_joints(at, data, nefc)
        if ncon:
            self._take_contacts(data, contacts, ncon, rows, nefc)
            if self._again and not self._converged(data):
                self._places[at, 5] = 1
                self._take_state(at)
            elif self._whole_state:
                self._take_state(at)
        elif self._whole_state:
            self._take_state(at)
        self._next = contacts + ncon, rows + nefc
        self.count = at + 1  # last: an interrupted row is none

    def _take_joints(self, at: int, data: Any, rows: int) -> None:
        """Write what contacts put on the joints, where other constraints act there too."""
        first = data.ne + data.nf + data.nl  # rows of contacts come last
        if 0 < first < rows:
            touching = data.efc_force.copy()
            touching[:first] = 0.0
            self._mujoco.mj_mulJacTVec(self._model, data, self._flat[at, self._joints], touching)
        elif first:
            self._flat[at, self._joints] = 0.0
        else:
            self._flat[at, self._joints] = self._flat[at, self._constraint]

    def _take_contacts(self, data: Any, at: int, count: int, row: int, rows: int) -> None:
        """Copy contacts and constraint forces behind those that are there."""
        found = data.contact.dist
        if self._struct is None:
            self._struct = contact_struct(data.contact)
            self._contacts = np.zeros((256, self._struct.itemsize // 8))
        if at + count > len(self._contacts):
            more = np.zeros((at + 2 * count, self._contacts.shape[1]))
            self._contacts = np.concatenate([self._contacts, more])
        if row + rows > self._efc.shape[1]:
            self._efc = np.hstack([self._efc, np.zeros((2, row + 2 * rows + 256))])
        self._copy_contacts(found, data.efc_force, data.efc_R, self._contacts, at, self._efc, row)

    def _take_state(self, at: int) -> None:
        """Copy what MuJoCo can make the step again from."""
        self._mujoco.mj_getState(self._model, self._data, self._state, self._spec)
        if self._whole_state:
            self._flat[at, self._fields["state"][0]] = self._state
        else:
            self._states[at] = self._state.copy()

    def _converged(self, data: Any) -> bool:
        """Return whether the solver says of all islands that it converged; PGS does not look."""
        if self._pgs:
            return False
        islands, most = data.nisland, self._option.iterations
        if islands <= 1:
            return bool(self._niter[0] < most)
        return bool((self._niter[:islands] < most).all())

    def grow(self) -> None:
        """Make room for twice as many rows."""
        self._flat, self._times, self._places = (
            np.concatenate([a, np.zeros_like(a)]) for a in (self._flat, self._times, self._places)
        )
        self.room *= 2

    def clear(self) -> None:
        """Forget the rows."""
        self.start_from_last()
        self._states = {}
        self.count, self._next = 0, (0, 0)

    @property
    def bytes(self) -> int:
        """Memory that the rows so far need."""
        contacts, rows = self._next
        return 8 * (self.count * self._flat.shape[1] + contacts * self._contacts.shape[1] + 2 * rows)

    def rows(self, first: int, end: int) -> RawBlock:
        """Return some of the rows."""
        return RawBlock(self, first, end)


class RawBlock:
    """Consecutive rows of raw copies, by the names of MjData.

    Attributes
    ----------
    time, step
        (n,) time at the start of each step, and its length [s].
    schemes
        (n,) of `Scheme`.
    doubtful
        Rows with contacts whose solver does not say that it converged.
    contacts
        MuJoCo's contacts of all rows, with the fields `CONTACT`, and `contact_row` (c,) which row each is of.
    """

    def __init__(self, raw: RawSteps, first: int, end: int) -> None:
        self._flat, self._fields = raw._flat[first:end], raw._fields
        self._states = {at - first: state for at, state in raw._states.items() if first <= at < end}
        self.time, self.step = raw._times[first:end].T
        places = raw._places[first:end]
        self.schemes, self.doubtful = places[:, 4], np.flatnonzero(places[:, 5]).tolist()
        low, count = (int(places[0, 0]), int(places[:, 1].sum())) if len(places) else (0, 0)
        if count and raw._struct is not None:
            self.contacts: Any = raw._contacts[low : low + count].reshape(-1).view(raw._struct)
        else:
            self.contacts = np.zeros(0, _no_contacts())
        self.contact_row: IntArray = np.repeat(np.arange(end - first), places[:, 1])
        self._forces, self._R = raw._efc
        self._row_at = np.repeat(places[:, 2], places[:, 1])

    def __len__(self) -> int:
        return len(self._flat)

    def __getitem__(self, name: str) -> FloatArray:
        part, shape = self._fields[name]
        return self._flat[:, part].reshape(len(self._flat), *shape)

    def __contains__(self, name: object) -> bool:
        return name in self._fields

    def state(self, row: int) -> FloatArray | None:
        """Return MuJoCo's whole state (k,) after a step; None where it is not kept."""
        return self["state"][row] if "state" in self else self._states.get(row)

    def constraint(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return force and R (c,) of a row of constraints of each contact, zero where it has none."""
        address = self.contacts["efc_address"]
        at = np.where(address >= 0, self._row_at + address + number, 0)
        if not self._forces.size:
            return np.zeros(len(at)), np.zeros(len(at))
        at = np.minimum(at, self._forces.size - 1)
        on = address >= 0
        return np.where(on, self._forces[at], 0.0), np.where(on, self._R[at], 0.0)


def contact_struct(contacts: Any) -> np.dtype[Any]:
    """Return MuJoCo's contact struct as a NumPy type, as its own arrays of fields lie in memory."""
    base = contacts.dist.__array_interface__["data"][0]
    fields = {name: getattr(contacts, name) for name in CONTACT}
    return np.dtype(
        {
            "names": list(fields),
            "formats": [(view.dtype, view.shape[1:]) for view in fields.values()],
            "offsets": [view.__array_interface__["data"][0] - base for view in fields.values()],
            "itemsize": contacts.dist.strides[0],
        }
    )


def _no_contacts() -> np.dtype[Any]:
    """Return a type with the fields of a contact, for none of them."""
    shapes = {"pos": 3, "frame": 9, "friction": 5, "solref": 2, "solreffriction": 2, "solimp": 5, "geom": 2}
    whole = ("dim", "geom", "exclude", "efc_address")
    return np.dtype([(n, "i4" if n in whole else "f8", (shapes[n],) if n in shapes else ()) for n in CONTACT])
