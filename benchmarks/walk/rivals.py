"""The MPC step through other solvers: QP solvers with pyramids, and Clarabel with exact cones.

Each rival is given the same program as ours, either condensed (the forces are the only unknowns) or sparse
(forces and states, with the model as equations), scaled to numbers near one, as matrices ready in its own
format: only its own update and solve are timed. One workspace per pattern of the matrices is kept from call
to call, with its warm start, wherever its interface allows it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from benchmarks.walk import hpipm as mpc_hpipm
from surefoot.arrays import FloatArray
from surefoot.cones import FrictionPyramid
from surefoot.control.mpc import ConvexMpc, HorizonProgram
from surefoot.errors import MissingExtra

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
    ready: Callable[[Matrices], Any] = field(repr=False)
    make: Callable[[Variant], Callable[[Any], FloatArray]] = field(repr=False)

    @property
    def name(self) -> str:
        """What a table says."""
        return f"{self.solver}, {'exact cones' if self.facets is None else f'{self.facets} facets'}"

    def pack(self, mpc: ConvexMpc, program: HorizonProgram, form: str) -> Any:
        """Return the program in this rival's format (not timed)."""
        sparse, dense = form.startswith("sparse"), form == "dense"
        return self.ready(matrices(mpc, program, self.facets, sparse=sparse, dense=dense))


def rivals() -> list[Rival]:
    """Return all rivals, fresh; HPIPM only where CasADi's wheel brings it.

    Raises
    ------
    MissingExtra
        If the packages of the extra `qp` are not installed.
    """
    out = []
    for facets in (4, 8):
        out += [
            Rival("OSQP", facets, ("condensed", "sparse"), (True, False), _osqp_ready, _osqp),
            Rival("ProxQP", facets, ("dense", "sparse"), (True, False), _as_is, _proxqp),
            Rival("PIQP", facets, ("dense", "sparse"), (False,), _as_is, _piqp),
            Rival("DAQP", facets, ("dense",), (True, False), _daqp_ready, _daqp),
        ]
        if mpc_hpipm.hpipm_installed():
            forms = ("sparse", "sparse, balanced")
            out.append(Rival("HPIPM", facets, forms, (True, False), mpc_hpipm.stages, mpc_hpipm.solver))
    out.append(Rival("Clarabel", None, ("condensed", "sparse"), (False,), clarabel_ready, _clarabel))
    return out


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


def _stack(m: Matrices) -> tuple[Any, FloatArray, FloatArray]:
    """Return equations and inequalities as one block of rows with bounds, sparse."""
    return (
        sp.vstack([m.A, m.C], format="csc"),
        np.concatenate([m.b, m.low]),
        np.concatenate([m.b, m.high]),
    )


