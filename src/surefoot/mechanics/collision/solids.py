"""Which shapes move with which joint, what their surfaces are, and which pairs of them may touch."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.contact import combination_rules, combine_friction
from surefoot.mechanics.collision.rounded_shapes import Box, Shape
from surefoot.mechanics.terrain import GroundBox, Terrain


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape that is fixed to a joint.

    Attributes
    ----------
    name
        Of what it is.
    shape
        Its shape.
    joint
        Pinocchio's index of the joint that carries it, 0 for what does not move.
    rotation, position
        (3, 3) and (3,) of the shape in the joint's frame [m].
    friction, restitution
        Of its surface; None for those of the ground.
    on_ground
        Whether it may touch the terrain: not what stands on it as a foot, and not the terrain.
    """

    name: str
    shape: Shape
    joint: int
    rotation: FloatArray = field(default_factory=lambda: np.eye(3))
    position: FloatArray = field(default_factory=lambda: np.zeros(3))
    friction: float | None = None
    restitution: float | None = None
    on_ground: bool = True

    def __post_init__(self) -> None:
        if self.friction is not None and not real_number("friction", self.friction, low=0.0) < np.inf:
            raise ProblemError("friction must be finite")
        if self.restitution is not None:
            real_number("restitution", self.restitution, low=0.0, high=1.0)


@dataclass(frozen=True, eq=False)
class Geometry:
    """The solids of a scene.

    Attributes
    ----------
    solids
        In any order.
    apart
        Pairs of indices into `solids`, the smaller one first, that are never tested: neighbours in a robot.
    combine
        How the coefficients of two surfaces make those of a contact, see
        `surefoot.contact.translation.combination_rules`.

    Raises
    ------
    ProblemError
        For an unknown rule.
    """

    solids: tuple[Solid, ...]
    apart: frozenset[tuple[int, int]] = frozenset()
    combine: str = "physx-min"

    def __post_init__(self) -> None:
        check_name("rule", self.combine, combination_rules())

    def pairs(self, among: IntArray | None = None) -> IntArray:
        """Return the pairs (m, 2) of solids that may touch, of `among` (k, 2) with the smaller index first.

        None for all; what does not move comes first in each.
        """
        n, (joint, ground) = len(self.solids), self._places
        a, b = np.triu_indices(n, 1) if among is None else among.T
        stands = (joint > 0) | ground  # no piece of ground
        # feet have their own contacts with the ground
        keep = (joint[a] != joint[b]) & (stands[a] | ground[b]) & (stands[b] | ground[a])
        if self.apart:
            keep &= ~np.isin(a * n + b, [one * n + two for one, two in self.apart])
        a, b = a[keep].astype(np.int64), b[keep].astype(np.int64)
        turned = (joint[b] == 0)[:, None]
        return np.where(turned, np.stack([b, a], axis=1), np.stack([a, b], axis=1))

    @cached_property
    def _places(self) -> tuple[IntArray, BoolArray]:
        """The solids' joints (s,), and which of them may touch the ground (s,)."""
        joint = np.array([s.joint for s in self.solids], dtype=np.int64)
        return joint, np.array([s.on_ground for s in self.solids], dtype=np.bool_)

    def mixed(self, first: float | None, second: float | None, ground: float) -> float:
        """Return the coefficient of a contact of two surfaces, None for the `ground`'s own."""
        if first is None and second is None:
            return ground
        own = [ground if c is None else c for c in (first, second)]
        return combine_friction(self.combine, *own)


def ground_solids(terrain: Terrain) -> tuple[Solid, ...] | None:
    """Return a terrain's boxes as solids; None where it has other shapes than boxes, or says none.

    Steps have edges and vertical faces, which a height field does not know; a plane or a smooth surface is
    as well or better touched by the spheres at a solid's knots.
    """
    try:
        shapes = () if terrain.planar else terrain.shapes()
    except ProblemError:
        return None
    boxes = [shape for shape in shapes if isinstance(shape, GroundBox)]
    if not shapes or len(boxes) < len(shapes):
        return None
    return tuple(
        Solid(f"ground:{k}", Box(tuple(b.size.tolist())), 0, position=np.array(b.centre), on_ground=False)
        for k, b in enumerate(boxes)
    )
