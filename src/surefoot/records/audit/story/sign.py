"""What speaks for a cause."""

from __future__ import annotations

from typing import NamedTuple


class Sign(NamedTuple):
    """When it begins [s], whose it is, the figures in words, and how strong it is beside its like.

    `since` is when that of which it is the end began [s], a foot's swing before its landing; None if it has
    none.
    """

    time: float
    where: str
    evidence: str
    strength: float
    since: float | None = None
