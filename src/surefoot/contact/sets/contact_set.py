"""The contacts of a problem, each with its kind, its rows and its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError, shown
from surefoot.contact.sets.bilateral import Bilateral
from surefoot.contact.sets.contact import ContactKind
from surefoot.contact.sets.kinds import Point
from surefoot.contact.sets.pyramid import Pyramid


class ContactSet(Sequence[ContactKind]):
    """What touches, in the order of the rows of G and g.

    Parameters
    ----------
    contacts
        Values of `sf.contact_sets`, of any kinds together.

    Attributes
    ----------
    rows
        Their rows m in all.
    offsets
        (n + 1,); the rows of contact k are offsets[k] to offsets[k + 1].
    shape
        Of the forces: (n, d) where all contacts have d rows, else (m,).

    Raises
    ------
    ProblemError
        If something else than a contact is among them.

    Examples
    --------
    >>> import surefoot as sf
    >>> kinds = sf.contact_sets
    >>> contacts = ContactSet([kinds.Point(mu=0.5), kinds.SoftFinger(mu=0.5, radius=0.02)])
    >>> contacts.rows, contacts.shape, contacts.offsets.tolist()
    (7, (7,), [0, 3, 7])
    """

    def __init__(self, contacts: Sequence[ContactKind]) -> None:
        try:
            self._contacts = tuple(contacts)
        except TypeError as error:
            wanted = "contacts must be a list of sf.contact_sets, as [sf.contact_sets.Point(mu=0.5)] is one"
            raise ProblemError(f"{wanted}, got {shown(contacts)}") from error
        for k, contact in enumerate(self._contacts):
            if not isinstance(contact, ContactKind):
                raise ProblemError(f"contacts[{k}] must be one of sf.contact_sets, got {shown(contact)}")
        counts = [contact.rows for contact in self._contacts]
        self.offsets: IntArray = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64)
        self.rows = int(self.offsets[-1])
        same = len(set(counts)) == 1
        self.shape: tuple[int, ...] = (len(counts), counts[0]) if same else (self.rows,)

    def __len__(self) -> int:
        return len(self._contacts)

    def __getitem__(self, index: Any) -> Any:
        return self._contacts[index]

    def __iter__(self) -> Iterator[ContactKind]:
        return iter(self._contacts)

    def __repr__(self) -> str:
        return f"ContactSet({list(self._contacts)!r})"

    @cached_property
    def normal_rows(self) -> IntArray:
        """The (n,) rows of the normal forces."""
        return self.offsets[:-1] + np.array([c.normal for c in self], dtype=np.int64)

    @cached_property
    def lengths(self) -> FloatArray:
        """The (m,) lengths that moments are counted over, 1 for forces [m]."""
        return np.concatenate([np.zeros(0), *(c.lengths for c in self)])

    def split(self, vector: FloatArray) -> tuple[FloatArray, ...]:
        """Return what each contact has of the rows (m,) of a problem, in any unit: n views (d_k,)."""
        return tuple(np.split(np.ravel(vector), self.offsets[1:-1]))

    def nearest_to_zero(self) -> FloatArray:
        """Return the admissible forces nearest to zero [N or N s], in their shape: (n, 3), (n, d) or (m,)."""
        forces = np.zeros(self.rows)
        forces[self.normal_rows] = [c.normal_min for c in self]
        return forces.reshape(self.shape)

    def short_form(self) -> dict[str, Any] | None:
        """Return the arguments with which `ContactProblem(G, g, ...)` says the same, None if it cannot."""
        forms = {c.short_form for c in self if not c.bilateral or c.short_form is None}
        if len(forms) > 1 or None in forms:
            return None
        facets, fit = next((f for f in forms if f is not None), (None, "inner"))
        held = np.array([c.bilateral for c in self], dtype=bool)
        return {
            "mu": np.array([c.coefficient for c in self]),
            "normal_min": np.array([c.normal_min for c in self]),
            "normal_max": np.array([c.normal_max for c in self]),
            "facets": facets,
            "fit": fit,
            "bilateral": held if held.any() else None,
        }


def set_of(mu: FloatArray, low: FloatArray, high: FloatArray, facets: int | None, fit: str) -> ContactSet:
    """Return the contacts of a problem's short form, (n,) mu and bounds; low = -inf marks a bilateral one."""
    out: list[ContactKind] = []
    for m, a, b in zip(mu.tolist(), low.tolist(), high.tolist(), strict=True):
        if a == -np.inf:
            out.append(Bilateral())
        elif facets is None:
            out.append(Point(m, normal_min=a, normal_max=b))
        else:
            out.append(Pyramid(m, facets, fit, normal_min=a, normal_max=b))
    return ContactSet(out)
