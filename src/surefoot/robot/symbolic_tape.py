"""An expression at many points at once: its instructions are carried out for eight of them side by side.

CasADi walks the list of instructions once for every knot of a motion, and most of that time goes into finding
out what is to be done next. Here every instruction is looked up once for `LANES` knots.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import kernel
from surefoot.robot.libraries import import_casadi

LANES = 8
"""Knots side by side: a cache line of numbers."""
OPERATIONS = {
    "INPUT": (0, 0, 0), "OUTPUT": (1, 0, 0), "CONST": (2, 0, 0), "ADD": (3, 0, 1), "SUB": (4, 0, 1),
    "MUL": (5, 0, 1), "DIV": (6, 0, 1), "SQRT": (7, 0, 0), "SIN": (8, 0, 0), "COS": (9, 0, 0),
    "TWICE": (3, 0, 0), "SQ": (5, 0, 0), "NEG": (4, -2, 0), "ASSIGN": (3, 0, -2), "INV": (6, -1, 0),
}  # fmt: skip
"""CasADi's names to the codes of `play` and which operands it takes; -2 and -1 are rows of zeros and ones."""


def mapped(function: Any, count: int) -> Any:
    """Return a function of SX at `count` knots side by side, as its own `map` would be.

    Where it does what `play` cannot, it is that.
    """
    ca, size, slots = import_casadi(), int(function.n_instructions()), int(function.sz_w())
    codes = {int(getattr(ca, f"OP_{name}")): code for name, code in OPERATIONS.items()}
    said = [int(function.instruction_id(k)) for k in range(size)]
    if not set(said) <= set(codes):
        return function.map(count)
    table, constants = np.zeros((size, 4), dtype=np.int64), np.zeros(size)
    starts = np.cumsum([0, *(int(function.nnz_in(k)) for k in range(function.n_in()))])
    ends = np.cumsum([0, *(int(function.nnz_out(k)) for k in range(function.n_out()))])
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
    return _callback(function, count, table, constants, ends)


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


def _callback(function: Any, count: int, table: IntArray, constants: FloatArray, ends: IntArray) -> Any:
    """Return what CasADi calls in place of the function's `map`."""
    ca = import_casadi()
    work = np.zeros((int(function.sz_w()) + 2, LANES))
    work[-1] = 1.0

    class Mapped(ca.Callback):  # type: ignore[misc, name-defined]
        """The function at all knots; CasADi asks for its sizes by these names."""

        def __init__(self) -> None:
            ca.Callback.__init__(self)
            self.construct(f"mapped_{function.name()}", {})

        def get_n_in(self) -> int:
            """Return the function's own number."""
            return int(function.n_in())

        def get_n_out(self) -> int:
            """Return the function's own number."""
            return int(function.n_out())

        def get_sparsity_in(self, i: int) -> Any:
            """Return the function's, once for every knot."""
            return ca.repmat(function.sparsity_in(i), 1, count)

        def get_sparsity_out(self, i: int) -> Any:
            """Return the function's, once for every knot."""
            return ca.repmat(function.sparsity_out(i), 1, count)

        def has_eval_buffer(self) -> bool:
            """Return that numbers are passed as they lie in memory."""
            return True

        def eval_buffer(self, arguments: Any, results: Any) -> int:
            """Write the results; 0 for success."""
            given = [np.frombuffer(a).reshape(count, -1) for a in arguments if a is not None and len(a)]
            found = np.empty((count, int(ends[-1])))
            play(table, constants, np.hstack(given), found, work)
            for k, result in enumerate(results):
                if result is not None:
                    np.frombuffer(result)[:] = found[:, ends[k] : ends[k + 1]].ravel()
            return 0

    return Mapped()
