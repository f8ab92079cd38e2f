"""Many cones side by side: the set of all contact forces of a stance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.cones.cone import Cone

if TYPE_CHECKING:
    from surefoot.contact.cones.sole import Sole


class ProductCone(Cone):
    """The product of cones: x = (x_1, ..., x_n) with x_i in cones[i].

    Parameters
    ----------
    cones
        The factors, in the order of the stacked vector; none at all gives the cone {()} of dimension 0. Soles
        bring their own metric for `project` and their own `margin`.
    """

    def __init__(self, cones: Sequence[Cone | Sole]) -> None:
        self.cones = tuple(cones)
        ends = np.cumsum([0, *(c.dim for c in self.cones)])
        self.slices = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        self.dim = int(ends[-1])

    def __repr__(self) -> str:
        return f"ProductCone([{', '.join(map(repr, self.cones))}])"

    def project(self, x: ArrayLike) -> FloatArray:
        """Return the nearest point of the product, factor by factor, in the unit of x: (..., dim)."""
        points = self._points(x)
        out = np.empty_like(points)
        for cone, part in zip(self.cones, self.slices, strict=True):
            out[..., part] = cone.project(points[..., part])
        return out

    def margin(self, x: ArrayLike) -> FloatArray:
        """Return the signed distance of x (..., dim) to the boundary, in the unit of x: (...).

        Inside, the least margin of the factors; outside, minus the root of the summed squared distances.
        """
        points = self._points(x)
        if not self.cones:
            return np.full(points.shape[:-1], np.inf)
        parts = zip(self.cones, self.slices, strict=True)
        margins = np.stack([c.margin(points[..., s]) for c, s in parts], axis=-1)
        # squared distances to the factors add up; the largest ball inside is the smallest of theirs
        distance = np.linalg.norm(np.minimum(margins, 0.0), axis=-1)
        return np.asarray(np.where(distance > 0.0, -distance, margins.min(axis=-1)))

    def dual(self) -> ProductCone:
        """Return the product of the duals.

        Raises
        ------
        ProblemError
            If a factor is a sole, whose metric is its own.
        """
        soles = [c for c in self.cones if not isinstance(c, Cone)]
        if soles:
            raise ProblemError(
                f"no dual cone is built for {soles[0]!r}; take `support`, which tells of its polar"
            )
        return ProductCone([c.dual() for c in self.cones if isinstance(c, Cone)])

    def support(self, direction: ArrayLike, tol: float = 1e-9) -> FloatArray:
        """Return sup of direction . x over the product, factor by factor: (...), 0 or infinity."""
        d = self._points(direction)
        parts = zip(self.cones, self.slices, strict=True)
        found = [c.support(d[..., s], tol) for c, s in parts]
        return np.asarray(np.max(found, axis=0)) if found else np.zeros(d.shape[:-1])
