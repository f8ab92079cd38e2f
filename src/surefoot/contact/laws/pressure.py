"""Pressure-field (hydroelastic) contact of a compliant sole at rest on flat ground.

The ground cuts the sole, and each point of the cut has a pressure that rises towards the sole's inside; it is
linear over the polygon that is cut, and integrated exactly.

R. Elandt, E. Drumwright, M. Sherman, A. Ruina, "A pressure field model for fast, robust approximation of net
contact force and moment between nominally rigid objects", IROS 2019; Drake's hydroelastic contact of a
compliant body with a rigid one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError

__all__ = ["CompliantSolid", "PressureField", "PressurePatch"]

FAINT = 1e-140
"""Force below which there is no contact [N]: a centre of pressure would be a quotient of nothings."""
_A, _B = 0.445948490915965, 0.091576213509771
_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
_PLACES = np.array([[1.0 - 2.0 * s if i == j else s for j in range(3)] for s in (_A, _B) for i in range(3)])
"""Dunavant's rule of degree 4 on a triangle: exact for a linear pressure and its first moments."""


@dataclass(frozen=True, eq=False)
class CompliantSolid:
    """A convex sole in its own axes, {x: normals @ x <= offsets}, pressed through its first face.

    The other faces only bound it: sides that are glued to a foot.

    Attributes
    ----------
    normals
        (m, 3) unit normals, outwards.
    offsets
        (m,) [m].
    corners
        (k, 3) [m], for its extent.
    """

    normals: FloatArray
    offsets: FloatArray
    corners: FloatArray

    @classmethod
    def sole(cls, outline: ArrayLike, thickness: float, height: float = 0.0) -> CompliantSolid:
        """Return a sole, pressed from below.

        Parameters
        ----------
        outline
            (k, 2) points whose convex hull is the outline, in the foot's axes [m].
        thickness
            Of the compliant layer [m].
        height
            z of the underside in the foot's axes [m].

        Raises
        ------
        ProblemError
            If the points span no area.
        """
        from scipy.spatial import ConvexHull, QhullError

        points = finite_array("outline", outline, (None, 2))
        thick = real_number("thickness", thickness, low=1e-9, high=1e6)
        low = real_number("height", height, low=-1e6, high=1e6)
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError) as error:
            raise ProblemError(f"outline must span an area, got {len(points)} points that do not") from error
        sides = np.unique(hull.equations.round(14), axis=0)
        normals = np.vstack([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], np.pad(sides[:, :2], ((0, 0), (0, 1)))])
        offsets = np.concatenate([[-low, low + thick], -sides[:, 2]])
        rim = points[hull.vertices]
        corners = np.vstack([np.column_stack([rim, np.full(len(rim), z)]) for z in (low, low + thick)])
        return cls(normals, offsets, corners)


class PressurePatch(NamedTuple):
    """The contact of a sole with the ground.

    Attributes
    ----------
    normal_force
        Pressure integrated over the area [N].
    centre
        (3,) centre of pressure [m], world axes; NaN without contact.
    area
        Wetted [m²].
    largest
        Largest pressure [Pa].
    spin_limit
        Largest torque about the vertical through the centre that friction gives to a sole that only turns
        there [N m].
    polygon, pressures
        The wetted polygon (k, 3) [m] and the pressures at its corners (k,) [Pa].
    """

    normal_force: float
    centre: FloatArray
    area: float
    largest: float
    spin_limit: float
    polygon: FloatArray
    pressures: FloatArray


