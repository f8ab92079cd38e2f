"""An NLP of equal blocks in a row: its sparse derivatives from those of one block.

The variables are z = (x_0, u_0, x_1, u_1, ..., x_N); block k sees (x_k, u_k, x_{k+1}). CasADi would colour
the whole Jacobian and Hessian; here one block is differentiated once, evaluated N times, and its entries are
put in their places.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.planning.transcription.forms import import_casadi

Expression = Any


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


def build_nlp(block: Block, count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the NLP of `count` blocks as CasADi wants it, and the functions of its derivatives.

    The parameter of the NLP is the blocks' parameter followed by the data of each block.

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
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", m * count)
    seen = ca.reshape(x[places.T.ravel().tolist()], block.size, count)
    given = ca.repmat(p[:shared], 1, count), ca.reshape(p[shared:], own, count)
    functions = _functions(block)
    value = functions["value"].map(count)
    cost, rows = value(seen, *given)
    g = ca.reshape(rows, m * count, 1)
    f = ca.sum2(cost)
    # gradient: the blocks' own, added where they share variables
    slope = functions["slope"].map(count)(seen, *given)
    gather = ca.DM(
        ca.Sparsity.triplet(total, places.size, places.T.ravel().tolist(), list(range(places.size))), 1.0
    )
    grad = ca.mtimes(gather, ca.reshape(slope, places.size, 1))
    # Jacobian: every entry has one place
    pattern = functions["jacobian"].sparsity_out(0)
    row, column = (np.array(n) for n in pattern.get_triplet())
    at_row = (row[None, :] + m * np.arange(count)[:, None]).ravel()
    at_column = places[column].T.ravel()
    jac = _placed(ca, functions["jacobian"].map(count)(seen, *given), at_row, at_column, (m * count, total))
    # Hessian: entries of neighbours add up on the state that they share
    pattern = functions["hessian"].sparsity_out(0)
    row, column = (np.array(n) for n in pattern.get_triplet())
    weights = ca.repmat(lam_f, 1, count), ca.reshape(lam_g, m, count)
    curved = functions["hessian"].map(count)(seen, *given, *weights)
    hess = _placed(ca, curved, places[row].T.ravel(), places[column].T.ravel(), (total, total))
    names = ["x", "p"]
    options = {
        "grad_f": ca.Function("nlp_grad_f", [x, p], [f, grad], names, ["f", "grad:f:x"]),
        "jac_g": ca.Function("nlp_jac_g", [x, p], [g, jac], names, ["g", "jac:g:x"]),
        "hess_lag": ca.Function(
            "nlp_hess_l", [x, p, lam_f, lam_g], [hess], [*names, "lam:f", "lam:g"], ["triu:hess:gamma:x:x"]
        ),
    }
    return {"x": x, "p": p, "f": f, "g": g}, options


def _functions(block: Block) -> dict[str, Any]:
    """Return value, slope, Jacobian and upper Hessian of one block, as compiled expressions."""
    ca = import_casadi()
    z = ca.vertcat(block.x, block.u, block.after)
    given = [z, block.parameter, block.data]
    lam_f, lam_g = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", block.rows.shape[0])
    lagrangian = lam_f * block.cost + ca.dot(lam_g, block.rows)
    curved = ca.triu(ca.hessian(lagrangian, z)[0])
    return {
        "value": ca.Function("value", given, [block.cost, block.rows]),
        "slope": ca.Function("slope", given, [ca.densify(ca.gradient(block.cost, z))]),
        "jacobian": ca.Function("jacobian", given, [ca.jacobian(block.rows, z)]),
        "hessian": ca.Function("hessian", [*given, lam_f, lam_g], [curved]),
    }


def _placed(
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
