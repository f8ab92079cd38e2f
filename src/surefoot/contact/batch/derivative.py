"""Derivatives of a batch of solutions: products with weights, compiled and on threads."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array
from surefoot.contact.batch.loops import derive_range, measure_range
from surefoot.contact.derivative.rates import Cotangents

InRanges = Callable[[Callable[[int, int], None]], None]
"""Runs work(start, stop) over all problems, in pieces on threads."""


class BatchDerivative:
    """Derivatives of a batch's forces and velocities; `valid` (B,) is False where a problem is not SOLVED.

    Taken at the forces as they were solved, without polish: the error is that of the solution times the
    active system's condition (tol=1e-12 costs a Newton step more, and gives them to about 1e-12). They belong
    to the mode that each contact is in: where `distance` is small others meet it, see `ContactDerivative`.
    """

    def __init__(
        self, G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, buffers: FloatArray,
        valid: BoolArray, in_ranges: InRanges,
    ) -> None:  # fmt: skip
        self._G, self._g, self._laws, self._convex = G, g, laws, convex
        self._buffers, self._in_ranges = buffers, in_ranges
        self.valid = valid

    @cached_property
    def distance(self) -> FloatArray:
        """(B,) distance to the nearest change of a mode, as a velocity over the largest of g."""
        found = np.full(len(self._g), np.inf)
        self._in_ranges(
            lambda a, b: measure_range(self._G, self._g, self._laws, self._convex, self._buffers, found, a, b)
        )
        return found

    def vjp(self, forces: ArrayLike | None = None, velocities: ArrayLike | None = None) -> Cotangents:
        """Return the gradients of forces·f + velocities·u, problem by problem, for (B, n, 3) weights.

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        B, n = len(self._g), self._g.shape[1] // 3
        weights = np.zeros((B, 2 * n, 3))
        if forces is not None:
            weights[:, :n] = finite_array("forces", forces, (B, n, 3))
        if velocities is not None:
            weights[:, n:] = finite_array("velocities", velocities, (B, n, 3))
        out, regular = np.empty_like(weights), np.ones(B, dtype=np.bool_)
        self._in_ranges(
            lambda a, b: derive_range(
                self._G, self._laws, self._convex, self._buffers, self.valid, weights, out, regular, a, b
            )
        )
        lawful = np.where(self.valid[:, None, None], self._buffers[:, :n], 0.0)
        return Cotangents(out, lawful, regular, self.valid)
