"""Small planar mechanisms as CasADi functions: point masses that move with q, and contacts between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.transcription.forms import import_casadi
from surefoot.spatial import GRAVITY

Place = Callable[[Any], tuple[Any, Any]]
"""q to the position (x, z) of a point [m], as CasADi expressions."""
Distance = Callable[[Any], tuple[Any, Any]]
"""q to the gap of a contact and to the position along its tangent, whose rate is the sliding velocity [m]."""


@dataclass(frozen=True)
class Touch:
    """A place where two things can touch.

    Attributes
    ----------
    name
        For tables and logs.
    distance
        Gap and place along the tangent. Where the tangent turns with q, give a function whose *rate* at q is
        the sliding velocity.
    mu
        Friction coefficient; 0 for none, which spares its variables.
    """

    name: str
    distance: Distance
    mu: float = 0.0


@dataclass(frozen=True)
class System:
    """M(q) (v⁺ - v) = dt (S u - h(q, v)) + Jᵀ impulses, q⁺ = q + dt v⁺, for q in a vector space.

    Attributes
    ----------
    name
        For messages.
    coordinates
        Names of the n coordinates.
    actuated
        Numbers of those that motors move.
    touches
        The p contacts.
    mass, bias, gap, normal, tangent
        CasADi functions: (q) -> (n, n), (q, v) -> (n,), (q) -> (p,), (p, n) and (p, n).
    """

    name: str
    coordinates: tuple[str, ...]
    actuated: tuple[int, ...]
    touches: tuple[Touch, ...]
    mass: Any
    bias: Any
    gap: Any
    normal: Any
    tangent: Any

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @property
    def mu(self) -> FloatArray:
        """(p,) friction coefficients."""
        return np.array([t.mu for t in self.touches])

    @property
    def rubbing(self) -> tuple[int, ...]:
        """Numbers of the contacts with friction."""
        return tuple(k for k, t in enumerate(self.touches) if t.mu > 0.0)

    @property
    def selection(self) -> FloatArray:
        """(n, m) S: what the m motors do to the coordinates."""
        return np.eye(self.size)[:, list(self.actuated)]


def point_masses(
    name: str,
    coordinates: Sequence[str],
    actuated: Sequence[int],
    masses: Sequence[tuple[float, Place]],
    touches: Sequence[Touch],
) -> System:
    """Return the system of masses [kg] at places that move with the coordinates, under gravity along -z.

    M = Σ m Jᵀ J and h = Σ m Jᵀ (dJ/dt v + (0, g)), with J of each place by automatic differentiation.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    casadi = import_casadi()
    n = len(coordinates)
    q, v = casadi.SX.sym("q", n), casadi.SX.sym("v", n)
    M, h = casadi.SX.zeros(n, n), casadi.SX.zeros(n)
    for mass, place in masses:
        J = casadi.jacobian(casadi.vertcat(*place(q)), q)
        drift = casadi.jtimes(J @ v, q, v)
        M += mass * J.T @ J
        h += mass * J.T @ (drift + casadi.vertcat(0.0, GRAVITY))
    gaps, along = zip(*(touch.distance(q) for touch in touches), strict=True)
    gap, way = casadi.vertcat(*gaps), casadi.vertcat(*along)

    def function(of: str, at: list[Any], what: Any) -> Any:
        return casadi.Function(of, at, [casadi.densify(what)])

    return System(
        name, tuple(coordinates), tuple(actuated), tuple(touches), function("mass", [q], M),
        function("bias", [q, v], h), function("gap", [q], gap),
        function("normal", [q], casadi.jacobian(gap, q)), function("tangent", [q], casadi.jacobian(way, q)),
    )  # fmt: skip


def along_ground(place: Place, radius: float = 0.0) -> Distance:
    """Return gap and tangent of a point, or a ball of `radius` [m], over the plane z = 0."""

    def distance(q: Any) -> tuple[Any, Any]:
        x, z = place(q)
        return z - radius, x

    return distance
