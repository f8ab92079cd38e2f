"""Contact of a compliant body by a pressure field, integrated over the area in which the ground cuts it.

R. Elandt, E. Drumwright, M. Sherman, A. Ruina, "A pressure field model for fast, robust approximation of net
contact force and moment between nominally rigid objects", IROS 2019; Drake's hydroelastic contact of a
compliant body with a rigid one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array, real_number
from surefoot.contact.laws.pressure.pieces import (
    CompliantSolid,
    Facet,
    clipped,
    facets,
    nodes,
    nodes_about,
)
from surefoot.contact.laws.soft.law import ExactFriction, Friction, as_friction
from surefoot.errors import ProblemError
from surefoot.terrain import FlatTerrain, Terrain

FAR = 30.0
"""A centre of rotation that lies farther away than this many sizes of a patch needs no rays from it."""

FAINT = 1e-140
"""Force below which there is no contact [N]: a centre of pressure would be a quotient of nothings."""


class Wetted(NamedTuple):
    """A wetted polygon (k, 3), its normal (3,), and the gradient and constant of its pressure at rest."""

    corners: FloatArray
    normal: FloatArray
    gradient: FloatArray
    constant: float


class PressurePatch(NamedTuple):
    """The contact of a compliant body with the ground; forces on the body, world axes.

    Attributes
    ----------
    force
        (3,) pressure and friction [N].
    moment
        (3,) of all of it about `centre` [N m].
    normal_force
        Pressure integrated over the area, whatever its directions [N].
    centre
        (3,) centre of pressure [m]; NaN without contact.
    area
        Wetted, in the ground's surface [m²].
    largest
        Largest pressure at a corner of the wetted polygons, damping included [Pa].
    friction_force, friction_torque
        (3,) [N], and about the mean normal at the centre [N m].
    spin_limit
        Largest torque about the mean normal at the centre that friction gives to a body that only turns
        there [N m].
    polygons, pressures
        The wetted pieces (k, 3) [m] with the pressures at their corners (k,) [Pa].
    """

    force: FloatArray
    moment: FloatArray
    normal_force: float
    centre: FloatArray
    area: float
    largest: float
    friction_force: FloatArray
    friction_torque: float
    spin_limit: float
    polygons: list[FloatArray]
    pressures: list[FloatArray]

    def wrench(self, about: FloatArray) -> FloatArray:
        """Return (6,) [force; moment about a point (3,) [m]] [N, N m], zeros without contact."""
        if not self.normal_force > 0.0:
            return np.zeros(6)
        lever = self.centre - np.asarray(about, dtype=np.float64)
        return np.concatenate([self.force, self.moment + np.cross(lever, self.force)])


@dataclass(frozen=True)
class PressureField:
    """p = modulus depth / thickness max(0, 1 + dissipation rate), depth from the body's nearest face.

    Parameters
    ----------
    modulus
        Pressure at a depth of one thickness [Pa].
    thickness
        Of the compliant layer [m]; Drake's box has half its smallest edge.
    dissipation
        Hunt and Crossley's [s/m].
    friction
        A `Friction`, or a coefficient for exact friction.

    Examples
    --------
    >>> sole = CompliantSolid.sole([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]], thickness=0.01)
    >>> patch = PressureField(1e6, 0.01).contact(sole, np.eye(3), [0.0, 0.0, -1e-4])
    >>> round(patch.normal_force, 9), round(patch.area, 9)
    (200.0, 0.02)
    """

    modulus: float
    thickness: float
    dissipation: float = 0.0
    friction: Friction = field(default_factory=ExactFriction)

    def __post_init__(self) -> None:
        real_number("modulus", self.modulus, low=np.finfo(float).tiny, high=1e300)
        real_number("thickness", self.thickness, low=1e-9, high=1e6)
        real_number("dissipation", self.dissipation, low=0.0, high=1e150)
        object.__setattr__(self, "friction", as_friction(self.friction))

    def contact(
        self,
        solid: CompliantSolid,
        rotation: ArrayLike,
        position: ArrayLike,
        twist: ArrayLike | None = None,
        terrain: Terrain | None = None,
    ) -> PressurePatch:
        """Return what the ground does to a body.

        Parameters
        ----------
        solid
            The compliant body.
        rotation, position
            rotation_world_body (3, 3) and its origin (3,) [m].
        twist
            (6,) [linear velocity of the origin; angular velocity], world axes [m/s, rad/s]; None at rest.
            Exact friction is zero where nothing slides: how much of it a foot at rest takes is another
            problem's answer.
        terrain
            Rigid ground of planes; None for flat.

        Raises
        ------
        ProblemError
            For input that is not finite, a rotation that is none, or ground that is not of planes.
        """
        R, p = finite_array("rotation", rotation, (3, 3)), finite_array("position", position, (3,))
        if not (np.abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0.0):
            raise ProblemError("rotation must be a rotation matrix")
        moving = np.zeros(6) if twist is None else finite_array("twist", twist, (6,))
        ground = FlatTerrain() if terrain is None else terrain
        pieces: list[Wetted] = []
        for facet in facets(ground, solid.corners @ R.T + p):
            pieces += self._wetted(solid, R, p, moving, facet)
        return self._integrated(pieces, p, moving)

    def rest(
        self, solid: CompliantSolid, load: float, centre: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray, PressurePatch]:
        """Return how a body lies on flat ground at z = 0 under a load; see `resting.resting_pose`."""
        from surefoot.contact.laws.pressure.resting import resting_pose

        return resting_pose(self, solid, load, centre)

    def _wetted(
        self, solid: CompliantSolid, R: FloatArray, p: FloatArray, twist: FloatArray, facet: Facet
    ) -> list[Wetted]:
        """Return the parts of a piece of ground inside the body, one for each face that is nearest there."""
        inside = facet.corners
        axes, offsets = solid.normals @ R.T, solid.offsets + solid.normals @ (R.T @ p)
        for axis, offset in zip(axes, offsets, strict=True):
            inside = clipped(inside, offset - inside @ axis)
            if not len(inside):
                return []
        inside = clipped(inside, self._damping(facet.normal, inside, p, twist))
        out, scale = [], self.modulus / self.thickness
        pressed = np.flatnonzero(solid.pressed)
        for i in pressed:
            part = inside
            for j in pressed[pressed != i]:
                if len(part):
                    part = clipped(part, offsets[j] - offsets[i] - part @ (axes[j] - axes[i]))
            if len(part):
                out.append(Wetted(part, facet.normal, -scale * axes[i], scale * float(offsets[i])))
        return out

    def _pressure(self, piece: Wetted, points: FloatArray, p: FloatArray, twist: FloatArray) -> FloatArray:
        """Return the pressure at (..., 3) points of a wetted piece [Pa]."""
        rest = points @ piece.gradient + piece.constant
        if self.dissipation == 0.0:
            return np.asarray(rest)
        return np.asarray(rest * self._damping(piece.normal, points, p, twist))

    def _damping(
        self, normal: FloatArray, points: FloatArray, p: FloatArray, twist: FloatArray
    ) -> FloatArray:
        """Return the factor of the pressure that the rate of overlap makes, linear in (..., 3) points."""
        leaving = normal @ twist[:3] + (points - p) @ np.cross(normal, twist[3:])
        return np.asarray(1.0 - self.dissipation * leaving)

    def _integrated(self, pieces: list[Wetted], p: FloatArray, twist: FloatArray) -> PressurePatch:
        """Integrate pressure and friction over the wetted pieces."""
        normal, first, area = np.zeros(3), np.zeros(3), 0.0
        total, moment = 0.0, np.zeros(3)  # moments are about p
        corners = []
        for piece in pieces:
            points, weights = nodes(piece.corners)
            load = weights * self._pressure(piece, points, p, twist)
            push, mean = float(load.sum()), load @ points
            total, first, area = total + push, first + mean, area + float(weights.sum())
            normal += push * piece.normal
            moment += np.cross(mean - push * p, piece.normal)
            corners.append(self._pressure(piece, piece.corners, p, twist))
        polygons = [piece.corners for piece in pieces]
        if not total > FAINT:
            nothing = np.zeros(3)
            return PressurePatch(
                nothing, nothing, 0.0, np.full(3, np.nan), area, 0.0, nothing, 0.0, 0.0, polygons, corners
            )
        centre, up = first / total, normal / np.linalg.norm(normal)
        drag, turning = self._friction(pieces, p, twist, self.friction)
        turn = np.concatenate([np.cross(up, p - centre), up])  # about the centre, the velocity that of p
        spun, resisted = self._friction(pieces, p, turn, ExactFriction(self.friction.mu), pressing=twist)
        lever = centre - p
        about = moment + turning - np.cross(lever, normal + drag)
        return PressurePatch(
            normal + drag, about, total, centre, area, max(float(c.max()) for c in corners), drag,
            float((turning - np.cross(lever, drag)) @ up),
            abs(float((resisted - np.cross(lever, spun)) @ up)), polygons, corners,
        )  # fmt: skip

    def _friction(
        self,
        pieces: list[Wetted],
        p: FloatArray,
        twist: FloatArray,
        friction: Friction,
        pressing: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return friction's force and its moment about p (3,) for a body that slides with `twist`.

        `pressing` is the twist that makes the pressure, where it is another.
        """
        force, moment = np.zeros(3), np.zeros(3)
        if not twist.any() or friction.mu == 0.0:
            return force, moment
        for piece in pieces:
            points, weights = _sliding_nodes(piece, p, twist)
            load = weights * self._pressure(piece, points, p, twist if pressing is None else pressing)
            velocity = twist[:3] + np.cross(twist[3:], points - p)
            sliding = velocity - (velocity @ piece.normal)[:, None] * piece.normal
            axes = np.linalg.svd(piece.normal[None])[2][1:]  # two tangents
            pull = load[:, None] * (friction.ratio(sliding @ axes.T) @ axes)
            force += pull.sum(axis=0)
            moment += np.cross(points - p, pull).sum(axis=0)
        return force, moment


def _sliding_nodes(piece: Wetted, p: FloatArray, twist: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and weights (n,) that integrate friction over a piece that slides and turns."""
    spin = float(twist[3:] @ piece.normal)
    middle = piece.corners.mean(axis=0)
    velocity = twist[:3] + np.cross(twist[3:], middle - p)
    velocity = velocity - (velocity @ piece.normal) * piece.normal
    size = float(np.linalg.norm(piece.corners - middle, axis=1).max())
    if abs(spin) * size * FAR <= float(np.linalg.norm(velocity)):
        return nodes(piece.corners)
    centre = middle + np.cross(piece.normal, velocity) / spin
    return nodes_about(centre, piece.corners, piece.normal)
