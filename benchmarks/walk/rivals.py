"""The MPC step through other solvers: QP solvers with pyramids, and Clarabel with exact cones.

Each rival is given the same program as ours, either condensed (the forces are the only unknowns) or sparse
(forces and states, with the model as equations), scaled to numbers near one, as matrices ready in its own
format: only its own update and solve are timed. One workspace per pattern of the matrices is kept from call
to call, with its warm start, wherever its interface allows it.
"""

from __future__ import annotations

import ctypes
import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from benchmarks.prepared import rival
from benchmarks.walk import hpipm as mpc_hpipm
from benchmarks.walk.horizon import HorizonProgram
from surefoot.base.arrays import FloatArray
from surefoot.contact.cones import FrictionPyramid
from surefoot.contact.solvers.backends import ConeProgram, Options, solve_program
from surefoot.contact.solvers.backends.program import stacked
from surefoot.motion.control.mpc import ConvexMpc

DECADES = tuple(range(-2, -12, -1))
"""Powers of ten that a rival's tolerance is tried at; it runs at the loosest eighth of a decade that does."""


class Matrices(NamedTuple):
    """min 1/2 zᵀ P z + qᵀ z subject to A z = b, low <= C z <= high; the first 3c entries of z are forces.

    Forces are divided by `scale`. For exact cones C has one row per contact (its normal force) and the
    cones come on top. `structure` is equal for two programs whose matrices have the same pattern.
    """

    P: Any
    q: FloatArray
    A: Any
    b: FloatArray
    C: Any
    low: FloatArray
    high: FloatArray
    mu: FloatArray
    scale: float
    structure: tuple[Any, ...]


@dataclass(frozen=True)
class Variant:
    """One way to run a rival."""

    form: str
    warm: bool
    tol: float

    def __str__(self) -> str:
        return f"{self.form}, {'warm' if self.warm else 'cold'}, {self.tol:.1e}"


@dataclass
class Rival:
    """A solver, its facets (None for exact cones) and how it can be run."""

    solver: str
    facets: int | None
    forms: tuple[str, ...]
    warm: tuple[bool, ...]
    ready: Callable[[Matrices, str], Any] = field(repr=False)
    make: Callable[[Variant], Callable[[Any], FloatArray]] = field(repr=False)

    @property
    def name(self) -> str:
        """What a table says."""
        return f"{self.solver}, {'exact cones' if self.facets is None else f'{self.facets} facets'}"

    def pack(self, mpc: ConvexMpc, program: HorizonProgram, form: str) -> Any:
        """Return the program in this rival's format (not timed)."""
        sparse, dense = form.startswith("sparse"), form.startswith("dense")
        return self.ready(matrices(mpc, program, self.facets, sparse=sparse, dense=dense), form)


def driven(
    solver: str, facets: int | None, forms: tuple[str, ...], warm: tuple[bool, ...], own: dict[str, Any]
) -> Rival:
    """Return the rival that a backend of `surefoot.contact.solvers` is, with settings by its own names."""

    def ready(m: Matrices, form: str) -> tuple[Matrices, Any]:
        return m, rival(solver.lower(), Options(sparse=form == "sparse")).ready(cone_program(m))

    def make(variant: Variant) -> Callable[[tuple[Matrices, Any]], FloatArray]:
        sparse = variant.form == "sparse"
        options = Options(variant.tol, keep=True, warm=variant.warm, sparse=sparse, own=own)
        run = rival(solver.lower(), options)

        def solve(item: tuple[Matrices, Any]) -> FloatArray:
            m, given = item
            return _forces(run.read(run.call(given)()).x, m)

        return solve

    return Rival(solver, facets, forms, warm, ready, make)


