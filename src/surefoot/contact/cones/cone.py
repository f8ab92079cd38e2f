"""The interface that every cone implements."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, numbers
from surefoot.base.errors import ProblemError

Fit = Literal["inner", "outer"]
"""Which side of a cone its pyramid is on: "inner" never promises a force that the cone does not hold."""


class Cone(ABC):
    """A closed convex cone in R^dim; every method accepts leading batch axes.

    The dual is K* = {y : x . y >= 0 for all x in K}; the polar is -K*. Moreau: every x equals
    ``project(x) - dual().project(-x)``, and the two parts are orthogonal.
    """

    dim: int

    @abstractmethod
    def project(self, x: ArrayLike) -> FloatArray:
        """Return the nearest point of the cone (Euclidean), in the unit of x: (..., dim)."""

    @abstractmethod
    def margin(self, x: ArrayLike) -> FloatArray:
        """Return the signed Euclidean distance of x (..., dim) to the boundary: (...), positive inside.

        It is the radius of the largest ball around x that stays inside the cone or, outside,
        minus the distance to the cone; in the unit of x.
        """

    @abstractmethod
    def dual(self) -> Cone:
        """Return the dual cone K* = {y : x . y >= 0 for all x in K}."""

    def contains(self, x: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether x (..., dim), in any unit, lies in the cone, within tol max(1, ||x||): (...)."""
        points = self._points(x)
        scale = np.maximum(1.0, np.linalg.norm(points, axis=-1))
        return np.asarray(self.margin(points) >= -tol * scale)

    def support(self, direction: ArrayLike, tol: float = 1e-9) -> FloatArray:
        """Return sup of direction . x over the cone for (..., dim) directions in any unit: (...).

        It is 0 where the direction lies in the polar (within a relative `tol`), else inf.
        """
        d = self._points(direction)
        return np.where(self.dual().contains(-d, tol), 0.0, np.inf)

    def _points(self, x: ArrayLike) -> FloatArray:
        """Return x as floats, its last axis checked against `dim`."""
        points = numbers("points", x)
        if points.ndim == 0 or points.shape[-1] != self.dim:
            raise ProblemError(f"expected points of shape (..., {self.dim}), got {points.shape}")
        return points
