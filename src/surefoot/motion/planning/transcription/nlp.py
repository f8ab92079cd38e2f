"""The one NLP of all transcriptions: equal blocks in a row, one per knot, solved by Ipopt.

The variables are z = (x_0, u_0, x_1, u_1, ..., x_N); block k sees (x_k, u_k, x_{k+1}). CasADi would colour
the whole Jacobian and Hessian; here one block is differentiated once, evaluated N times, and its entries are
put in their places.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.libraries import import_casadi
from surefoot.motion.planning.symbolic.tape import Tape, tapes_of

Expression = Any
Sides = tuple[FloatArray, FloatArray]
"""Least and largest values."""
OnIteration = Callable[[int, float, float], None]
"""Who hears of the number of an iteration, its cost and its violation."""
PARTS = ("rows", "slope", "jacobian", "hessian")
"""Rows of a block, cost and its gradient, rows and their Jacobian, upper half of the Lagrangian's Hessian."""
QUIET: dict[str, Any] = {
    "print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", "show_eval_warnings": False,
    "no_nlp_grad": True, "calc_lam_p": False,
}  # fmt: skip


@dataclass(frozen=True)
class Block:
    """One knot in symbols.

    Attributes
    ----------
    x, u, after
        (nx, 1), (nu, 1), (nx, 1) SX symbols.
    parameter
        (np, 1) SX symbol, the same for all blocks.
    rows
        (m, 1) SX.
    cost
        SX scalar.
    data
        (nd, 1) SX symbol of numbers that differ from block to block.
    """

    x: Expression
    u: Expression
    after: Expression
    parameter: Expression
    rows: Expression
    cost: Expression
    data: Expression

    @property
    def stride(self) -> int:
        """Variables from one block to the next."""
        return int(self.x.shape[0] + self.u.shape[0])

    @property
    def size(self) -> int:
        """Variables that a block sees."""
        return self.stride + int(self.x.shape[0])


def pack(states: FloatArray, inputs: FloatArray) -> FloatArray:
    """Return the variables (V,) of states (N + 1, nx) and inputs (N, nu) in the order of the blocks."""
    return np.concatenate([np.hstack([states[:-1], inputs]).ravel(), states[-1]])