def rivals() -> list[Rival]:
    """Return all rivals, fresh; HPIPM and qpOASES only where CasADi's wheel brings them.

    Raises
    ------
    MissingExtra
        If the packages of the extra `qp` are not installed.
    """
    out = []
    for facets in (4, 8):
        out += [
            driven("OSQP", facets, ("condensed", "sparse"), (True, False), {"check_termination": 10}),
            driven("ProxQP", facets, ("dense", "sparse"), (True, False), {}),
            driven("PIQP", facets, ("dense", "sparse"), (False,), {"check_duality_gap": False}),
            driven("DAQP", facets, ("dense",), (True, False), {}),
        ]
        if mpc_hpipm.hpipm_installed():
            forms = ("sparse", "sparse, balanced")
            out.append(Rival("HPIPM", facets, forms, (True, False), _stages, mpc_hpipm.solver))
            out.append(Rival("qpOASES", facets, ("dense", "dense, MPC"), (True,), _for_casadi, _qpoases))
    out.append(driven("Clarabel", None, ("condensed", "sparse"), (False,), {}))
    return out


def _stages(m: Matrices, form: str) -> mpc_hpipm.Stages:
    """Return the stages that HPIPM wants, from the sparse form."""
    return mpc_hpipm.stages(m)


def _for_casadi(m: Matrices, form: str) -> tuple[Matrices, dict[str, Any]]:
    """Return the matrices as CasADi's, the normal bounds as bounds on the unknowns."""
    import casadi

    _, _, C, low, high, lower, upper = cone_program(m).two_sided(bounds=True)
    given = {"h": m.P, "g": m.q, "a": C, "lba": low, "uba": high, "lbx": lower, "ubx": upper}
    return m, {name: casadi.DM(np.array(value)) for name, value in given.items()}


@contextmanager
def _silence() -> Iterator[None]:
    """Keep what compiled code prints from the standard output."""
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        with redirect_stdout(io.StringIO()):  # CasADi prints through Python where it can
            yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nothing)


def _qpoases(variant: Variant) -> Callable[[tuple[Matrices, dict[str, Any]]], FloatArray]:
    """Return qpOASES's solve, by its own defaults or its preset for MPC; it starts at its last active set."""
    import casadi

    own: dict[str, Any] = {"printLevel": "none", "error_on_fail": False}
    own["terminationTolerance"] = variant.tol
    if "MPC" in variant.form:
        own |= dict.fromkeys(("enableRamping", "enableFlippingBounds", "enableNZCTests"), False)
        own |= {"enableDriftCorrection": 0, "enableEqualities": True}
    kept: dict[Any, Any] = {}

    def solve(item: tuple[Matrices, dict[str, Any]]) -> FloatArray:
        m, given = item
        if m.structure not in kept:
            pattern = {name: given[name].sparsity() for name in "ha"}
            with _silence():  # a new one prints its licence
                kept[m.structure] = casadi.conic("qp", "qpoases", pattern, own)
        return _forces(kept[m.structure](**given)["x"].full().ravel(), m)

    return solve


def cone_program(m: Matrices) -> ConeProgram:
    """Return the program for outside solvers; second-order cones where C holds no pyramids."""
    c, n = m.mu.size, m.q.size
    rows = stacked([m.C, -m.C])
    cones = None
    if m.low.size == c:
        at = np.arange(c)
        values = np.concatenate([-m.mu, -np.ones(2 * c)])
        where = np.concatenate([3 * at, 3 * at + 1, 3 * at + 2])
        which = np.concatenate([3 * at + 2, 3 * at, 3 * at + 1])
        cones = sp.csc_matrix((values, (where, which)), (3 * c, n)), np.zeros(3 * c)
    bounds = rows if isinstance(rows, np.ndarray) else rows.tocsr(), np.concatenate([m.high, -m.low])
    return ConeProgram.of(m.P, m.q, zero=(m.A, m.b), nonneg=bounds, second_order=cones)


def matrices(
    mpc: ConvexMpc, program: HorizonProgram, facets: int | None, *, sparse: bool, dense: bool
) -> Matrices:
    """Return a horizon's program as matrices, condensed or with states; condensed ones dense if wanted."""
    c = program.step.size
    scale = max(float(np.abs(program.centre).max(initial=0.0)), 1.0)
    H, g = program.condensed()
    unit = 1.0 / (scale * scale * float(np.mean(np.diag(H)))) if c else 1.0
    if sparse:
        P, q, A, b = _with_states(mpc, program, scale)
        structure: tuple[Any, ...] = (facets, tuple(program.step))
    else:
        P, q = scale * scale * H, scale * g
        A, b = np.zeros((0, 3 * c)), np.zeros(0)
        structure = (facets, c)
    C, low, high = _cone_rows(program, facets, scale, P.shape[0])
    if not dense:
        P = sp.csc_matrix(P) if sparse else _full_csc(P)
        A, C = sp.csc_matrix(A), sp.csc_matrix(C)
    else:
        P, A, C = np.asfortranarray(P), np.asfortranarray(A), np.asfortranarray(C.toarray())
    return Matrices(P * unit, q * unit, A, b, C, low, high, program.bounds[:, 0], scale, structure)


