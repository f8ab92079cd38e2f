"""A joint: a contact that carries any force and allows no velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.contact.sets.contact import ContactKind


@dataclass(frozen=True)
class Bilateral(ContactKind):
    """Any force in so many rows, no velocity; the same under every law, since nothing slides.

    Parameters
    ----------
    rows
        Number of rows, 1 to 6.

    Examples
    --------
    >>> Bilateral(rows=2).project([1.0, -2.0]).tolist()
    [1.0, -2.0]
    """

    rows: int = 3  # type: ignore[misc]
    bilateral = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "rows", whole_number("rows", self.rows, low=1))
        if self.rows > 6:
            raise ProblemError(f"rows must be at most 6, got {self.rows}")
        if self.normal_min != 0.0 or self.normal_max != math.inf:
            raise ProblemError("a bilateral contact takes no normal bounds")

    @property
    def normal(self) -> int:  # type: ignore[override]
        """The third row, or the last."""
        return min(self.rows, 3) - 1

    @property
    def short_form(self) -> tuple[int | None, str] | None:
        """Three rows are among those of a plain problem."""
        return (None, "inner") if self.rows == 3 else None

    def nearest(self, y: FloatArray, low: float, high: float) -> FloatArray:
        """Return the point (rows,) itself, in any unit."""
        return np.array(y, dtype=np.float64)

    def support(self, direction: FloatArray) -> float:
        """Return 0 for a direction (rows,) of zeros, infinity for any other, in any unit."""
        return math.inf if np.any(direction) else 0.0
