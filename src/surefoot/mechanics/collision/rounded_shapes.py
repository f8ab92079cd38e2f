"""Sphere, box and capsule: one form, a box of half extents `core` that grew by `radius` on all sides."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, positive_number
from surefoot.base.errors import ProblemError, needs


class Shape(ABC):
    """A convex shape about its own origin; a value.

    Attributes
    ----------
    radius
        How far the surface lies outside the core [m].
    """

    radius: float

    @property
    @abstractmethod
    def core(self) -> FloatArray:
        """Half extents (3,) of the core along its own axes [m]: a point, a line along z or a box."""

    @abstractmethod
    def moments(self, mass: float) -> FloatArray:
        """Return the principal moments (3,) of a homogeneous body of `mass` [kg m^2]."""

    @abstractmethod
    def solid(self) -> Any:
        """Return coal's value of the shape."""

    def inset(self, depth: float) -> Box:
        """Return the box that lies `depth` inside the core [m], at most a tenth of its least extent."""
        return Box(tuple((2.0 * (self.core - min(depth, 0.1 * float(self.core.min())))).tolist()))

    def knots(self, along: int = 2) -> FloatArray:
        """Return the centres (k, 3) of spheres of `radius` whose hull is the shape [m].

        `along` is how many of them a capsule's line has, its ends included.
        """
        del along
        corners = self.core * np.array(list(product((1.0, -1.0), repeat=3)))
        return np.unique(corners + 0.0, axis=0)[::-1].copy()


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball of `radius` [m].

    >>> Sphere(0.1).moments(5.0)
    array([0.02, 0.02, 0.02])
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive_number("radius", self.radius))

    @property
    def core(self) -> FloatArray:
        """A point: (3,) zeros."""
        return np.zeros(3)

    def moments(self, mass: float) -> FloatArray:
        """Return 2/5 m r² about each axis: (3,) [kg m²]."""
        return np.full(3, 0.4 * mass * self.radius**2)

    def solid(self) -> Any:
        """Return coal's sphere."""
        return coal().Sphere(self.radius)


@dataclass(frozen=True)
class Box(Shape):
    """A box with full edge lengths `size` (3,) [m].

    >>> Box((0.4, 0.3, 0.2)).core
    array([0.2 , 0.15, 0.1 ])
    """

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        edges = finite_array("size", self.size, (3,))
        if not (edges > 0.0).all():
            raise ProblemError(f"size must be positive, got {edges.min():g}")
        object.__setattr__(self, "size", tuple(edges.tolist()))
        object.__setattr__(self, "radius", 0.0)

    @property
    def core(self) -> FloatArray:
        """Half the edges: (3,) [m]."""
        return 0.5 * np.array(self.size)

    def moments(self, mass: float) -> FloatArray:
        """Return m (b² + c²) / 12 about each axis: (3,) [kg m²]."""
        squares = np.array(self.size) ** 2
        return np.asarray(mass / 12.0 * (squares.sum() - squares))

    def solid(self) -> Any:
        """Return coal's box."""
        return coal().Box(*self.size)


@dataclass(frozen=True)
class Capsule(Shape):
    """A cylinder along z of `radius` and `length` [m] with half a ball on either end, length + 2 radius.

    >>> Capsule(0.05, 0.2).core
    array([0. , 0. , 0.1])
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive_number("radius", self.radius))
        object.__setattr__(self, "length", positive_number("length", self.length))

    @property
    def core(self) -> FloatArray:
        """A line along z: (3,) [m]."""
        return np.array([0.0, 0.0, 0.5 * self.length])

    def moments(self, mass: float) -> FloatArray:
        """Return the moments of the cylinder and the two half balls together: (3,) [kg m²]."""
        r, h = self.radius, self.length
        density = mass / (math.pi * r * r * (h + 4.0 / 3.0 * r))
        tube, ball = density * math.pi * r * r * h, density * 4.0 / 3.0 * math.pi * r**3
        # a half ball's own centre of mass lies 3/8 r from its flat side
        across = tube * (r * r / 4.0 + h * h / 12.0) + ball * (0.4 * r * r + h * h / 4.0 + 3.0 / 8.0 * r * h)
        return np.array([across, across, r * r * (tube / 2.0 + 0.4 * ball)])

    def solid(self) -> Any:
        """Return coal's capsule."""
        return coal().Capsule(self.radius, self.length)

    def knots(self, along: int = 2) -> FloatArray:
        """Return places on the line from end to end (along, 3) [m]."""
        out = np.zeros((along, 3))
        out[:, 2] = np.linspace(0.5 * self.length, -0.5 * self.length, along)
        return out


def coal() -> Any:
    """Return coal, which comes with Pinocchio."""
    with needs("pin", "robot"):
        import coal as library
    return library
