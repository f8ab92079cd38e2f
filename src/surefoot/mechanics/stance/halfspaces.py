"""Stacked rows for a QP over contact forces: friction and normal bounds, zero force for swing feet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.contact import Fit
from surefoot.mechanics.stance.contact import Contact

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix

    from surefoot.mechanics.stance.row_pattern import Block, RowPattern

Axes = Literal["contact", "world"]


class HasContacts(Protocol):
    """What an update reads of a stance."""

    contacts: tuple[Contact, ...]


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpaces:
    """A @ forces <= b for stance feet and E @ forces = e for swing feet, over the stacked forces.

    All numbers are finite: a normal force without an upper bound has no row for it. How many rows there are
    follows from the contacts' shapes, `facets`, `fit`, `swing` and which contacts have an upper bound, never
    from friction or the bounds' values: a QP can be set up for them beforehand.

    Attributes
    ----------
    A, b
        (m, dim) and (m,): for each stance foot its pyramid's `facets` sides [N of tangential force], then
        -f_z <= -normal_min and, where there is an upper bound, f_z <= normal_max [N]. A sole has the rows of
        its corners' pyramids instead of the sides, see `Sole.polyhedral`.
    E, e
        (p, dim) [-] and (p,) [N, N m]: zero force, three rows for each swing point and six for each sole.
    rows
        Where each contact's rows are, in the stance's order: in A for stance feet, in E for swing feet.
    swing
        Which contacts are swing feet.
    pattern
        Where the entries of A are; what `update` and `sparse` go by.
    """

    A: FloatArray
    b: FloatArray
    E: FloatArray
    e: FloatArray
    rows: tuple[slice, ...]
    swing: tuple[bool, ...]
    pattern: RowPattern

    def __repr__(self) -> str:
        rows = f"{len(self.A)} inequalities, {len(self.E)} equations"
        return f"HalfSpaces({rows}, {self.A.shape[1]} unknowns, {len(self.rows)} contacts)"

    def violation(self, forces: ArrayLike) -> float:
        """Return by how much (dim,) forces [N, N m] break the worst row [N, N m]; <= 0 within all of them."""
        f = finite_array("forces", forces, (self.A.shape[1],))
        over, off = self.A @ f - self.b, np.abs(self.E @ f - self.e)
        return max(float(over.max(initial=-np.inf)), float(off.max(initial=-np.inf)))

    def write_into(
        self, A: FloatArray, b: FloatArray, row: int = 0, column: int = 0, part: Literal["A", "E"] = "A"
    ) -> int:
        """Write the rows into a QP's own matrix, and return how many they are.

        Parameters
        ----------
        A, b
            (rows, variables) and (rows,) of the QP, changed in place where the rows go.
        row, column
            Of the first row and of the first force, as the number of accelerations for variables (a, f).
        part
            "A" for the inequalities of stance feet, "E" for the zero forces of swing feet.

        Raises
        ------
        ProblemError
            If the rows do not fit there; nothing is written then.

        Examples
        --------
        >>> from surefoot import PointContact, Stance
        >>> rows = Stance([PointContact([0, 0, 0], mu=0.6, normal_max=300.0)]).halfspaces(facets=4)
        >>> A, b = np.zeros((10, 21)), np.zeros(10)  # for 18 accelerations and a force
        >>> rows.write_into(A, b, row=2, column=18)
        6
        """
        check_name("part", part, ["A", "E"])
        block, right = (self.A, self.b) if part == "A" else (self.E, self.e)
        count, wide = block.shape
        if b.shape != A.shape[:1] or not (
            0 <= row <= A.shape[0] - count and 0 <= column <= A.shape[1] - wide
        ):
            raise ProblemError(
                f"{count} rows of {wide} forces do not fit into A of shape {A.shape}, b of shape {b.shape} "
                f"at row {row}, column {column}"
            )
        A[row : row + count, column : column + wide] = block
        b[row : row + count] = right
        return int(count)

    def sparse(self) -> csc_matrix:
        """Return A (m, dim) in compressed columns, with the same places whatever frames and friction are."""
        return self.pattern.sparse(self.A)

    def update(self, A: FloatArray | csc_matrix, stance: HasContacts, row: int = 0, column: int = 0) -> None:
        """Rewrite the rows in a QP's own matrix, and `b`, for other frames, friction or bounds.

        Parameters
        ----------
        A
            Where the rows stand: a dense matrix (rows, variables) in C order, `self.A` included, or what
            `sparse` has returned.
        stance
            The same contacts: as many, of the same shapes, with an upper bound where there was one.
        row, column
            Of the first row and force in a dense matrix, as for `write_into`.

        Raises
        ------
        ProblemError
            If the stance has other contacts, or A is not such a matrix; nothing is written then.
        """
        self.pattern.update(A, stance.contacts, row, column)
        for contact, low, high in zip(stance.contacts, self.pattern.low, self.pattern.high, strict=True):
            if low >= 0:
                self.b[low] = -contact.normal_min
            if high >= 0:
                self.b[high] = contact.normal_max


@dataclass(frozen=True, eq=False, repr=False)
class TwoSidedRows:
    """lower <= A @ forces <= upper over the stacked forces, swing feet included.

    Attributes
    ----------
    A
        (m, dim): for each stance foot its sides and f_z, for each swing foot its forces.
    lower, upper
        (m,) [N, N m]: -inf and 0 for sides, normal_min and normal_max for f_z, 0 and 0 in swing. In this form
        an infinite bound is the solvers' own word for none (OSQP, PIQP, ProxQP, HiGHS).
    rows, swing, pattern
        As for `HalfSpaces`.
    """

    A: FloatArray
    lower: FloatArray
    upper: FloatArray
    rows: tuple[slice, ...]
    swing: tuple[bool, ...]
    pattern: RowPattern

    def __repr__(self) -> str:
        return f"TwoSidedRows({len(self.A)} rows, {self.A.shape[1]} unknowns, {len(self.rows)} contacts)"

    def sparse(self) -> csc_matrix:
        """Return A (m, dim) in compressed columns, with the same places whatever frames and friction are."""
        return self.pattern.sparse(self.A)

    def update(self, A: FloatArray | csc_matrix, stance: HasContacts, row: int = 0, column: int = 0) -> None:
        """Rewrite the rows in a QP's own matrix, and `lower` and `upper`; see `HalfSpaces.update`."""
        self.pattern.update(A, stance.contacts, row, column)
        for contact, low in zip(stance.contacts, self.pattern.low, strict=True):
            if low >= 0:
                self.lower[low], self.upper[low] = contact.normal_min, contact.normal_max