@dataclass(frozen=True)
class PressureField:
    """p = modulus depth / thickness, depth from the sole's underside.

    Parameters
    ----------
    modulus
        Pressure at a depth of one thickness [Pa].
    thickness
        Of the compliant layer [m].
    friction
        Coefficient [-].

    Examples
    --------
    >>> sole = CompliantSolid.sole([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]], thickness=0.01)
    >>> patch = PressureField(1e6, 0.01).contact(sole, np.eye(3), [0.0, 0.0, -1e-4])
    >>> round(patch.normal_force, 9), round(patch.area, 9)
    (200.0, 0.02)
    """

    modulus: float
    thickness: float
    friction: float = 0.6

    def __post_init__(self) -> None:
        real_number("modulus", self.modulus, low=np.finfo(float).tiny, high=1e300)
        real_number("thickness", self.thickness, low=1e-9, high=1e6)
        real_number("friction", self.friction, low=0.0, high=1e12)

    def contact(self, solid: CompliantSolid, rotation: ArrayLike, position: ArrayLike) -> PressurePatch:
        """Return what the ground z = 0 does to a sole at rest.

        Parameters
        ----------
        solid
            The sole.
        rotation, position
            rotation_world_body (3, 3) and its origin (3,) [m].

        Raises
        ------
        ProblemError
            For input that is not finite, or a rotation that is none.
        """
        R, p = finite_array("rotation", rotation, (3, 3)), finite_array("position", position, (3,))
        if not (np.abs(R @ R.T - np.eye(3)).max() < 1e-6 and np.linalg.det(R) > 0.0):
            raise ProblemError("rotation must be a rotation matrix")
        axes, offsets = solid.normals @ R.T, solid.offsets + solid.normals @ (R.T @ p)
        wetted = _square_below(solid.corners @ R.T + p)
        # Sutherland and Hodgman: the ground's square cut by one face of the sole after another
        for axis, offset in zip(axes, offsets, strict=True):
            wetted = _clip(wetted, offset - wetted @ axis)

        def pressure(points: FloatArray) -> FloatArray:
            return np.asarray(self.modulus / self.thickness * (offsets[0] - points @ axes[0]))

        points, weights = _nodes(wetted)
        load = weights * pressure(points)
        total, area, own = float(load.sum()), float(weights.sum()), pressure(wetted)
        if not total > FAINT:
            return PressurePatch(0.0, np.full(3, np.nan), area, 0.0, 0.0, wetted, own)
        centre = load @ points / total
        points, weights = _nodes_about(centre, wetted)
        arms = np.linalg.norm(points - centre, axis=1)
        spin = self.friction * float(weights * pressure(points) @ arms)
        return PressurePatch(total, centre, area, float(own.max()), spin, wetted, own)

    def rest(
        self, solid: CompliantSolid, load: float, centre: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray, PressurePatch]:
        """Return rotation_world_body (3, 3), position (3,) [m] and the patch of a sole at rest on z = 0.

        Parameters
        ----------
        solid
            The sole.
        load
            Normal force [N], > 0.
        centre
            (2,) where the load acts, in the sole's x and y [m]; None for the middle of its underside.

        Raises
        ------
        ProblemError
            If the load lies outside the underside, so near its edge that the overlap would exceed the sole,
            or is more than it can carry.
        """
        from scipy.optimize import root

        weight = real_number("load", load, low=np.finfo(float).tiny, high=1e300)
        low = solid.corners[:, 2].min()
        rim = solid.corners[solid.corners[:, 2] <= low + 1e-12 + 1e-9 * np.ptp(solid.corners[:, 2])]
        middle, size = rim[:, :2].mean(axis=0), float(np.ptp(rim[:, :2], axis=0).max())
        wanted = middle if centre is None else finite_array("centre", centre, (2,))
        if not (solid.offsets - solid.normals @ [*wanted, low] >= -1e-12).all():
            raise ProblemError(f"centre {wanted.tolist()} lies outside the underside")
        scale = weight * self.thickness / (self.modulus * np.prod(np.ptp(rim[:, :2], axis=0)))

        def laid(x: FloatArray) -> tuple[FloatArray, FloatArray, PressurePatch]:
            """Return the pose with the ground at z = low + x0 + x1 (x - x_m) + x2 (y - y_m) for the sole."""
            depth, tilt = scale * x[0], scale / size * x[1:]
            R = _levelling(np.array([-tilt[0], -tilt[1], 1.0]))
            position = np.array([0.0, 0.0, -(R @ [*middle, low + depth])[2]])
            return R, position, self.contact(solid, R, position)

        def off(x: FloatArray) -> FloatArray:
            """Return what force and centre are off, in units of the load and the size; no force: -1, 0, 0."""
            R, position, patch = laid(x)
            share = patch.normal_force / weight
            place = (R.T @ (patch.centre - position))[:2] - wanted if share > 0.0 else np.zeros(2)
            return np.array([share - 1.0, *(share * place / size)])

        found = root(off, [1.0, 0.0, 0.0], tol=1e-14)
        if not np.abs(found.fun).max() < 1e-9:
            raise ProblemError(
                f"no pose carries {weight:g} N at {wanted.tolist()}: it is too near the edge, or too much"
            )
        return laid(found.x)


