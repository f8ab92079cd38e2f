"""Stacked rows for a QP over contact forces: friction and normal bounds, zero force for swing feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, whole_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.contact import Fit
from surefoot.mechanics.stance.contact import Contact

Axes = Literal["contact", "world"]
BOUNDS = 2
"""Rows of the bounds on a contact's normal force."""


@dataclass(frozen=True, eq=False)
class HalfSpaces:
    """A @ forces <= b for stance feet and E @ forces = e for swing feet, over the stacked forces.

    How many rows there are follows from the contacts, `facets` and `swing` alone, never from
    friction or bounds: a QP can be set up for them beforehand.

    Attributes
    ----------
    A, b
        (m, dim) and (m,): for each stance foot its pyramid's `facets` sides [N of tangential force], then
        -f_z <= -normal_min and f_z <= normal_max [N]; b is infinite where there is no upper bound. A patch
        has the 16 rows of its `WrenchCone` instead of the sides.
    E, e
        (p, dim) [-] and (p,) [N, N m]: zero force, three rows for each swing point and six for each patch.
    rows
        Where each contact's rows are, in the stance's order: in A for stance feet, in E for swing feet.
    swing
        Which contacts are swing feet.
    """

    A: FloatArray
    b: FloatArray
    E: FloatArray
    e: FloatArray
    rows: tuple[slice, ...]
    swing: tuple[bool, ...]

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
        >>> rows = Stance([PointContact([0, 0, 0], mu=0.6)]).halfspaces(facets=4)
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


def halfspaces(
    contacts: Sequence[Contact], facets: int, fit: Fit, axes: Axes, swing: Sequence[bool] | Sequence[str]
) -> HalfSpaces:
    """Return the rows of contacts; see `Stance.halfspaces`."""
    check_name("axes", axes, ["contact", "world"])
    whole_number("facets", facets, low=3)
    mask = swing_mask(contacts, swing)
    on = [c for c, off in zip(contacts, mask, strict=True) if not off]
    dim = sum(c.dim for c in contacts)
    m, p = sum(c.side_count(facets) + BOUNDS for c in on), dim - sum(c.dim for c in on)
    A, b, E = np.zeros((m, dim)), np.zeros(m), np.zeros((p, dim))
    rows: list[slice] = []
    at, low, low_off = 0, 0, 0
    for contact, off in zip(contacts, mask, strict=True):
        columns = slice(at, at + contact.dim)
        at += contact.dim
        if off:
            rows.append(slice(low_off, low_off + contact.dim))
            E[rows[-1], columns] = np.eye(contact.dim)  # zero force, in any axes
            low_off += contact.dim
            continue
        block, right = _rows_of(contact, facets, fit)
        if axes == "world":
            for part in range(0, contact.dim, 3):  # a row's product with R^T f_world
                columns3 = slice(part, part + 3)
                block[:, columns3] = block[:, columns3] @ contact.rotation_world_contact.T
        rows.append(slice(low, low + len(right)))
        A[rows[-1], columns], b[rows[-1]] = block, right
        low += len(right)
    return HalfSpaces(A, b, E, np.zeros(p), tuple(rows), mask)


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


def _rows_of(contact: Contact, facets: int, fit: Fit) -> tuple[FloatArray, FloatArray]:
    """Return one stance foot's rows in its own frame, and their right-hand side."""
    sides = contact.sides(facets, fit)
    bounds = np.zeros((BOUNDS, contact.dim))
    bounds[0, 2], bounds[1, 2] = -1.0, 1.0
    right = np.concatenate([np.zeros(len(sides)), [-contact.normal_min, contact.normal_max]])
    return np.vstack([sides, bounds]), right