def halfspaces(
    contacts: Sequence[Contact], facets: int, fit: Fit, axes: Axes, swing: Sequence[bool] | Sequence[str]
) -> HalfSpaces:
    """Return the rows of contacts; see `Stance.halfspaces`."""
    from surefoot.mechanics.stance.row_pattern import RowPattern  # with the first rows that are asked for

    mask = _check_request(contacts, facets, axes, swing)
    blocks: list[Block] = []
    rows: list[slice] = []
    low, high, b = [], [], []
    dim = sum(c.dim for c in contacts)
    E = np.zeros((sum(c.dim for c, off in zip(contacts, mask, strict=True) if off), dim))
    at = down = column = 0
    for k, (contact, off) in enumerate(zip(contacts, mask, strict=True)):
        if off:
            own = slice(down, down + contact.dim)
            E[own, column : column + contact.dim] = np.eye(contact.dim)  # zero force, in any axes
            low.append(-1)
            high.append(-1)
        else:
            sides, scaled = contact.unit_sides(facets, fit)
            above = contact.normal_max < math.inf
            bounds = np.zeros((2 if above else 1, contact.dim))
            bounds[:, 2] = (-1.0, 1.0)[: len(bounds)]
            blocks.append((k, column, sides, scaled))
            blocks.append((k, column, bounds, np.zeros(len(bounds), dtype=np.bool_)))
            own = slice(at, at + len(sides) + len(bounds))
            low.append(at + len(sides))
            high.append(low[-1] + 1 if above else -1)
            b += [*[0.0] * len(sides), *(-contact.normal_min, contact.normal_max)[: len(bounds)]]
        rows.append(own)
        at, down = (at, own.stop) if off else (own.stop, down)
        column += contact.dim
    pattern = RowPattern.of(blocks, contacts, axes == "world", low, high)
    return HalfSpaces(
        pattern.matrix(contacts),
        np.array(b, dtype=np.float64),
        E,
        np.zeros(len(E)),
        tuple(rows),
        mask,
        pattern,
    )


def two_sided(
    contacts: Sequence[Contact], facets: int, fit: Fit, axes: Axes, swing: Sequence[bool] | Sequence[str]
) -> TwoSidedRows:
    """Return the rows of contacts with both bounds; see `Stance.two_sided`."""
    from surefoot.mechanics.stance.row_pattern import RowPattern  # with the first rows that are asked for

    mask = _check_request(contacts, facets, axes, swing)
    blocks: list[Block] = []
    rows: list[slice] = []
    low, lower, upper = [], [], []
    at = column = 0
    for k, (contact, off) in enumerate(zip(contacts, mask, strict=True)):
        if off:
            block, scaled = np.eye(contact.dim), np.zeros(contact.dim, dtype=np.bool_)
            lower += [0.0] * contact.dim
            upper += [0.0] * contact.dim
            low.append(-1)
        else:
            sides, flags = contact.unit_sides(facets, fit)
            block, scaled = np.vstack([sides, np.eye(contact.dim)[2]]), np.append(flags, False)
            lower += [*[-math.inf] * len(sides), contact.normal_min]
            upper += [*[0.0] * len(sides), contact.normal_max]
            low.append(at + len(sides))
        blocks.append((k, column, block, scaled))
        rows.append(slice(at, at + len(block)))
        at, column = at + len(block), column + contact.dim
    pattern = RowPattern.of(blocks, contacts, axes == "world", low, low)
    return TwoSidedRows(
        pattern.matrix(contacts), np.array(lower, dtype=np.float64), np.array(upper, dtype=np.float64),
        tuple(rows), mask, pattern,
    )  # fmt: skip


def _check_request(
    contacts: Sequence[Contact], facets: int, axes: Axes, swing: Sequence[bool] | Sequence[str]
) -> tuple[bool, ...]:
    """Check what rows are asked for, and return which contacts are swing feet."""
    check_name("axes", axes, ["contact", "world"])
    whole_number("facets", facets, low=3)
    return swing_mask(contacts, swing)


def swing_mask(contacts: Sequence[Contact], swing: Sequence[bool] | Sequence[str]) -> tuple[bool, ...]:
    """Return which contacts are swing feet, from their names or from one flag each.

    Raises
    ------
    ProblemError
        For a name that no contact has, or another number of flags than contacts.
    """
    given = list(swing)
    if given and all(isinstance(s, (bool, np.bool_)) for s in given):
        if len(given) != len(contacts):
            raise ProblemError(f"swing must have {len(contacts)} flags, one per contact, got {len(given)}")
        return tuple(bool(s) for s in given)
    names = [c.name for c in contacts]
    for name in given:
        check_name("contact", str(name), names)
    return tuple(name in given for name in names)
