"""An expression at many points at once: its instructions are carried out for many of them side by side.

CasADi walks the instructions once for every knot of a motion, and most of that time goes into finding
out what is to be done next. Here every instruction is looked up once for `LANES` knots. Tables are kept on
disk.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.base.libraries import import_casadi

LANES = 32
"""Knots side by side: a fifth less time than with 8."""
FILES = 32
"""Most files of tapes that are kept, 4 MB each."""
OPERATIONS = {
    "INPUT": (0, 0, 0), "OUTPUT": (1, 0, 0), "CONST": (2, 0, 0), "ADD": (3, 0, 1), "SUB": (4, 0, 1),
    "MUL": (5, 0, 1), "DIV": (6, 0, 1), "SQRT": (7, 0, 0), "SIN": (8, 0, 0), "COS": (9, 0, 0),
    "TWICE": (3, 0, 0), "SQ": (5, 0, 0), "NEG": (4, -2, 0), "ASSIGN": (3, 0, -2), "INV": (6, -1, 0),
}  # fmt: skip
"""CasADi's names to the codes of `play` and which operands it takes; -2 and -1 are rows of zeros and ones."""


@dataclass(frozen=True, eq=False)
class Tape:
    """The instructions of a function of SX.

    Attributes
    ----------
    table, constants
        (n, 4) and (n,), see `play`.
    slots
        Rows that they work in.
    inputs, outputs
        Patterns of what goes in and comes out, as CasADi writes them.
    """

    table: IntArray
    constants: FloatArray
    slots: int
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def map_over(self, count: int) -> Any:
        """Return the function at `count` knots side by side, as its own `map` would be."""
        ca, tape = import_casadi(), self
        work = np.zeros((tape.slots + 2, LANES))
        work[-1] = 1.0
        patterns = [[ca.Sparsity.deserialize(one) for one in side] for side in (tape.inputs, tape.outputs)]
        ends = np.cumsum([0, *(one.nnz() for one in patterns[1])])

        class Mapped(ca.Callback):  # type: ignore[misc, name-defined]
            """The function at all knots; CasADi asks for its sizes by these names."""

            def __init__(self) -> None:
                ca.Callback.__init__(self)
                self.construct("mapped", {})

            def get_n_in(self) -> int:
                """Return the function's own number."""
                return len(patterns[0])

            def get_n_out(self) -> int:
                """Return the function's own number."""
                return len(patterns[1])

            def get_sparsity_in(self, i: int) -> Any:
                """Return the function's, once for every knot."""
                return ca.repmat(patterns[0][i], 1, count)

            def get_sparsity_out(self, i: int) -> Any:
                """Return the function's, once for every knot."""
                return ca.repmat(patterns[1][i], 1, count)

            def has_eval_buffer(self) -> bool:
                """Return that numbers are passed as they lie in memory."""
                return True

            def eval_buffer(self, arguments: Any, results: Any) -> int:
                """Write the results; 0 for success."""
                given = [np.frombuffer(a).reshape(count, -1) for a in arguments if a is not None and len(a)]
                found = np.empty((count, int(ends[-1])))
                play(tape.table, tape.constants, np.hstack(given), found, work)
                for k, result in enumerate(results):
                    if result is not None:
                        np.frombuffer(result)[:] = found[:, ends[k] : ends[k + 1]].ravel()
                return 0

        return Mapped()

    def sparsity_out(self, i: int) -> Any:
        """Return the pattern of an output, as the function itself would."""
        return import_casadi().Sparsity.deserialize(self.outputs[i])


def record_tape(function: Any) -> Tape | None:
    """Return the instructions of a function of SX; None where it does what `play` cannot."""
    ca, size, slots = import_casadi(), int(function.n_instructions()), int(function.sz_w())
    codes = {int(getattr(ca, f"OP_{name}")): code for name, code in OPERATIONS.items()}
    said = [int(function.instruction_id(k)) for k in range(size)]
    if not set(said) <= set(codes):
        return None
    table, constants = np.zeros((size, 4), dtype=np.int64), np.zeros(size)
    inputs = [function.sparsity_in(k) for k in range(function.n_in())]
    outputs = [function.sparsity_out(k) for k in range(function.n_out())]
    starts, ends = (np.cumsum([0, *(one.nnz() for one in side)]) for side in (inputs, outputs))
    for k, name in enumerate(said):
        (code, one, two), to, of = codes[name], function.instruction_output(k), function.instruction_input(k)
        if code == 0:
            table[k] = code, to[0], starts[of[0]] + of[1], 0
        elif code == 1:
            table[k] = code, ends[to[0]] + to[1], of[0], 0
        elif code == 2:
            table[k, :2], constants[k] = (code, to[0]), function.instruction_constant(k)
        else:
            table[k] = code, to[0], *(of[at] if at >= 0 else slots + 2 + at for at in (one, two))
    sides = (tuple(one.serialize() for one in side) for side in (inputs, outputs))
    return Tape(table, constants, slots, *sides)


