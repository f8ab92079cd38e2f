"""One contact between a robot and the ground: a point or a rectangular patch."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_normal
from surefoot.contact import Cone, Fit, FrictionCone, WrenchCone


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
    """What a point and a patch share: place, frame, friction and bounds on the normal force.

    Parameters
    ----------
    position
        (3,) in world axes [m]; the centre, for a patch.
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
    def cone(self) -> Cone:
        """The cone of the contact's force (3) or wrench (6), in the contact frame."""

    @abstractmethod
    def sides(self, facets: int, fit: Fit) -> FloatArray:
        """Return the rows C, (side_count, dim) [-, m], of C @ force <= 0: friction made of half-spaces."""

    @abstractmethod
    def side_count(self, facets: int) -> int:
        """Return how many rows `sides` has."""

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

    def sides(self, facets: int, fit: Fit) -> FloatArray:
        """(facets, 3) sides [-] of the friction pyramid, whose slack is in newtons of tangential force."""
        return self.cone.polyhedral(facets, fit).halfspaces[: int(facets)]

    def side_count(self, facets: int) -> int:
        """Return `facets`."""
        return facets


class PatchContact(Contact):
    """A flat rectangular foot: a wrench of six components about the patch's centre.

    Parameters
    ----------
    length, width
        Full size along the contact frame's x and y axes [m], > 0.
    position, normal, mu, name, normal_min, normal_max, heading
        As for `Contact`.
    """

    dim = 6

    def __init__(
        self,
        position: ArrayLike,
        length: float,
        width: float,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        mu: float = 0.6,
        name: str = "",
        normal_min: float = 0.0,
        normal_max: float = math.inf,
        heading: ArrayLike = (1.0, 0.0, 0.0),
    ) -> None:
        super().__init__(position, normal, mu, name, normal_min, normal_max, heading)
        self.length = real_number("length", length, low=0.0)
        self.width = real_number("width", width, low=0.0)
        if not (0.0 < self.length < math.inf and 0.0 < self.width < math.inf):
            raise ProblemError(
                f"length and width must be positive and finite, got {self.length:g} and {self.width:g}"
            )

    @property
    def cone(self) -> Cone:
        """The contact wrench cone of the patch: the sum of its corners' cones."""
        return WrenchCone(self.length, self.width, self.mu)

    def sides(self, facets: int, fit: Fit) -> FloatArray:
        """(16, 6) rows of the `WrenchCone` [-, m]; its friction pyramid has four sides whatever `facets`."""
        return WrenchCone(self.length, self.width, self.mu, fit).halfspaces

    def side_count(self, facets: int) -> int:
        """Return 16."""
        return 16

    def corner_offsets(self) -> FloatArray:
        """(4, 2) places of the corners in the contact frame [m], clockwise from front left."""
        half = np.array([0.5 * self.length, 0.5 * self.width])
        return np.asarray(half * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]]))

    def corners(self) -> list[PointContact]:
        """Return the four corners as point contacts with the same frame and friction.

        Their forces generate the same set of wrenches as the patch. The normal bounds belong to the
        sum, so corners carry only the upper one.
        """
        out = []
        for k, (x, y) in enumerate(self.corner_offsets()):
            place = self.position + self.rotation_world_contact @ np.array([x, y, 0.0])
            out.append(
                PointContact(
                    place, self.normal, self.mu, f"{self.name}.{k}", 0.0, self.normal_max,
                    self.rotation_world_contact[:, 0],
                )
            )  # fmt: skip
        return out
