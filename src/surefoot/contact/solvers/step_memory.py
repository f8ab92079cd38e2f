"""What the interior point's steps work in: scalings, the matrix and its factors, and the last motion."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.contact.solvers import cone_pairs as pairs
from surefoot.contact.solvers.central_step import Iterate, Scaling, central_step
from surefoot.contact.solvers.path_step import Motion, path_step


class StepMemory:
    """What an iteration works in: scalings and the matrix, for the scaled rows of Y (3n, r)."""

    def __init__(self, rows: FloatArray) -> None:
        n, r = len(rows) // 3, rows.shape[1]
        self.rows, self.across = rows, np.ascontiguousarray(rows.T)
        self.scaling = Scaling(np.empty((n, 4)), np.empty((n, 3)), np.empty((n, 3, 3)))
        self.weighed, self.residual = np.empty((3 * n, r)), np.empty((n, 3))
        self.diagonal = np.diag_indices(r)
        self.motion = Motion(np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(1))

    def scale(self, point: Iterate, share: float) -> float:
        """Fill the scalings of a point; return its gap, the mean of x · y."""
        return pairs.scale_pairs(*point, share, *self.scaling)

    def factors(self) -> tuple[FloatArray, IntArray] | None:
        """Return LAPACK's factors (r, r) of I + Yᵀ P S⁻¹ Y, transposed, with their pivots (r,)."""
        pairs.weigh_rows(self.scaling.weights, self.rows, self.weighed)
        matrix = self.weighed.T @ self.rows  # transposed, as LAPACK has it
        matrix[self.diagonal] += 1.0
        lu, pivots, failed = scipy.linalg.lapack.dgetrf(matrix.T, overwrite_a=1)
        return None if failed else (lu.T, pivots)

    def advance(self, point: Iterate, gap: float, share: float, least: float) -> tuple[float, Iterate | None]:
        """Take a step with the residual that is there; return its length and the point after it, if any."""
        factors = self.factors()
        if factors is None:
            return 0.0, None
        after = Iterate(*(np.empty_like(part) for part in point))
        length = central_step(
            *factors, self.rows, self.across, point, self.residual, self.scaling, gap, share, least, after
        )
        return length, after if length > 0.0 else None

    def go_along(self, point: Iterate, gap: float) -> tuple[float, Iterate | None]:
        """Take a step by the path's length; return the change of the log gap, and the point after it."""
        factors = self.factors()
        if factors is None:
            return 0.0, None
        after = Iterate(*(np.empty_like(part) for part in point))
        length, log = path_step(
            *factors, self.rows, self.across, point, self.residual, self.scaling, gap, self.motion, after
        )
        return log, after if length > 0.0 else None

    def forget(self) -> None:
        """Forget the last step along the path."""
        for part in self.motion:
            part[:] = 0.0