def _need(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingExtra(name, "qp") from error


def _as_is(m: Matrices) -> Matrices:
    return m


def _osqp_ready(m: Matrices) -> tuple[Matrices, Any, Any, FloatArray, FloatArray]:
    return m, sp.triu(m.P, format="csc"), *_stack(m)


def _osqp(variant: Variant) -> Callable[[Any], FloatArray]:
    osqp = _need("osqp")
    kept: dict[Any, Any] = {}

    def solve(item: tuple[Matrices, Any, Any, FloatArray, FloatArray]) -> FloatArray:
        m, upper, rows, low, high = item
        solver = kept.get(m.structure)
        if solver is not None:
            solver.update(q=m.q, l=low, u=high, Px=upper.data, Ax=rows.data)
        else:
            solver = osqp.OSQP()
            solver.setup(  # on copies: its updates write into the matrices that it was set up with
                upper.copy(), m.q, rows.copy(), low, high, verbose=False, eps_abs=variant.tol,
                eps_rel=variant.tol, warm_starting=variant.warm, max_iter=20_000, polishing=False,
                check_termination=10,
            )  # fmt: skip
            kept[m.structure] = solver
        return _forces(solver.solve(raise_error=False).x, m)

    return solve


def _proxqp(variant: Variant) -> Callable[[Any], FloatArray]:
    proxqp = _need("proxsuite").proxqp
    kept: dict[Any, Any] = {}
    guess = proxqp.InitialGuess
    start = (
        guess.WARM_START_WITH_PREVIOUS_RESULT if variant.warm else guess.EQUALITY_CONSTRAINED_INITIAL_GUESS
    )

    def solve(m: Matrices) -> FloatArray:
        solver = kept.get(m.structure)
        if solver is not None:
            solver.update(H=m.P, g=m.q, A=m.A, b=m.b, C=m.C, l=m.low, u=m.high)
        else:
            module = proxqp.dense if variant.form == "dense" else proxqp.sparse
            solver = module.QP(m.q.size, m.b.size, m.low.size)
            solver.settings.eps_abs, solver.settings.eps_rel = variant.tol, 0.0
            solver.init(m.P, m.q, m.A, m.b, m.C, m.low, m.high)
            solver.settings.initial_guess = guess.EQUALITY_CONSTRAINED_INITIAL_GUESS  # nothing to go by
            kept[m.structure] = solver
        solver.solve()
        solver.settings.initial_guess = start
        return _forces(solver.results.x, m)

    return solve


def _piqp(variant: Variant) -> Callable[[Any], FloatArray]:
    piqp = _need("piqp")
    kept: dict[Any, Any] = {}

    def solve(m: Matrices) -> FloatArray:
        solver = kept.get(m.structure)
        if solver is not None:
            solver.update(m.P, m.q, m.A, m.b, m.C, m.low, m.high)
        else:
            solver = piqp.DenseSolver() if variant.form == "dense" else piqp.SparseSolver()
            solver.settings.eps_abs = solver.settings.eps_rel = variant.tol
            solver.settings.check_duality_gap = False
            solver.setup(m.P, m.q, m.A, m.b, m.C, m.low, m.high)
            kept[m.structure] = solver
        solver.solve()
        return _forces(solver.result.x, m)

    return solve


def _daqp_ready(m: Matrices) -> Matrices:
    return m._replace(P=np.ascontiguousarray(m.P), C=np.ascontiguousarray(m.C))


def _daqp(variant: Variant) -> Callable[[Any], FloatArray]:
    daqp = _need("daqp")
    kept: dict[Any, Any] = {}

    def solve(m: Matrices) -> FloatArray:
        solver = kept.get(m.structure) if variant.warm else None
        if solver is not None:
            solver.update(H=m.P, f=m.q, A=m.C, bupper=m.high, blower=m.low)
        else:
            solver = daqp.Model()
            solver.setup(m.P, m.q, m.C, m.high, m.low)
            solver.settings = {"primal_tol": variant.tol, "dual_tol": variant.tol}
            kept[m.structure] = solver
        return _forces(solver.solve()[0], m)

    return solve


def clarabel_ready(m: Matrices) -> tuple[Matrices, Any, Any, FloatArray, list[Any]]:
    """Return P, A, b and cones as Clarabel wants them; second-order cones where C holds no pyramids."""
    clarabel = _need("clarabel")
    c = m.mu.size
    above, below = np.isfinite(m.high), np.isfinite(m.low)
    rows = [m.A, m.C[above], -m.C[below]]
    right = [m.b, m.high[above], -m.low[below]]
    cones = [clarabel.ZeroConeT(m.b.size), clarabel.NonnegativeConeT(int(above.sum() + below.sum()))]
    if m.low.size == c:
        at = np.arange(c)
        values = np.concatenate([-m.mu, -np.ones(2 * c)])
        where = np.concatenate([3 * at, 3 * at + 1, 3 * at + 2])
        which = np.concatenate([3 * at + 2, 3 * at, 3 * at + 1])
        rows.append(sp.csc_matrix((values, (where, which)), (3 * c, m.q.size)))
        right.append(np.zeros(3 * c))
        cones += [clarabel.SecondOrderConeT(3)] * c
    return m, sp.triu(m.P, format="csc"), sp.vstack(rows, format="csc"), np.concatenate(right), cones


def _clarabel(variant: Variant) -> Callable[[Any], FloatArray]:
    clarabel = _need("clarabel")
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.presolve_enable = False  # it would forbid updates
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = variant.tol
    kept: dict[Any, Any] = {}

    def solve(item: tuple[Matrices, Any, Any, FloatArray, list[Any]]) -> FloatArray:
        m, P, A, b, cones = item
        solver = kept.get(m.structure)
        if solver is not None:
            solver.update(P=P.data, q=m.q, A=A.data, b=b)
        else:
            solver = clarabel.DefaultSolver(P, m.q, A, b, cones, options)
            kept[m.structure] = solver
        return _forces(solver.solve().x, m)

    return solve


def solve_exact(m: Matrices, tol: float) -> FloatArray:
    """Return the (c, 3) forces of a program by Clarabel, see `clarabel_ready`."""
    return _clarabel(Variant("condensed", False, tol))(clarabel_ready(m))
