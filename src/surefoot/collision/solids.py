"""Which shapes move with which joint, what their surfaces are, and which pairs of them may touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray, real_number
from surefoot.collision.shapes import Box, Shape
from surefoot.contact.engines import combination_rules, combine_friction
from surefoot.errors import ProblemError, check_name
from surefoot.terrain import Terrain
from surefoot.terrain import shapes as pieces


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
        `surefoot.contact.engines.combination_rules`.
    propagation
        Whether impacts run from body to body one after the other, as in Newton's cradle; else Newton's law
        holds for all contacts at once.

    Raises
    ------
    ProblemError
        For an unknown rule.
    """

    solids: tuple[Solid, ...]
    apart: frozenset[tuple[int, int]] = frozenset()
    combine: str = "physx-min"
    propagation: bool = False

    def __post_init__(self) -> None:
        check_name("rule", self.combine, combination_rules())

    def with_ground(self, solids: tuple[Solid, ...]) -> Geometry:
        """Return the geometry with pieces of ground behind its own solids."""
        return replace(self, solids=self.solids + solids)

    def pairs(self) -> IntArray:
        """Return the pairs (m, 2) of solids that may touch; what does not move comes first in each."""
        out = []
        for a, b in combinations(range(len(self.solids)), 2):
            one, two = self.solids[a], self.solids[b]
            if one.joint == two.joint or (a, b) in self.apart:
                continue
            if not (_stands(one) or two.on_ground) or not (_stands(two) or one.on_ground):
                continue  # feet have their own contacts with the ground
            out.append((b, a) if two.joint == 0 else (a, b))
        return np.array(out, dtype=np.int64).reshape(-1, 2)

    def mixed(self, first: float | None, second: float | None, ground: float) -> float:
        """Return the coefficient of a contact of two surfaces, None for the `ground`'s own."""
        if first is None and second is None:
            return ground
        own = [ground if c is None else c for c in (first, second)]
        return combine_friction(self.combine, *own)


def _stands(solid: Solid) -> bool:
    """Return whether a solid is no piece of ground."""
    return solid.joint > 0 or solid.on_ground


def ground_solids(terrain: Terrain) -> tuple[Solid, ...] | None:
    """Return a terrain's boxes as solids; None where it has other shapes than boxes, or says none.

    Steps have edges and vertical faces, which a height field does not know; a plane or a smooth surface is
    as well or better touched by the spheres at a solid's knots.
    """
    try:
        shapes = () if terrain.planar else terrain.shapes()
    except ProblemError:
        return None
    makers: dict[type, Callable[[Any], Solid]] = {pieces.Box: _box}
    if not shapes or not all(type(shape) in makers for shape in shapes):
        return None
    return tuple(replace(makers[type(s)](s), name=f"ground:{k}") for k, s in enumerate(shapes))


def _box(piece: pieces.Box) -> Solid:
    """Return a terrain's box as a solid."""
    a, b, c = (float(edge) for edge in piece.size)
    return Solid("ground", Box((a, b, c)), 0, position=np.array(piece.centre), on_ground=False)
