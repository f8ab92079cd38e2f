"""Contact laws as values: rigid ones here, one line in `LAWS` each; soft ones in `soft/`."""

from __future__ import annotations

from surefoot.base.errors import ProblemError, unknown_name
from surefoot.contact.laws.law import CONVEX, COULOMB, Law

LAWS: dict[str, Law] = {law: law for law in (COULOMB, CONVEX)}
"""The laws that have a name; any other `Law` can be given as the value that it is."""


def law_of(value: str) -> Law:
    """Return a law given as a value or by its name.

    Raises
    ------
    ProblemError
        If it is the name of none, or another law under a name that is taken.
    """
    known = LAWS.get(value) if isinstance(value, str) else None
    if known is not None:
        if getattr(value, "shift", known.shift) != known.shift:
            raise ProblemError(f"{value!r} is the name of another law; name yours differently")
        return known
    if isinstance(value, Law):
        return value
    raise ProblemError(unknown_name("law", value, LAWS))


__all__ = ["CONVEX", "COULOMB", "LAWS", "Law", "law_of"]
