"""A contact without friction, one row: the normal force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from surefoot.contact.sets.contact import ContactKind


@dataclass(frozen=True)
class Frictionless(ContactKind):
    """A normal force λ_n >= 0, one row; Signorini's law 0 <= λ_n ⟂ u_n >= 0, under either contact law.

    References
    ----------
    .. [1] A. Signorini, "Sopra alcune questioni di elastostatica", 1933.

    Examples
    --------
    >>> float(Frictionless().project([-3.0])[0])
    0.0
    """

    rows: ClassVar[int] = 1
    normal: ClassVar[int] = 0
