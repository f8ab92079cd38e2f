"""What speaks for a cause."""

from __future__ import annotations

from typing import NamedTuple


class Sign(NamedTuple):
    """When it begins [s], whose it is, the figures in words, and how strong it is beside its like.

    `since` is when that of which it is the end began [s], a foot's swing before its landing; None if it has
    none. `shown` is when that which takes a while has shown itself [s], a stance that is too long; None for
    when it begins.
    """

    time: float
    where: str
    evidence: str
    strength: float
    since: float | None = None
    shown: float | None = None
