"""One conic program for all outside solvers: min ½ xᵀP x + qᵀx with A x + s = b, s in a product of cones."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError

Rows = tuple[Any, Any]
"""A matrix, dense or sparse, and a vector: `A`, `b` of ``b - A x``."""


class End(Enum):
    """How an outside solver says that it ended."""

    SOLVED = "solved"
    ALMOST = "almost"
    INFEASIBLE = "infeasible"
    ALMOST_INFEASIBLE = "almost_infeasible"
    UNBOUNDED = "unbounded"
    MAX_ITERATIONS = "max_iterations"
    MAX_TIME = "max_time"
    FAILED = "failed"


class Outcome(NamedTuple):
    """An outside solver's word.

    Attributes
    ----------
    x
        (n,) its last iterate; None if it gives none.
    end
        How it ended.
    iterations
        Of its own kind; 0 where it does not say.
    y
        (m,) multipliers of the rows in the program's order, in the dual cone, where it gives them.
    """

    x: FloatArray | None
    end: End
    iterations: int = 0
    y: FloatArray | None = None

    @property
    def found(self) -> bool:
        """Whether the solver calls x a solution, if with less accuracy than asked."""
        return self.x is not None and self.end in (End.SOLVED, End.ALMOST)

    def solution(self) -> FloatArray:
        """Return x (n,) if the solver calls it a solution.

        Raises
        ------
        ProblemError
            If it does not.
        """
        if self.x is None or not self.found:
            raise ProblemError(f"the solver ended {self.end.value}")
        return self.x


class TwoSided(NamedTuple):
    """The linear rows as QP solvers want them: E x = e, low <= C x <= high, lower <= x <= upper."""

    E: Any
    e: FloatArray
    C: Any
    low: FloatArray
    high: FloatArray
    lower: FloatArray
    upper: FloatArray


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """min ½ xᵀP x + qᵀx subject to A x + s = b, s in {0} × non-negative × second-order cones.

    Attributes
    ----------
    P, q
        (n, n) symmetric and positive semidefinite, both triangles; (n,).
    A, b
        (m, n) and (m,); the rows in the order of the cones. P and A are dense or sparse.
    zero, nonneg
        Numbers of rows with s = 0 and s >= 0.
    second_order
        Rows of each cone s_0 >= ||(s_1, ...)||.
    """

    P: Any
    q: FloatArray
    A: Any
    b: FloatArray
    zero: int = 0
    nonneg: int = 0
    second_order: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        rows = self.zero + self.nonneg + sum(self.second_order)
        n = np.size(self.q)
        for name, matrix, shape in (("P", self.P, (n, n)), ("A", self.A, (rows, n))):
            if matrix.shape != shape:
                raise ProblemError(f"{name} must have shape {shape} by q and the cones, got {matrix.shape}")
        if np.shape(self.b) != (rows,):
            raise ProblemError(f"b must have shape {(rows,)} by the cones, got {np.shape(self.b)}")

    @classmethod
    def of(
        cls, P: Any, q: Any, *, zero: Rows | None = None, nonneg: Rows | None = None,
        second_order: Rows | None = None, size: int = 3,
    ) -> ConeProgram:  # fmt: skip
        """Return the program from blocks of rows (A, b), in any of which b - A x lies in the cone.

        Parameters
        ----------
        P, q
            (n, n) and (n,); None for a P of zeros.
        zero, nonneg
            Rows with A x = b, and with A x <= b; those of the latter with an infinite b are left out.
        second_order
            Rows of all second-order cones, `size` for each.
        size
            Rows of a second-order cone.
        """
        q = np.asarray(q, dtype=np.float64)
        blocks: list[Rows] = []
        counts = [0, 0, 0]
        for kind, rows in enumerate((zero, nonneg, second_order)):
            if rows is None or rows[0].shape[0] == 0:
                continue
            matrix, right = rows[0], np.asarray(rows[1], dtype=np.float64)
            if kind == 1 and not np.isfinite(right).all():
                matrix, right = matrix[np.isfinite(right)], right[np.isfinite(right)]
            counts[kind] = len(right)
            blocks.append((matrix, right))
        P = sp.csc_matrix((q.size, q.size)) if P is None else P
        A = stacked([matrix for matrix, _ in blocks]) if blocks else np.zeros((0, q.size))
        b = np.concatenate([right for _, right in blocks]) if blocks else np.zeros(0)
        return cls(P, q, A, b, counts[0], counts[1], (size,) * (counts[2] // size))

    def two_sided(self, bounds: bool = False) -> TwoSided:
        """Return the rows as QP solvers want them; opposite ones become one row with two limits.

        Parameters
        ----------
        bounds
            Take rows with a single entry out, as bounds on x.

        Raises
        ------
        ProblemError
            If there are second-order cones.
        """
        if self.second_order:
            raise ProblemError("a QP solver takes linear rows only, no second-order cones")
        A = self.A if isinstance(self.A, np.ndarray) else sp.csr_matrix(self.A)
        rows, limits = A[self.zero :], self.b[self.zero :]
        keep, low = _pair_rows(sp.csr_matrix(rows), limits)
        C, high = rows[keep], limits[keep]
        lower, upper = np.full(self.q.size, -np.inf), np.full(self.q.size, np.inf)
        if bounds:
            C, low, high = _rows_to_bounds(C, low, high, lower, upper)
        return TwoSided(A[: self.zero], self.b[: self.zero], C, low, high, lower, upper)


def stacked(blocks: list[Any]) -> Any:
    """Return matrices on top of each other: dense if all are, else sparse by columns."""
    if all(isinstance(block, np.ndarray) for block in blocks):
        return np.vstack(blocks)
    return sp.vstack(blocks, format="csc")


def dense(matrix: Any) -> FloatArray:
    """Return a matrix (m, n), dense or sparse, as a dense array, row by row."""
    array = matrix if isinstance(matrix, np.ndarray) else matrix.toarray()
    return np.ascontiguousarray(array, dtype=np.float64)


def upper_triangle(P: Any) -> Any:
    """Return the upper triangle by columns; of a dense P every entry, so that its pattern never changes."""
    if not isinstance(P, np.ndarray):
        return sp.triu(P, format="csc")
    n = len(P)
    row, column = np.triu_indices(n)
    order = np.lexsort((row, column))
    pointers = np.concatenate([[0], np.cumsum(np.arange(1, n + 1))])
    return sp.csc_matrix((P[row[order], column[order]], row[order], pointers), P.shape)


def pattern(*matrices: Any) -> tuple[Any, ...]:
    """Return what is equal for matrices of the same shapes and places of entries."""
    return tuple(
        m.shape if isinstance(m, np.ndarray) else (m.shape, hash(m.indptr.tobytes() + m.indices.tobytes()))
        for m in matrices
    )


def _pair_rows(rows: Any, limits: FloatArray) -> tuple[list[int], FloatArray]:
    """Return the rows to keep and their lower limits, from those whose opposite comes later."""
    first: dict[tuple[bytes, bytes], int] = {}
    keep: list[int] = []
    low: list[float] = []
    for k, limit in enumerate(limits):
        part = slice(rows.indptr[k], rows.indptr[k + 1])
        where, values = rows.indices[part].tobytes(), rows.data[part]
        at = first.get((where, (0.0 - values).tobytes()))  # 0 - v: no negative zeros
        if at is not None and -limit <= limits[keep[at]] and low[at] == -np.inf:
            low[at] = -float(limit)  # limits that cross stay two rows, for solvers to say so
            continue
        first[where, (0.0 + values).tobytes()] = len(keep)
        keep.append(k)
        low.append(-np.inf)
    return keep, np.array(low)


def _rows_to_bounds(
    C: Any, low: FloatArray, high: FloatArray, lower: FloatArray, upper: FloatArray
) -> tuple[Any, FloatArray, FloatArray]:
    """Return the rows that are left when those with a single entry have become bounds, written in place."""
    rows = sp.csr_matrix(C)
    single = np.zeros(len(low), dtype=bool)
    for k in range(len(low)):
        part = slice(rows.indptr[k], rows.indptr[k + 1])
        entries = np.flatnonzero(rows.data[part])
        if entries.size != 1:
            continue
        column, value = rows.indices[part][entries[0]], rows.data[part][entries[0]]
        ends = sorted((low[k] / value, high[k] / value))
        ends = [max(lower[column], ends[0]), min(upper[column], ends[1])]
        if ends[0] <= ends[1]:
            single[k], lower[column], upper[column] = True, *ends
    return C[~single], low[~single], high[~single]
