"""Contacts beside feet on the ground: the places where two bodies of a planar problem touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from surefoot.base.libraries import import_casadi


@dataclass(frozen=True)
class PlanarContactPair:
    """A place where two bodies of a planar robot can touch, whose coordinates are a vector space.

    Attributes
    ----------
    name
        For logs.
    distance
        q to its gap and to the place along its tangent, whose rate is the sliding velocity [m], as CasADi
        expressions.
    mu
        Friction coefficient.
    """

    name: str
    distance: Callable[[Any], tuple[Any, Any]]
    mu: float

    def at(self, q: Any) -> tuple[Any, Any]:
        """Return the gap, and the Jacobian (2, nv) along tangent and normal, at (nq,) q in symbols."""
        ca = import_casadi()
        gap, place = self.distance(q)
        return gap, ca.densify(ca.vertcat(ca.jacobian(place, q), ca.jacobian(gap, q)))
