"""Rows of a stance's contacts in their own frames, and where their entries stand in a matrix.

They follow from the contacts' shapes and bounds alone. Friction scales some columns and frames turn the rows,
which is all that an update has to do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics.stance.contact import Contact

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

Block = tuple[int, int, FloatArray, BoolArray]
"""A contact, the column of its first force, its rows (m, 3 or 6) with friction one, and which it scales."""


@dataclass(frozen=True, eq=False)
class RowPattern:
    """Rows (m, 6) with friction one, in contact frames, of contacts with three or six forces.

    Attributes
    ----------
    rows
        (m, 6) entries [-, m]; the last three are zero for points.
    scaled
        (m,) whether entries 2, 3, 4 are multiplied with the contact's friction coefficient.
    foot, column, wide
        (m,) contact of each row, column of its first force, and number of its forces.
    shape
        Rows and stacked forces.
    turned
        Whether forces are in world axes.
    contacts
        Of the stance: shape (corners of a sole, None for a point) and whether its normal force has an upper
        bound.
    low, high
        (n,) rows of the contacts' normal bounds, -1 for none.
    """

    rows: FloatArray
    scaled: BoolArray
    foot: IntArray
    column: IntArray
    wide: IntArray
    shape: tuple[int, int]
    turned: bool
    contacts: tuple[tuple[FloatArray | None, bool], ...]
    low: tuple[int, ...]
    high: tuple[int, ...]
    _places: dict[Any, IntArray] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        blocks: Sequence[Block],
        contacts: Sequence[Contact],
        turned: bool,
        low: list[int],
        high: list[int],
    ) -> RowPattern:
        """Return the pattern of blocks of rows one below the other."""
        count = sum(len(rows) for _, _, rows, _ in blocks)
        every, scaled = np.zeros((count, 6)), np.zeros(count, dtype=np.bool_)
        where = np.zeros((3, count), dtype=np.int64)
        at = 0
        for foot, column, rows, flags in blocks:
            own = slice(at, at + len(rows))
            every[own, : rows.shape[1]], scaled[own] = rows, flags
            where[:, own] = np.array([foot, column, rows.shape[1]])[:, None]
            at += len(rows)
        shape = count, sum(c.dim for c in contacts)
        kinds = tuple((_shape_of(c), math.isfinite(c.normal_max)) for c in contacts)
        return cls(every, scaled, where[0], where[1], where[2], shape, turned, kinds, tuple(low), tuple(high))

    def matrix(self, contacts: Sequence[Contact]) -> FloatArray:
        """Return the dense rows (m, dim) of contacts."""
        out = np.zeros(self.shape)
        if not len(self.rows):
            return out
        mu = np.array([c.mu for c in contacts])[self.foot]
        local = self.rows.copy()
        local[:, 2:5] *= np.where(self.scaled, mu, 1.0)[:, None]
        if self.turned:
            R = np.array([c.rotation_world_contact for c in contacts])[self.foot]
            local = (R[:, None] @ local.reshape(-1, 2, 3, 1)).reshape(-1, 6)
        mask = np.arange(6) < self.wide[:, None]
        out.ravel()[self._dense(0, 0, self.shape[1])[mask]] = local[mask]
        return out

    def sparse(self, A: FloatArray) -> csc_matrix:
        """Return dense rows A (m, dim) in compressed columns, with a place for every entry of the pattern."""
        from scipy.sparse import csc_matrix

        mask = np.arange(6) < self.wide[:, None]
        lines = np.broadcast_to(np.arange(len(self.rows))[:, None], mask.shape)[mask]
        columns = (self.column[:, None] + np.arange(6))[mask]
        return csc_matrix((A[lines, columns], (lines, columns)), A.shape)

    def update(self, A: Any, contacts: Sequence[Contact], row: int, column: int) -> None:
        """Write the contacts' rows into A; see `HalfSpaces.update`."""
        from surefoot.mechanics.stance.row_kernels import write_rows

        self._check(contacts)
        places, out = self._target(A, row, column)
        mu = np.array([c.mu for c in contacts])
        rotations = np.array([c.rotation_world_contact for c in contacts]).reshape(-1, 3, 3)
        write_rows(self.rows, self.scaled, self.foot, self.wide, places, mu, rotations, self.turned, out)

    def _check(self, contacts: Sequence[Contact]) -> None:
        """Refuse contacts of other shapes, or with other bounds that there are."""
        if len(contacts) != len(self.contacts):
            raise ProblemError(
                f"the rows are of {len(self.contacts)} contacts, the stance has {len(contacts)}"
            )
        for k, (contact, (shape, bounded)) in enumerate(zip(contacts, self.contacts, strict=True)):
            own = _shape_of(contact)
            same = own is shape or (own is not None and shape is not None and np.array_equal(own, shape))
            if not same:
                raise ProblemError(f"contacts[{k}] has another shape than the one that the rows are of")
            if bounded != (contact.normal_max < math.inf):
                said = "has no" if bounded else "has an"
                raise ProblemError(
                    f"contacts[{k}] now {said} upper bound, which takes another number of rows"
                )

    def _target(self, A: Any, row: int, column: int) -> tuple[IntArray, FloatArray]:
        """Return the places (m, 6) in the flat entries of a matrix, and those entries."""
        if not isinstance(A, np.ndarray):
            return self._sparse_places(A), A.data
        key = (A.shape, row, column)
        places = self._places.get(key)
        if places is None:
            count, wide = self.shape
            if not (A.ndim == 2 and 0 <= row <= A.shape[0] - count and 0 <= column <= A.shape[1] - wide):
                raise ProblemError(
                    f"{count} rows of {wide} forces do not fit into A of shape {A.shape} at row {row}, "
                    f"column {column}"
                )
            places = self._places[key] = self._dense(row, column, A.shape[1])
        if A.dtype != np.float64 or not A.flags.c_contiguous:
            raise ProblemError(f"A must be of floats in C order, got {A.dtype} with strides {A.strides}")
        return places, A.reshape(-1)

    def _dense(self, row: int, column: int, columns: int) -> IntArray:
        """Return the flat places (m, 6) of the entries in a dense matrix of so many columns."""
        lines = (row + np.arange(len(self.rows), dtype=np.int64))[:, None] * columns
        return np.asarray(lines + (column + self.column)[:, None] + np.arange(6))

    def _sparse_places(self, A: Any) -> IntArray:
        """Return the places (m, 6) of the entries in the data of `sparse`."""
        entries = int(self.wide.sum())
        if getattr(A, "format", "") != "csc" or A.shape != self.shape or A.nnz != entries:
            raise ProblemError(f"A must be dense, or the matrix of {self.shape} that `sparse()` returned")
        places = self._places.get("sparse")
        if places is None:
            mask = np.arange(6) < self.wide[:, None]
            order = (self.column[:, None] + np.arange(6)) * self.shape[0] + np.arange(len(self.rows))[:, None]
            ranks = np.empty(entries, dtype=np.int64)
            ranks[np.argsort(order[mask])] = np.arange(entries)
            places = np.zeros(mask.shape, dtype=np.int64)
            places[mask] = ranks
            self._places["sparse"] = places
        return places


def _shape_of(contact: Contact) -> FloatArray | None:
    """Return a sole's corners (k, 2) [m], None for a point."""
    sole = getattr(contact, "sole", None)
    return None if sole is None else sole.corners
