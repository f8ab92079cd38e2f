"""Anderson's mixing: the next point of a fixed point's iteration from the last few, not from one alone.

Of the combinations of the last points whose weights add up to one, the one whose change by the map is least
(were the map linear) is taken, and mapped: what GMRES is to a linear map, from the same products.

Source: H. Walker, P. Ni, "Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49(4),
2011.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray

RIDGE = 1e-10
"""Added to the squares of differences between changes, in parts of each, so that equal ones do no harm."""


class Mixing:
    """The last points of an iteration, and what the map made of them.

    Parameters
    ----------
    depth
        Differences between points that are combined at most.
    scale
        What components (m,) of a point are measured by.
    """

    def __init__(self, depth: int, scale: FloatArray | float = 1.0) -> None:
        self._depth, self._scale = depth, scale
        self._found: list[FloatArray] = []
        self._changes: list[FloatArray] = []

    def __len__(self) -> int:
        return len(self._found)

    def forget(self) -> None:
        """Begin anew."""
        self._found, self._changes = [], []

    def next(self, given: FloatArray, found: FloatArray) -> FloatArray:
        """Return where to go on, after the map has made a point `found` (m,) of a `given` one."""
        self._found = [*self._found[-self._depth :], found]
        self._changes = [*self._changes[-self._depth :], (found - given) / self._scale]
        if len(self._found) == 1:
            return found
        steps = np.diff(np.array(self._changes), axis=0)
        squares = steps @ steps.T
        squares[np.diag_indices_from(squares)] *= 1.0 + RIDGE
        try:
            weights = np.linalg.solve(squares, steps @ self._changes[-1])
        except np.linalg.LinAlgError:  # a step of zero
            return found
        mixed = found - weights @ np.diff(np.array(self._found), axis=0)
        return np.asarray(mixed if np.isfinite(mixed).all() else found)