def _square_below(points: FloatArray) -> FloatArray:
    """Return corners (4, 3) of a square of the ground, counter-clockwise from above, beyond (k, 3) points."""
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    reach = np.linalg.norm(high - low) + np.abs(points[:, 2]).max() + 1e-9
    square = 0.5 * (low + high) + reach * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.pad(square, ((0, 0), (0, 1)))


def _levelling(normal: FloatArray) -> FloatArray:
    """Return the least rotation that takes a direction (3,) with z > 0 to z."""
    n = normal / np.linalg.norm(normal)
    # Rodrigues' formula from n to z, 1 + n_z > 0 since n points up
    K = np.array([[0.0, 0.0, -n[0]], [0.0, 0.0, -n[1]], [n[0], n[1], 0.0]])  # of n x z
    turned: FloatArray = np.eye(3) + K + K @ K / (1.0 + n[2])
    return turned


def _clip(polygon: FloatArray, values: FloatArray) -> FloatArray:
    """Return the part of a polygon (k, 3) where a linear function, `values` (k,) at its corners, is >= 0."""
    if (values >= 0.0).all():
        return polygon
    if (values < 0.0).all():
        return polygon[:0]
    out = []
    for a, b, x, y in zip(polygon, np.roll(polygon, -1, 0), values, np.roll(values, -1), strict=True):
        if x >= 0.0:
            out.append(a)
        if (x >= 0.0) != (y >= 0.0):
            out.append(a + x / (x - y) * (b - a))
    return np.array(out) if len(out) >= 3 else polygon[:0]


def _nodes(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and weights (n,) [m²] that integrate over a convex polygon (k, 3)."""
    if not len(polygon):
        return np.zeros((0, 3)), np.zeros(0)
    triangles = np.stack([np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1], polygon[2:]], axis=1)
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=-1)
    points = np.einsum("nj,tjd->tnd", _PLACES, triangles)
    return points.reshape(-1, 3), (areas[:, None] * _WEIGHTS).ravel()


def _nodes_about(centre: FloatArray, polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 3) and signed weights (n,) that integrate what turns about a point over a polygon.

    The polygon is level, the signed sum of the triangles that its edges make with the centre; on rays from
    there a direction of sliding is constant, and Gauss's rule exact; edges are cut below the centre, where
    the direction turns fastest.
    """
    starts, ends = polygon, np.roll(polygon, -1, 0)
    edges = ends - starts
    squares = np.maximum((edges * edges).sum(-1), 1e-300)
    foot = np.clip(((centre - starts) * edges).sum(-1) / squares, 0.0, 1.0)[:, None]
    middle = starts + foot * edges
    starts, ends = np.concatenate([starts, middle]), np.concatenate([middle, ends])
    t, wt = np.polynomial.legendre.leggauss(24)
    s, ws = np.polynomial.legendre.leggauss(8)
    t, wt, s, ws = 0.5 * (t + 1.0), 0.5 * wt, 0.5 * (s + 1.0), 0.5 * ws
    # t^3 draws the points to the foot of the perpendicular, at the start of every second half
    first = np.arange(len(starts)) < len(polygon)
    near, slope = t**3, 3.0 * t**2 * wt
    share = np.where(first[:, None], 1.0 - near, near)
    rim = starts[:, None] + share[..., None] * (ends - starts)[:, None]
    double = np.cross(starts - centre, ends - centre)[:, 2]
    points = centre + s[:, None] * (rim[:, :, None] - centre)
    weights = double[:, None, None] * slope[None, :, None] * (s * ws)
    return points.reshape(-1, 3), weights.ravel()
