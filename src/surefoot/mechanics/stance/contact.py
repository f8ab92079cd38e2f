"""One contact between a robot and the ground: a point or a sole."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from copy import copy
from functools import lru_cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_normal
from surefoot.contact import Cone, Fit, FrictionCone, FrictionPyramid, Sole

AROUND = 16
"""Sides of the pyramids around a sole that an uncertain wrench is held to [-]: within 2 % of friction."""


def _position(value: ArrayLike) -> FloatArray:
    """Return a (3,) position; numbers are looked at one by one, which is a third of the price of arrays."""
    xyz = _three(value)
    return finite_array("position", value, (3,)) if xyz is None else np.array(xyz)


def _frame(normal: ArrayLike, heading: ArrayLike) -> FloatArray:
    """Return `rotation_from_normal` of a surface, in scalars; what is out of the ordinary goes there."""
    n, h = _three(normal), _three(heading)
    if n is None or h is None:
        return rotation_from_normal(normal, heading)
    size = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    if not abs(size - 1.0) <= 1e-6:
        return rotation_from_normal(normal, heading)
    zx, zy, zz = n[0] / size, n[1] / size, n[2] / size
    along = h[0] * zx + h[1] * zy + h[2] * zz
    xx, xy, xz = h[0] - along * zx, h[1] - along * zy, h[2] - along * zz
    length = math.sqrt(xx * xx + xy * xy + xz * xz)
    if not length >= 1e-5 * math.sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]) > 1e-150:
        return rotation_from_normal(normal, heading)
    xx, xy, xz = xx / length, xy / length, xz / length
    yx, yy, yz = zy * xz - zz * xy, zz * xx - zx * xz, zx * xy - zy * xx
    return np.array([[xx, yx, zx], [xy, yy, zy], [xz, yz, zz]]) + 0.0  # + 0.0 turns -0.0 into 0.0


def _three(value: ArrayLike) -> tuple[float, float, float] | None:
    """Return three finite real numbers, or None where an array function had better look."""
    if isinstance(value, np.ndarray):
        if value.shape != (3,) or value.dtype != np.float64:
            return None
        value = value.tolist()
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        return None
    for entry in value:
        if not isinstance(entry, (float, int)) or not -1e308 < entry < 1e308:
            return None
    return float(value[0]), float(value[1]), float(value[2])


class Contact(ABC):
    """What a point and a sole share: place, frame, friction and bounds on the normal force.

    Parameters
    ----------
    position
        (3,) in world axes [m]; of the frame, for a sole.
    normal
        (3,) unit normal out of the ground.
    mu
        Friction coefficient [-], finite and >= 0.
    name
        Used in tables and messages.
    normal_min, normal_max
        Bounds on the normal force [N]; 0 <= normal_min <= normal_max.
    heading
        (3,) direction, in any unit, that the contact frame's x axis follows, projected into the surface.

    Raises
    ------
    ProblemError
        If a value is not finite, a normal is not unit, mu < 0, or the bounds are out of order.
    """

    dim: int

    def __init__(
        self,
        position: ArrayLike,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        mu: float = 0.6,
        name: str = "",
        normal_min: float = 0.0,
        normal_max: float = math.inf,
        heading: ArrayLike = (1.0, 0.0, 0.0),
    ) -> None:
        self.position = _position(position)
        self.rotation_world_contact = _frame(normal, heading)
        self.mu = real_number("mu", mu, low=0.0)
        if math.isinf(self.mu):
            raise ProblemError("mu must be finite, got inf")
        self.name = str(name)
        self.normal_min = real_number("normal_min", normal_min, low=0.0)
        self.normal_max = real_number("normal_max", normal_max, low=0.0)
        if self.normal_min > self.normal_max:
            raise ProblemError(
                f"normal_min must be <= normal_max, got {self.normal_min:g} > {self.normal_max:g}"
                + (f" for contact {self.name}" if self.name else "")
            )

    @property
    @abstractmethod
    def cone(self) -> Cone | Sole:
        """The cone of the contact's force (3) or wrench (6), in the contact frame."""

    @abstractmethod
    def unit_sides(self, facets: int, fit: Fit) -> tuple[FloatArray, BoolArray]:
        """Return rows C (m, dim) [-, m] of C @ force <= 0 with friction one, and those that it scales: (m,).

        Friction made of half-spaces: entries 2, 3, 4 of scaled rows are to be multiplied with mu.
        """

    def sides(self, facets: int, fit: Fit) -> FloatArray:
        """Return the rows C, (m, dim) [-, m], of C @ force <= 0: friction made of half-spaces."""
        rows, scaled = self.unit_sides(facets, fit)
        out = rows.copy()
        out[scaled, 2:5] *= self.mu
        return out

    def explains(self, force: FloatArray, deviation: FloatArray) -> bool:
        """Return whether an estimated force (dim,) in the contact frame pushes within its friction [N, N m].

        It may be beyond a limit by what its deviation (dim,) [N, N m] explains.
        """
        side = math.hypot(force[0], force[1]) - math.hypot(deviation[0], deviation[1])
        return bool(force[2] >= -deviation[2] and side <= self.mu * (force[2] + deviation[2]))

    def with_friction(self, mu: float) -> Self:
        """Return the same contact with another friction coefficient [-]."""
        twin = copy(self)
        twin.mu = mu
        return twin

    @property
    def normal(self) -> FloatArray:
        """(3,) unit normal out of the ground, world axes."""
        return self.rotation_world_contact[:, 2]

    def __repr__(self) -> str:
        place = np.array2string(self.position, precision=3)
        return f"{type(self).__name__}({self.name!r}, position={place}, mu={self.mu:g})"


