"""HPIPM on the MPC's horizon, through the shared library that CasADi's wheel carries.

CasADi's own interface copies matrices into general sparse form first; calling the library directly gives
HPIPM what its Riccati recursion wants: one stage after the other, with the first state eliminated, the
pyramids as general constraints and the normal bounds as bounds of the inputs. Timed are the copy of all
stages into its format, the solve and reading the inputs.

References
----------
.. [1] G. Frison, M. Diehl, "HPIPM: a high-performance quadratic programming framework for model predictive
   control", IFAC-PapersOnLine 53(2), 2020.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import MissingExtra

if TYPE_CHECKING:
    from benchmarks.walk.rivals import Matrices, Variant

STATES, ITERATIONS = 12, 100
SPEED, BALANCE = 1, 2
"""Its modes: relative formulation with focus on speed, and balanced with robustness."""
FIELDS = (
    "A", "B", "b", "Q", "S", "R", "q", "r", "idxbx", "lbx", "ubx", "idxbu", "lbu", "ubu", "C", "D", "lg",
    "ug", "Zl", "Zu", "zl", "zu", "idxs", "idxs_rev", "ls", "us",
)  # fmt: skip
"""Order of the arguments of `d_ocp_qp_set_all`, each an array of one pointer per stage."""


def hpipm_installed() -> bool:
    """Tell whether CasADi's wheel is installed and carries HPIPM."""
    return _library_path() is not None