def unpack(variables: FloatArray, nx: int, knots: int) -> tuple[FloatArray, FloatArray]:
    """Return the states (knots + 1, nx) and inputs (knots, nu) of variables (V,)."""
    table = variables[:-nx].reshape(knots, -1)
    return np.vstack([table[:, :nx], variables[-nx:]]), table[:, nx:]


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point of the search, and how Ipopt came to it.

    Attributes
    ----------
    variables, multipliers
        (V,) of the NLP, and those of bounds and rows.
    cost, violation
        Objective, and the largest violation of a row or bound, in its own scale.
    iterations
        Ipopt's.
    ending
        Ipopt's return status, or "interrupted".
    steps, regularised
        Of its iterations, how far each went along its direction, 1 a full step; and how many needed a
        Hessian made convex by a multiple of the identity.
    """

    variables: FloatArray
    multipliers: tuple[FloatArray, FloatArray]
    cost: float
    violation: float
    iterations: int
    ending: str
    steps: tuple[float, ...] = ()
    regularised: int = 0

    @property
    def finite(self) -> bool:
        """Whether all variables are numbers."""
        return bool(np.isfinite(self.variables).all())


class Nlp:
    """Blocks in a row, ready to be solved again and again.

    Parameters
    ----------
    block
        Of every knot.
    count
        Number of knots.
    kept
        Numbers of the rows that are asked for, of all knots one after the other; None for all.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """

    def __init__(self, block: Block, count: int, kept: IntArray | None = None) -> None:
        self.block, self.count, self.kept = block, count, kept
        self.problem, self.derivatives = build_nlp(block, count, kept)

    def solve(
        self,
        start: FloatArray,
        data: FloatArray,
        variables: Sides,
        rows: Sides,
        parameter: FloatArray | tuple[float, ...] = (),
        multipliers: tuple[FloatArray, FloatArray] | None = None,
        tell: OnIteration | None = None,
        **options: Any,
    ) -> Iterate:
        """Return what Ipopt makes of a start.

        Parameters
        ----------
        start, multipliers
            (V,) variables, and of a warm start those of bounds and rows.
        data
            (knots, nd) numbers of every knot.
        variables, rows
            Least and largest values of the variables (V,) and of the rows (knots, m).
        parameter
            The blocks' own, the same for all.
        tell
            Hears of every iteration; a KeyboardInterrupt that it raises ends the search.
        options
            Ipopt's, without their prefix.
        """
        ca = import_casadi()
        (low, high), sides = variables, (rows[0].ravel(), rows[1].ravel())
        if self.kept is not None:
            sides = sides[0][self.kept], sides[1][self.kept]
        given = {**QUIET, **{f"ipopt.{k}": v for k, v in options.items()}, **self.derivatives}
        watch = None if tell is None else _Watch(tell, *sides)
        if watch is not None:
            given["iteration_callback"] = listener = _callback(self.problem, watch)
        solver = ca.nlpsol("blocks", "ipopt", self.problem, given)
        call = {
            "x0": np.clip(start, low, high), "p": np.concatenate([parameter, data.ravel()]),
            "lbx": low, "ubx": high, "lbg": sides[0], "ubg": sides[1],
        }  # fmt: skip
        if multipliers is not None:
            call["lam_x0"], call["lam_g0"] = multipliers
        out, said = solver(**call), solver.stats()
        if watch is not None:
            del listener  # it must live until the solver has returned
        x, g = np.array(out["x"]).ravel(), np.array(out["g"]).ravel()
        beyond = [low - x, x - high, sides[0] - g, g - sides[1]]
        violation = float(max(np.max(b, initial=0.0) for b in beyond))
        back = np.array(out["lam_x"]).ravel(), np.array(out["lam_g"]).ravel()
        stopped = watch is not None and watch.interrupted
        stopped |= said["return_status"] == "NonIpopt_Exception_Thrown"  # CasADi saw Ctrl-C before the watch
        ended = "interrupted" if stopped else str(said["return_status"])
        record = said.get("iterations") or {}
        return Iterate(
            x, back, float(out["f"]), violation, int(said["iter_count"]), ended,
            tuple(record.get("alpha_pr", ())[1:]),  # its first row is the start
            sum(size > 0.0 for size in record.get("regularization_size", ())),
        )  # fmt: skip


def build_nlp(
    block: Block, count: int, kept: IntArray | None = None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the NLP of `count` blocks as CasADi wants it, and the functions of its derivatives.

    The parameter of the NLP is the blocks' parameter followed by the data of each block; `kept` as for `Nlp`.

    Returns
    -------
    tuple
        For `casadi.nlpsol`: the problem (x, p, f, g), and options grad_f, jac_g, hess_lag.
    """
    ca = import_casadi()
    shared, own = int(block.parameter.shape[0]), int(block.data.shape[0])
    total, m = block.stride * count + int(block.x.shape[0]), int(block.rows.shape[0])
    places = np.arange(block.size)[:, None] + block.stride * np.arange(count)[None, :]
    x, p = ca.MX.sym("x", total), ca.MX.sym("p", shared + own * count)
    asked = list(range(m * count)) if kept is None else kept.tolist()
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", len(asked))
    seen = ca.reshape(x[places.T.ravel().tolist()], block.size, count)
    given = ca.repmat(p[:shared], 1, count), ca.reshape(p[shared:], own, count)
    functions = tapes_of(*_functions(block))
    maps = {name: f.map_over(count) if isinstance(f, Tape) else f.map(count) for name, f in functions.items()}
    g = ca.reshape(maps["rows"](seen, *given), m * count, 1)[asked]
    # gradient: the blocks' own, added where they share variables
    cost, slope = maps["slope"](seen, *given)
    f = ca.sum2(cost)
    # A state is seen by the blocks on both sides: its entries of the gradient are summed by a matrix of ones.
    gather = ca.DM(
        ca.Sparsity.triplet(total, places.size, places.T.ravel().tolist(), list(range(places.size))), 1.0
    )
    grad = ca.mtimes(gather, ca.reshape(slope, places.size, 1))
    # Jacobian: every entry has one place
    pattern = functions["jacobian"].sparsity_out(1)
    row, column = (np.array(n) for n in pattern.get_triplet())
    at_row = (row[None, :] + m * np.arange(count)[:, None]).ravel()
    at_column = places[column].T.ravel()
    rows, slopes = maps["jacobian"](seen, *given)
    jac = _assemble_blocks(ca, slopes, at_row, at_column, (m * count, total))[asked, :]
    # Hessian: entries of neighbours add up on the state that they share
    pattern = functions["hessian"].sparsity_out(0)
    row, column = (np.array(n) for n in pattern.get_triplet())
    spread = ca.DM(ca.Sparsity.triplet(m * count, len(asked), asked, list(range(len(asked)))), 1.0)
    weights = ca.repmat(lam_f, 1, count), ca.reshape(ca.mtimes(spread, lam_g), m, count)
    curved = maps["hessian"](seen, *given, *weights)
    hess = _assemble_blocks(ca, curved, places[row].T.ravel(), places[column].T.ravel(), (total, total))
    names = ["x", "p"]
    options = {
        "grad_f": ca.Function("nlp_grad_f", [x, p], [f, grad], names, ["f", "grad:f:x"]),
        "jac_g": ca.Function(
            "nlp_jac_g", [x, p], [ca.reshape(rows, m * count, 1)[asked], jac], names, ["g", "jac:g:x"]
        ),
        "hess_lag": ca.Function(
            "nlp_hess_l", [x, p, lam_f, lam_g], [hess], [*names, "lam:f", "lam:g"], ["triu:hess:gamma:x:x"]
        ),
    }
    options["grad_f"].kept = maps  # CasADi does not: they must live as long as what calls them
    return {"x": x, "p": p, "f": f, "g": g}, options


