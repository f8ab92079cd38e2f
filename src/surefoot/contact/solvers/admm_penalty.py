"""The penalty of ADMM: balanced between the residuals, and larger where the error no longer falls."""

from __future__ import annotations

import math

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel

BALANCE = 3.0
"""The penalty changes when one residual exceeds the other by this factor."""
WANDERING, FALLS, FLOOR_GROWTH, FLOOR_MOST = 1500, 0.7, 3.0, 1.0
"""Iterations in which the error should fall to this share, by how much the penalty grows where it does not,
and about up to which share of the largest eigenvalue of G; from there it begins again."""


@inline_kernel
def next_penalty(
    rho: float, used: float, primal: float, dual: float, z: FloatArray, y: FloatArray, largest: float
) -> float:
    """Return the penalty that balances the residuals of z, y (m,), or the one in use if that is near enough.

    rho sqrt((primal / max |z|) / (dual / max |y|)): Boyd et al. 2011, section 3.4.1, in relative residuals.
    `largest` is about the largest eigenvalue of G, which bounds it from both sides.
    """
    most_z = most_y = 1e-300
    for i in range(z.size):
        most_z, most_y = max(most_z, abs(z[i])), max(most_y, abs(y[i]))
    ratio = (primal / most_z) / max(dual / most_y, 1e-300)
    if 1.0 / BALANCE <= ratio <= BALANCE:
        return rho
    # at most tenfold at a time, and far enough from G's spectrum on both sides that neither
    # the copy nor the problem is forgotten
    rho = min(max(rho * min(max(math.sqrt(ratio), 0.1), 10.0), 1e-8 * largest), 1e6 * largest)
    # a new penalty costs an inverse: one that is within half of the old is not worth it
    return rho if rho > 1.5 * used or rho < used / 1.5 else used


class PenaltyFloor:
    """A least penalty that grows where the error no longer falls.

    Under a small penalty the shift, which lags by an iteration, may wander for ever: a larger one damps it.
    """

    def __init__(self, largest: float) -> None:
        self.least, self._most = 0.0, FLOOR_MOST * largest
        self._mark, self._since = math.inf, 0

    def look(self, error: float, rho: float, done: int) -> None:
        """Take note of the error after so many iterations more with a penalty rho."""
        self._since += done
        if error < FALLS * self._mark:
            self._mark, self._since = error, 0
        elif self._since >= WANDERING:
            self.least = FLOOR_GROWTH * rho if self.least < self._most else 0.0
            self._since = 0