def _library_path() -> Path | None:
    found = find_spec("casadi")
    if found is None or found.origin is None:
        return None
    end = {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")
    path = Path(found.origin).with_name(f"libhpipm{end}")
    return path if path.exists() else None


@lru_cache(maxsize=1)
def _library() -> Any:
    path = _library_path()
    if path is None:
        raise MissingExtra("casadi", "plan")
    ctypes.CDLL(str(path.with_name(path.name.replace("hpipm", "blasfeo"))), mode=ctypes.RTLD_GLOBAL)
    library = ctypes.CDLL(str(path))
    for kind in ("", "_dim", "_sol", "_ipm_arg", "_ipm_ws"):
        for size in ("strsize", "memsize"):
            getattr(library, f"d_ocp_qp{kind}_{size}").restype = ctypes.c_size_t
    return library


@dataclass(frozen=True)
class Stages:
    """A horizon as HPIPM takes it: numbers per stage, and pointers to them in the order of `FIELDS`."""

    matrices: Matrices
    inputs: tuple[int, ...]
    facets: int
    pointers: tuple[Any, ...]
    data: dict[str, list[Any]]


def stages(m: Matrices) -> Stages:
    """Return the stages of a horizon from its sparse form (column by column, as HPIPM stores them)."""
    facets, step = m.structure[0], np.array(m.structure[1], dtype=np.int64)
    steps = m.b.size // STATES
    A, P, C = m.A.toarray(), m.P.toarray(), m.C.toarray()
    rows = np.arange(m.low.size).reshape(-1, facets + 1)  # of each contact: its facets, then its normal bound
    first = 3 * m.mu.size
    data: dict[str, list[Any]] = {name: [] for name in FIELDS}
    for k in range(steps + 1):
        feet = np.flatnonzero(step == k)
        u = (3 * feet[:, None] + np.arange(3)).ravel()
        x = first + STATES * (k - 1) + np.arange(STATES) if k else np.zeros(0, dtype=np.int64)
        if k < steps:
            row = STATES * k + np.arange(STATES)
            stage = {"A": -A[np.ix_(row, x)], "B": -A[np.ix_(row, u)], "b": m.b[row]}
        else:
            stage = {"A": np.zeros((0, 0)), "B": np.zeros((0, 0)), "b": np.zeros(0)}
        side, bound = rows[feet, :-1].ravel(), rows[feet, -1]
        stage |= {
            "Q": P[np.ix_(x, x)], "R": P[np.ix_(u, u)], "q": m.q[x], "r": m.q[u], "D": C[np.ix_(side, u)],
            "S": np.zeros((u.size, x.size)), "C": np.zeros((side.size, x.size)),
            "lg": np.zeros(side.size), "ug": m.high[side], "lbu": m.low[bound], "ubu": m.high[bound],
        }  # fmt: skip
        for name in FIELDS:
            data[name].append(np.asfortranarray(stage.get(name, np.zeros(0)), dtype=np.float64))
        data["idxbu"][-1] = (3 * np.arange(feet.size) + 2).astype(np.int32)
    pointers = tuple(
        (ctypes.c_void_p * (steps + 1))(*(array.ctypes.data for array in data[name])) for name in FIELDS
    )
    inputs = tuple(array.size for array in data["r"])
    return Stages(m, inputs, facets, pointers, data)


class _Workspace:
    """HPIPM's objects for one pattern of stages."""

    def __init__(self, like: Stages, tol: float, warm: bool, mode: int) -> None:
        library = self.library = _library()
        last = len(like.inputs) - 1
        self.owned: list[Any] = []
        self.inputs = [np.zeros(count) for count in like.inputs]
        contacts = [count // 3 for count in like.inputs]
        dim = self._make("_dim", ctypes.c_int(last))
        counts = (
            [0] + [STATES] * last, list(like.inputs), [0] * (last + 1), contacts,
            [like.facets * c for c in contacts], [0] * (last + 1),
        )  # fmt: skip
        library.d_ocp_qp_dim_set_all(*((ctypes.c_int * (last + 1))(*c) for c in counts), dim)
        self.qp, self.solution = self._make("", dim), self._make("_sol", dim)
        library.d_ocp_qp_set_all_zero(self.qp)
        self.options = self._make("_ipm_arg", dim)
        library.d_ocp_qp_ipm_arg_set_default(ctypes.c_int(mode), self.options)
        for name in ("stat", "eq", "ineq", "comp"):
            self._set(f"tol_{name}", ctypes.c_double(tol))
        self._set("iter_max", ctypes.c_int(ITERATIONS))
        self._set("warm_start", ctypes.c_int(int(warm)))
        self.space = self._make("_ipm_ws", dim, self.options)
        for k, c in enumerate(contacts):  # a pyramid's sides have no lower bound
            none = np.zeros(like.facets * c)
            library.d_ocp_qp_set_lg_mask(ctypes.c_int(k), ctypes.c_void_p(none.ctypes.data), self.qp)
        self.reads = [
            (ctypes.c_int(k), self.solution, ctypes.c_void_p(u.ctypes.data))
            for k, u in enumerate(self.inputs)
        ]

    def _make(self, kind: str, *arguments: Any) -> Any:
        """Return one of HPIPM's structs in memory of ours."""
        library, name = self.library, f"d_ocp_qp{kind}"
        struct = ctypes.create_string_buffer(getattr(library, f"{name}_strsize")())
        memory = ctypes.create_string_buffer(getattr(library, f"{name}_memsize")(*arguments))
        self.owned += [struct, memory]
        before = arguments[:1] if kind == "_dim" else arguments
        getattr(library, f"{name}_create")(*before, struct, memory)
        return struct

    def _set(self, name: str, value: Any) -> None:
        getattr(self.library, f"d_ocp_qp_ipm_arg_set_{name}")(ctypes.byref(value), self.options)

    def solve(self, given: Stages) -> FloatArray:
        """Copy the stages in, solve, and return all inputs."""
        library = self.library
        library.d_ocp_qp_set_all(*given.pointers, self.qp)
        library.d_ocp_qp_ipm_solve(self.qp, self.solution, self.options, self.space)
        for read in self.reads:
            library.d_ocp_qp_sol_get_u(*read)
        return np.concatenate(self.inputs)


def solver(variant: Variant) -> Callable[[Stages], FloatArray]:
    """Return the solve of a variant ("sparse", or "sparse, balanced"), with a workspace for every pattern."""
    kept: dict[Any, _Workspace] = {}
    mode = BALANCE if "balanced" in variant.form else SPEED

    def solve(given: Stages) -> FloatArray:
        m = given.matrices
        space = kept.get(m.structure)
        if space is None:
            space = kept[m.structure] = _Workspace(given, variant.tol, variant.warm, mode)
        return np.asarray(m.scale * space.solve(given).reshape(-1, 3))

    return solve