class PointContact(Contact):
    """A foot that touches in a point: three force components, no moment.

    See `Contact` for the parameters.

    Examples
    --------
    >>> PointContact(position=[0.2, 0.1, 0.0], mu=0.6, name="FL").cone
    FrictionCone(mu=0.6)
    """

    dim = 3

    @property
    def cone(self) -> FrictionCone:
        """The friction cone of the contact force, in the contact frame."""
        return FrictionCone(self.mu)

    def unit_sides(self, facets: int, fit: Fit) -> tuple[FloatArray, BoolArray]:
        """(facets, 3) sides [-] of the friction pyramid, whose slack is in newtons of tangential force."""
        return _pyramid_sides(whole_number("facets", facets, low=3), fit)


@lru_cache(maxsize=16)
def _pyramid_sides(facets: int, fit: Fit) -> tuple[FloatArray, BoolArray]:
    """Return the sides of a friction pyramid with friction one, all of them scaled; not to be written to."""
    sides = FrictionPyramid(1.0, facets, fit).halfspaces
    sides.setflags(write=False)
    return sides, np.ones(len(sides), dtype=np.bool_)


class SoleContact(Contact):
    """A foot that touches with a flat sole: a wrench of six components in the contact frame.

    Parameters
    ----------
    sole
        Shape and friction, `sf.Sole`, in the contact frame; its pads are points (no torsional radius).
    position, normal, name, normal_min, normal_max, heading
        As for `Contact`; the position is that of the frame, a rectangle's centre.

    Raises
    ------
    ProblemError
        As for `Contact`, and for a sole with a torsional radius.

    Examples
    --------
    >>> foot = SoleContact([0.0, 0.1, 0.0], Sole(length=0.22, width=0.09, mu=0.6), name="left")
    >>> foot.cone, foot.mu
    (Sole(length=0.22, width=0.09, mu=0.6), 0.6)
    """

    dim = 6

    def __init__(
        self,
        position: ArrayLike,
        sole: Sole,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        name: str = "",
        normal_min: float = 0.0,
        normal_max: float = math.inf,
        heading: ArrayLike = (1.0, 0.0, 0.0),
    ) -> None:
        of_kind("sole", sole, Sole)
        if sole.torsional_radius > 0.0:
            raise ProblemError(
                "a stance's soles press at their corners, points without a torsional radius; got "
                f"{sole.torsional_radius:g} m"
            )
        super().__init__(position, normal, sole.mu, name, normal_min, normal_max, heading)
        self.sole = sole

    @property
    def cone(self) -> Sole:
        """The sole: the sum of its corners' friction cones."""
        return self.sole

    def explains(self, force: FloatArray, deviation: FloatArray) -> bool:
        """Return whether an estimated wrench (6,) is in the sole's cone, up to its deviation [N, N m]."""
        if not super().explains(force, deviation):
            return False
        verdict = self.sole.verdict(force)
        if verdict.holds:
            return True
        # no row of a cone around it, and not the twist that proves the wrench outside, by more than explained
        rows = self.sides(AROUND, "outer")
        if verdict.twist is not None:
            rows = np.vstack([rows, verdict.twist])
        return not (rows @ force > np.abs(rows) @ deviation).any()

    def with_friction(self, mu: float) -> SoleContact:
        """Return the same contact with another friction coefficient [-]."""
        twin = super().with_friction(mu)
        twin.sole = self.sole.with_friction(mu)
        return twin

    def unit_sides(self, facets: int, fit: Fit) -> tuple[FloatArray, BoolArray]:
        """(m, 6) rows [-, m] of the sum of its corners' pyramids, see `Sole.polyhedral`."""
        from surefoot.contact import unit_rows

        return unit_rows(self.sole.corners, whole_number("facets", facets, low=3), fit)

    def corners(self) -> list[PointContact]:
        """Return the sole's corners as point contacts with the same frame and friction.

        Their forces generate the same set of wrenches as the sole. The normal bounds belong to the
        sum, so corners carry only the upper one.
        """
        out = []
        for k, (x, y) in enumerate(self.sole.corners):
            place = self.position + self.rotation_world_contact @ np.array([x, y, 0.0])
            out.append(
                PointContact(
                    place, self.normal, self.mu, f"{self.name}.{k}", 0.0, self.normal_max,
                    self.rotation_world_contact[:, 0],
                )
            )  # fmt: skip
        return out
