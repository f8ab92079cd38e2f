"""Raw copies of what MuJoCo held at every step of a loop: no arithmetic, a few microseconds each.

All arrays of an MjData with a fixed size go into one flat row; of contacts what is read of MuJoCo's own
structs, constraint forces behind each other. What they mean is worked out later, for many rows at once.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import entry_point
from surefoot.worlds.mujoco.memory_places import all_memory, contact_struct
from surefoot.worlds.mujoco.record_copy import (
    AGAIN,
    BEGUN,
    CONSTRAINT,
    COPY_TYPES,
    DOUBTFUL,
    JOINTS,
    LAST,
    NO_ROOM,
    PGS,
    PUSHED,
    START_TYPES,
    STEP_TYPES,
    STRUCT,
    VELOCITIES,
    MemoryTable,
    copy_parts,
    note_start,
    take_step,
)
from surefoot.worlds.mujoco.record_places import StepPlaces

START = ("qpos", "qvel", "act", "qacc_warmstart")
"""Arrays of the state that a step starts from."""
DURING = (
    "qacc", "qfrc_actuator", "qfrc_applied", "qfrc_passive", "qfrc_gravcomp", "qfrc_fluid", "qfrc_bias",
    "qfrc_constraint", "ctrl", "actuator_length", "actuator_velocity", "xfrc_applied", "mocap_pos",
    "mocap_quat",
)  # fmt: skip
"""Arrays that still hold what acted in a step when it has been made."""
RAW_BYTES = 64 << 20
"""Raw copies that are held before they are worked out [bytes]; room for them is taken as it is filled."""
MOST_RAW_ROWS = 1 << 14
"""And the most of them."""
READY = 2 << 20
"""Memory of each kind of row that is taken before the loop [bytes]: a page may take as long as a step."""
RARE = ("qfrc_applied", "xfrc_applied", "qfrc_gravcomp", "qfrc_fluid")
"""Arrays that are zero in most loops: kept of the steps alone in which they are not."""
OF_STATE = (*START, "ctrl", "qfrc_applied", "xfrc_applied", "mocap_pos", "mocap_quat")
"""Arrays of MuJoCo's whole state that are kept anyhow."""


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
        Number of rows that there is room for, None for as many as `RAW_BYTES` hold.
    again
        Whether steps are to be made again that MuJoCo does not keep as a whole.

    Attributes
    ----------
    clock
        (2,) the times `last` and `begun`, which compiled code writes.
    """

    def __init__(
        self, mujoco: Any, model: Any, data: Any, room: int | None = None, again: bool = True
    ) -> None:
        self._mujoco, self._model, self._data = mujoco, model, data
        kinds = mujoco.mjtIntegrator
        state = {name: getattr(data, name) for name in START}
        kept = {name: getattr(data, name) for name in DURING}
        if model.opt.integrator in (kinds.mjINT_IMPLICIT, kinds.mjINT_IMPLICITFAST):
            kept["qDeriv"] = data.qDeriv
        rare = [name for name in RARE if not self._acts_always(name)]
        rare_views = {name: kept.pop(name) for name in rare}
        self._rare_table = MemoryTable(list(rare_views.values()))
        self._start_table = MemoryTable(list(state.values()))
        self._table = MemoryTable([*kept.values(), *state.values()])
        self._start, self.clock = np.zeros(self._start_table.size), np.full(2, data.time)
        shapes = {f"start_{name}": view.shape for name, view in state.items()}
        shapes |= {name: view.shape for name, view in kept.items()}
        shapes |= {f"end_{name}": view.shape for name, view in state.items()}
        shapes["contact_joints"] = (model.nv,)
        self._fields: dict[str, tuple[slice, tuple[int, ...]]] = {}
        at = _lay_out(shapes, self._fields)
        self._rare_fields: dict[str, tuple[slice, tuple[int, ...]]] = {}
        _lay_out({name: view.shape for name, view in rare_views.items()}, self._rare_fields)
        self._rare: dict[int, FloatArray] = {}
        # What MuJoCo can make a step again from, where it does not keep all of it and the rows do not either.
        pgs = model.opt.solver == mujoco.mjtSolver.mjSOL_PGS
        self._spec = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        whole = mujoco.mj_stateSize(model, self._spec)
        self._beyond = again and whole > 1 + sum(getattr(data, name).size for name in OF_STATE)
        self._whole_state = self._beyond and (pgs or model.opt.integrator == kinds.mjINT_RK4)
        self._states: dict[int, FloatArray] = {}
        self._struct, self._pieces = packed_struct(contact_struct(mujoco))
        rows = RAW_BYTES // 2 // (8 * at) if room is None else room
        rows, width = min(max(rows, 1), MOST_RAW_ROWS), int(self._pieces[:, 1].sum())
        self._flat, self._times = np.zeros((rows, at)), np.zeros((rows, 2))
        self._places = np.zeros((rows, 6), dtype=np.int64)
        self._contacts = np.zeros((max(RAW_BYTES // 4 // (8 * width), 1), width))
        self._efc = np.zeros((2, max(RAW_BYTES // 4 // 16, 1)))
        if room is None:
            for array in (self._flat, self._contacts, *self._efc):
                array.reshape(-1)[: READY // 8] = 0.0
        self._tail = np.zeros(3, dtype=np.int64)
        self._look = StepPlaces(mujoco, model, data)
        self._look.at[[AGAIN, PGS, VELOCITIES]] = again, pgs, model.nv
        self._look.at[[JOINTS, CONSTRAINT]] = [
            self._fields[name][0].start for name in ("contact_joints", "qfrc_constraint")
        ]
        self._look.at[STRUCT] = contact_struct(mujoco).itemsize // 8
        self._copy = entry_point(copy_parts, *COPY_TYPES)
        self._note, self._take = entry_point(note_start, *START_TYPES), entry_point(take_step, *STEP_TYPES)
        self._bind()

    def _bind(self) -> None:
        """Collect what the compiled passes are given."""
        memory, places, start = all_memory(), self._look.at, self._start_table
        self._to_start = memory[0], places, start.base, start.parts, self.clock, self._start
        kept, rare = ((table.base, table.parts) for table in (self._table, self._rare_table))
        rows, behind = (self._flat, self._times, self._places), (self._contacts, self._pieces, self._efc)
        self._to_take = memory, places, kept, rare, self.clock, self._start, rows, behind, self._tail

    @property
    def count(self) -> int:
        """Number of rows so far."""
        return int(self._tail[0])

    @property
    def last(self) -> float:
        """Time after the last step [s]."""
        return float(self.clock[LAST])

    @last.setter
    def last(self, time: float) -> None:
        self.clock[LAST] = time

    @property
    def begun(self) -> float:
        """Time at which the step under way began [s]."""
        return float(self.clock[BEGUN])

    @property
    def fell_back(self) -> bool:
        """Whether the last step ended earlier than it should have."""
        return self.last < self.begun + float(self._model.opt.timestep)

    def note_start(self) -> bool:
        """Keep the state that the next step starts from; return False if time has moved since the last."""
        if not self._look.known:
            self._look.refresh()
        return self._note(*self._to_start)

    def remember(self) -> None:
        """Keep the state that the next step starts from, whatever the time is."""
        self._copy(self._start_table.base, self._start_table.parts, self._start)
        self.clock[BEGUN] = self.clock[LAST] = self._data.time

    def start_from_last(self) -> None:
        """Let the next step start where the last one ended."""
        self.clock[BEGUN] = self.clock[LAST]
        if self.count:
            first, end = self._fields["end_qpos"][0].start, self._fields["contact_joints"][0].start
            self._start[:] = self._flat[self.count - 1, first:end]

    def take(self, scheme: int = -1) -> int:
        """Copy the step that the data has just made, by a scheme, and return what became of it.

        See `record_copy`: `NO_STEP`, `NO_ROOM`, else the bits `DOUBTFUL` and `PUSHED`.
        """
        if not self._look.known:
            self._look.refresh()
        out = self._take(*self._to_take, scheme)
        if out > 0 or (out == 0 and self._whole_state):
            self._take_more(out)
        return out

    def _take_more(self, found: int) -> None:
        """Copy what is kept of some steps alone."""
        row = self.count - 1
        if found & PUSHED:
            self._rare[row] = np.zeros(self._rare_table.size)
            self._copy(self._rare_table.base, self._rare_table.parts, self._rare[row])
        if self._whole_state or (self._beyond and found & DOUBTFUL):
            state = np.zeros(self._mujoco.mj_stateSize(self._model, self._spec))
            self._mujoco.mj_getState(self._model, self._data, state, self._spec)
            self._states[row] = state

    def _acts_always(self, name: str) -> bool:
        """Return whether a force that is zero in most models is none of those in this one."""
        option = self._model.opt
        if name == "qfrc_gravcomp":
            return bool(self._model.body_gravcomp.any())
        return name == "qfrc_fluid" and bool(option.density or option.viscosity)

    def take_instant(self, length: float, scheme: int) -> None:
        """Copy what the data holds of an instant at which no time passes, of a step of a length [s]."""
        self.clock[BEGUN] = self._data.time - self._model.opt.timestep
        while self.take(scheme) == NO_ROOM:
            self._enlarge()
        self._times[self.count - 1] = self._data.time, length

    def clear(self) -> None:
        """Forget the rows; if there are none, make room for more contacts."""
        if self.count == 0:
            self._enlarge()
        self._states, self._rare = {}, {}
        self._tail[:] = 0

    def _enlarge(self) -> None:
        """Make room for twice as many contacts and constraints."""
        self._contacts = np.concatenate([self._contacts, np.zeros_like(self._contacts)])
        self._efc = np.hstack([self._efc, np.zeros_like(self._efc)])
        self._bind()

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
        self._rare = {at - first: found for at, found in raw._rare.items() if first <= at < end}
        self._rare_fields = raw._rare_fields
        self.time, self.step = raw._times[first:end].T
        places = raw._places[first:end]
        self.schemes, self.doubtful = places[:, 4], np.flatnonzero(places[:, 5]).tolist()
        low, count = (int(places[0, 0]), int(places[:, 1].sum())) if len(places) else (0, 0)
        self.contacts: Any = raw._contacts[low : low + count].reshape(-1).view(raw._struct)
        self.contact_row: IntArray = np.repeat(np.arange(end - first), places[:, 1])
        self._forces, self._R = raw._efc
        self._row_at = np.repeat(places[:, 2], places[:, 1])

    def __len__(self) -> int:
        return len(self._flat)

    def __getitem__(self, name: str) -> FloatArray:
        if name in self._rare_fields:
            part, shape = self._rare_fields[name]
            out = np.zeros((len(self), *shape))
            for row, found in self._rare.items():
                out[row] = found[part].reshape(shape)
            return out
        part, shape = self._fields[name]
        return self._flat[:, part].reshape(len(self._flat), *shape)

    def __contains__(self, name: object) -> bool:
        return name in self._fields or name in self._rare_fields

    def state(self, row: int) -> FloatArray | None:
        """Return MuJoCo's whole state (k,) after a step; None where the arrays `OF_STATE` are all of it."""
        return self._states.get(row)

    def constraint(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return force and R (c,) of a row of constraints of each contact, zero where it has none."""
        address = self.contacts["efc_address"]
        at = np.where(address >= 0, self._row_at + address + number, 0)
        if not self._forces.size:
            return np.zeros(len(at)), np.zeros(len(at))
        at = np.minimum(at, self._forces.size - 1)
        on = address >= 0
        return np.where(on, self._forces[at], 0.0), np.where(on, self._R[at], 0.0)


def _lay_out(shapes: dict[str, tuple[int, ...]], fields: dict[str, tuple[slice, tuple[int, ...]]]) -> int:
    """Put arrays of some shapes behind each other, their places into `fields`, and return where they end."""
    at = 0
    for name, shape in shapes.items():
        size = int(np.prod(shape, dtype=np.int64))
        fields[name] = slice(at, at + size), shape
        at += size
    return at


def packed_struct(struct: np.dtype[Any]) -> tuple[np.dtype[Any], IntArray]:
    """Return a struct with nothing between its fields, and which words it takes of the given one.

    The words are (k, 2) runs: first word, and how many.
    """
    fields: Any = struct.fields
    ends = {name: (offset, offset + kind.itemsize) for name, (kind, offset) in fields.items()}
    words = sorted({w for first, end in ends.values() for w in range(first // 8, (end + 7) // 8)})
    place = {word: k for k, word in enumerate(words)}
    runs: list[list[int]] = []
    for word in words:
        if runs and word == sum(runs[-1]):
            runs[-1][1] += 1
        else:
            runs.append([word, 1])
    packed = {
        "names": list(fields),
        "formats": [kind for kind, _ in fields.values()],
        "offsets": [8 * place[first // 8] + first % 8 for first, _ in ends.values()],
        "itemsize": 8 * len(words),
    }
    return np.dtype(packed), np.array(runs, dtype=np.int64)  # type: ignore[call-overload]
