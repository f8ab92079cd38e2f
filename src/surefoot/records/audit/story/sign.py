"""What speaks for a cause."""

from __future__ import annotations

from typing import NamedTuple


class Sign(NamedTuple):
    """When it begins [s], whose it is, the figures in words, and how strong it is beside its like."""

    time: float
    where: str
    evidence: str
    strength: float