def _full_csc(H: FloatArray) -> Any:
    """Return a matrix as CSC that keeps its zeros, so that its pattern never changes."""
    n = H.shape[0]
    return sp.csc_matrix((H.T.ravel(), np.tile(np.arange(n), n), np.arange(0, n * n + 1, n)), shape=(n, n))


def _cone_rows(
    program: HorizonProgram, facets: int | None, scale: float, columns: int
) -> tuple[Any, FloatArray, FloatArray]:
    """Return C, low, high: the inner pyramids' sides and then the normal bound of every contact."""
    blocks, low, high = [], [], []
    for mu, least, most in program.bounds:
        rows = np.array([[0.0, 0.0, 1.0]])
        if facets is not None:
            rows = np.vstack([FrictionPyramid(float(mu), facets, "inner").halfspaces, rows])
        blocks.append(rows)
        low.append(np.append(np.full(rows.shape[0] - 1, -np.inf), least / scale))
        high.append(np.append(np.zeros(rows.shape[0] - 1), most / scale))
    C = sp.block_diag(blocks, format="csc") if blocks else sp.csc_matrix((0, 0))
    C = sp.hstack([C, sp.csc_matrix((C.shape[0], columns - C.shape[1]))], format="csc")
    return C, np.concatenate([*low, np.zeros(0)]), np.concatenate([*high, np.zeros(0)])


def _with_states(
    mpc: ConvexMpc, program: HorizonProgram, scale: float
) -> tuple[Any, FloatArray, Any, FloatArray]:
    """Return P, q, A, b in forces and errors x_1 ... x_N (six places, six rates each)."""
    c, N, dt = program.step.size, mpc.horizon, mpc.dt
    weights = mpc.weights.matrix().ravel()
    share = np.ones(N)
    share[-1] = mpc.weights.terminal
    P = sp.diags(np.concatenate([np.full(3 * c, program.rho * scale**2), np.outer(share, weights).ravel()]))
    q = np.concatenate([-program.rho * scale * program.centre.ravel(), np.zeros(12 * N)])
    step = np.block([[np.eye(6), dt * np.eye(6)], [np.zeros((6, 6)), np.eye(6)]])
    push = np.vstack([0.5 * dt * dt * np.eye(6), dt * np.eye(6)])
    blocks = -scale * np.einsum("ra,cxa->crx", push, program.M)  # every entry is kept, zero or not
    rows = 12 * program.step[:, None, None] + np.arange(12)[None, :, None] + np.zeros((1, 1, 3), np.int64)
    columns = 3 * np.arange(c)[:, None, None] + np.arange(3)[None, None, :] + np.zeros((1, 12, 1), np.int64)
    forces = sp.coo_matrix((blocks.ravel(), (rows.ravel(), columns.ravel())), (12 * N, 3 * c))
    states = sp.eye(12 * N) - sp.kron(sp.eye(N, k=-1), step)
    b = program.drift[1:].reshape(N, 12).copy()
    b[0] += step @ program.drift[0].ravel()
    return P, q, sp.hstack([forces.tocsc(), states], format="csc"), b.ravel()


def _forces(z: Any, m: Matrices) -> FloatArray:
    """Return the (c, 3) forces of a solution."""
    return m.scale * np.asarray(z, dtype=np.float64)[: 3 * m.mu.size].reshape(-1, 3)


def solve_exact(m: Matrices, tol: float) -> FloatArray:
    """Return the (c, 3) forces of a program by Clarabel."""
    return _forces(solve_program(cone_program(m), tol=tol).x, m)