def tapes_of(source: Any, names: Sequence[str], write: Callable[[], Mapping[str, Any]]) -> dict[str, Any]:
    """Return the tapes of functions derived from `source`, by name; those that have none as they are.

    They are kept beside compiled code, under all that `source` computes: to derive and record those of a
    jump takes a second.

    Parameters
    ----------
    source
        Function of SX from which all others follow.
    names
        Of the others.
    write
        Derives them.
    """
    said, folder = source.serialize() + import_casadi().__version__ + "".join(names), _folder()
    file = Path(folder or "", f"tapes-{hashlib.sha256(said.encode()).hexdigest()[:32]}.npz")
    with contextlib.suppress(OSError, KeyError, ValueError, zipfile.BadZipFile), np.load(file) as held:
        return {name: _read(held, name) for name in names}
    found = {name: record_tape(function) or function for name, function in write().items()}
    tapes = {name: tape for name, tape in found.items() if isinstance(tape, Tape)}
    if folder and len(tapes) == len(found):
        _keep(tapes, file)
    return found


def _folder() -> str | None:
    """Return where compiled code is kept; None for nowhere."""
    play(np.zeros((0, 4), dtype=np.int64), *np.zeros((1, 1)), *np.zeros((3, 1, LANES)))  # then it is known
    return getattr(getattr(play, "_cache", None), "cache_path", None)


def _read(held: Mapping[str, Any], name: str) -> Tape:
    inputs, outputs = (tuple(held[f"{name}_{side}"].tolist()) for side in ("inputs", "outputs"))
    table = held[f"{name}_table"].astype(np.int64)
    return Tape(table, held[f"{name}_constants"], int(held[f"{name}_slots"]), inputs, outputs)


def _keep(tapes: Mapping[str, Tape], file: Path) -> None:
    """Write tapes, and remove the oldest files of more than `FILES`; nothing where nobody may write."""
    arrays = dict[str, Any]()
    for name, tape in tapes.items():
        arrays |= {f"{name}_{part}": value for part, value in vars(tape).items()}
        arrays[f"{name}_table"] = tape.table.astype(np.int32)
    with contextlib.suppress(OSError):
        part = file.with_suffix(f".{os.getpid()}.part")
        with part.open("wb") as stream:  # a name of its own: another process may write the same
            np.savez(stream, **arrays)
        part.replace(file)
        there = sorted(file.parent.glob("tapes-*.npz"), key=lambda one: one.stat().st_mtime)
        for old in there[:-FILES]:
            old.unlink(missing_ok=True)


@kernel
def play(
    table: IntArray, constants: FloatArray, given: FloatArray, found: FloatArray, work: FloatArray
) -> None:
    """Carry out a table of instructions: (n, 4) code, to, of, and of.

    Parameters
    ----------
    table, constants
        And (n,) the constants that instructions set.
    given, found
        (count, i) inputs of every knot, (count, o) outputs.
    work
        (slots + 2, `LANES`) to work in; its last two rows are zeros and ones.
    """
    count, size = given.shape[0], len(table)
    held = np.empty(LANES)
    for first in range(0, count, LANES):
        # The last round repeats its last knot in the lanes that are left over: loops of one fixed length are
        # vectorised.
        lanes = min(LANES, count - first)
        for k in range(size):
            code, to, one, two = table[k, 0], table[k, 1], table[k, 2], table[k, 3]
            # into `held` first: what is read and what is written may be one row
            if code == 5:
                for j in range(LANES):
                    held[j] = work[one, j] * work[two, j]
            elif code == 3:
                for j in range(LANES):
                    held[j] = work[one, j] + work[two, j]
            elif code == 4:
                for j in range(LANES):
                    held[j] = work[one, j] - work[two, j]
            elif code == 1:
                for j in range(lanes):
                    found[first + j, to] = work[one, j]
                continue
            elif code == 0:
                for j in range(LANES):
                    held[j] = given[first + min(j, lanes - 1), one]
            elif code == 2:
                held[:] = constants[k]
            elif code == 6:
                for j in range(LANES):
                    held[j] = work[one, j] / work[two, j]
            else:
                for j in range(LANES):
                    x = work[one, j]
                    held[j] = np.sqrt(x) if code == 7 else np.sin(x) if code == 8 else np.cos(x)
            for j in range(LANES):
                work[to, j] = held[j]