def _functions(block: Block) -> tuple[Any, tuple[str, ...], Callable[[], dict[str, Any]]]:
    """Return cost and rows of one block as a function, and names and writer of its `PARTS`."""
    ca = import_casadi()
    z = ca.vertcat(block.x, block.u, block.after)
    given = [z, block.parameter, block.data]
    cost, rows = block.cost, block.rows

    def write() -> dict[str, Any]:
        lam_f, lam_g = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", rows.shape[0])
        # Ipopt takes the upper half alone.
        curved = ca.triu(ca.hessian(lam_f * cost + ca.dot(lam_g, rows), z)[0])
        return {
            "rows": ca.Function("rows", given, [rows]),
            "slope": ca.Function("slope", given, [cost, ca.densify(ca.gradient(cost, z))]),
            "jacobian": ca.Function("jacobian", given, [rows, ca.jacobian(rows, z)]),
            "hessian": ca.Function("hessian", [*given, lam_f, lam_g], [curved]),
        }

    return ca.Function("value", given, [cost, rows]), PARTS, write


def _assemble_blocks(
    ca: Any, blocks: Expression, row: IntArray, column: IntArray, shape: tuple[int, int]
) -> Expression:
    """Return the sparse matrix of blocks' nonzeros at (row, column), those of one place added."""
    code = column.astype(np.int64) * shape[0] + row  # column by column, as CasADi stores them
    unique, where = np.unique(code, return_inverse=True)
    rows, columns = unique % shape[0], unique // shape[0]
    pattern = ca.Sparsity.triplet(*shape, rows.tolist(), columns.tolist())
    entries = blocks.nz[:]
    add = ca.DM(ca.Sparsity.triplet(len(unique), len(code), where.tolist(), list(range(len(code)))), 1.0)
    return ca.MX(pattern, ca.mtimes(add, entries))


class _Watch:
    """Hears of every iteration, and ends the search after Ctrl-C.

    Attributes
    ----------
    interrupted
        Whether someone stopped it.
    """

    def __init__(self, tell: OnIteration, low: FloatArray, high: FloatArray) -> None:
        self._tell, self._low, self._high = tell, low, high
        self.count, self.interrupted = 0, False

    def heard(self, g: Any, cost: float) -> bool:
        """Return whether to go on."""
        try:
            self.count += 1
            rows = np.array(g).ravel()
            beyond = np.maximum(self._low - rows, rows - self._high)
            self._tell(self.count, cost, float(beyond.max(initial=0.0)))
        except KeyboardInterrupt:
            self.interrupted = True
        return not self.interrupted


def _callback(nlp: dict[str, Any], watch: _Watch) -> Any:
    """Return what CasADi calls at every iteration."""
    ca = import_casadi()
    variables, rows, parameters = (int(nlp[name].shape[0]) for name in ("x", "g", "p"))
    lengths = {
        "x": variables, "lam_x": variables, "g": rows, "lam_g": rows, "p": 0, "lam_p": parameters, "f": 1,
    }  # fmt: skip

    class Callback(ca.Callback):  # type: ignore[misc, name-defined]
        """Passes iterations on; CasADi asks for its sizes by these names."""

        def __init__(self) -> None:
            ca.Callback.__init__(self)
            self.construct("watch", {})

        def get_n_in(self) -> int:
            """Return the number of Ipopt's outputs."""
            return int(ca.nlpsol_n_out())

        def get_n_out(self) -> int:
            """Return 1: whether to stop."""
            return 1

        def get_sparsity_in(self, i: int) -> Any:
            """Return the shape of an output."""
            return ca.Sparsity.dense(lengths.get(ca.nlpsol_out(i), 0), 1)

        def eval(self, arguments: Any) -> list[float]:
            """Return 0 to go on, 1 to stop."""
            seen = {ca.nlpsol_out(i): argument for i, argument in enumerate(arguments)}
            return [0.0 if watch.heard(seen["g"], float(seen["f"])) else 1.0]

    return Callback()
