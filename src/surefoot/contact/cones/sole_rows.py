"""A sole's cone as half-spaces with names: the sum of its corners' pyramids, and Caron's closed form.

A row is a motion of the sole, a twist that no corner force of the pyramids feeds: turning about an edge,
sliding, or turning about a vertical axis somewhere, also while tipping.

S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of Surface Contacts for Humanoid Robots: Closed-Form
Formulae of the Contact Wrench Cone for Rectangular Support Areas", ICRA 2015.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.cones.cone import Fit
from surefoot.contact.cones.polyhedral import FrictionPyramid, PolyhedralCone, checked_fit

if TYPE_CHECKING:
    from surefoot.contact.cones.sole import Sole

KEPT = 32
"""Sums of pyramids that are kept, by corners, facets and fit: a robot has one or two soles."""
NOTHING = 1e-9
"""Share of a row's largest entry, moments over the radius, below which an entry is rounding [-]."""
_SIGNS = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])


class SolePolyhedron(PolyhedralCone):
    """A polyhedral cone inside or around a sole's, with a name for each row.

    Attributes
    ----------
    names
        (m,) of the half-spaces: which motion each forbids the ground to feed.
    fit, facets
        Which side of the exact cone it is on, and the sides of each corner's pyramid.
    fit_error
        `FitError`: the exact cone with friction less by `radial` lies in an inner one, and with friction more
        by `radial` holds an outer one; pure sliding attains it. `area` is that of the pyramids' sections.
    """

    def __init__(
        self, halfspaces: FloatArray, rays: FloatArray, names: tuple[str, ...], pyramid: FrictionPyramid
    ) -> None:
        super().__init__(halfspaces, rays)
        self.names = names
        self.fit, self.facets, self.fit_error = pyramid.fit, pyramid.facets, pyramid.fit_error

    def __repr__(self) -> str:
        given = "gives up" if self.fit == "inner" else "oversteps by"
        return (
            f"SolePolyhedron({len(self.halfspaces)} rows, {len(self.rays)} rays, {self.fit}, {given} up to "
            f"{100.0 * self.fit_error.radial:.2g} % of the friction)"
        )


def corner_pyramids(sole: Sole, facets: int, fit: Fit) -> SolePolyhedron:
    """Return the sum of the corners' pyramids; see `Sole.polyhedral`."""
    _without_pads(sole)
    pyramid = FrictionPyramid(sole.mu, facets, fit)
    halfspaces, names = scaled_rows(sole, pyramid.facets, pyramid.fit)
    return SolePolyhedron(halfspaces, _rays_of(sole.corners, pyramid), names, pyramid)


def scaled_rows(sole: Sole, facets: int, fit: Fit) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the rows (m, 6) of a sole's pyramids and their names.

    Friction scales (f_x, f_y, m_z), so that the rows of mu = 1 serve for every mu, in the same number: those
    of mu = 0 hold the three at zero.
    """
    shared, names = _rows_of_one(np.ascontiguousarray(sole.corners).tobytes(), facets, fit)
    rows = shared.copy()
    turns = np.abs(rows[:, [0, 1, 5]]).max(axis=1) > 0.0
    # d . f_t / mu + w m_z / mu + eta . (f_z, m_x, m_y) <= 0, times mu
    rows[np.ix_(turns, [2, 3, 4])] *= sole.mu
    return rows, names


@lru_cache(maxsize=KEPT)
def _rows_of_one(corners: bytes, facets: int, fit: Fit) -> tuple[FloatArray, tuple[str, ...]]:
    """Return rows and names for corners (k, 2) with a friction coefficient of one."""
    from surefoot.contact.cones.sole import Sole

    places = np.frombuffer(corners).reshape(-1, 2)
    sole = Sole.of_corners(places, mu=1.0)
    shift = places.mean(axis=0)
    # about the centre and over the radius, where all entries are of one size
    rays = _rays_of((places - shift) / sole.radius, FrictionPyramid(1.0, facets, fit))
    rows = PolyhedralCone.from_rays(rays).halfspaces
    rows[np.abs(rows) < NOTHING * np.abs(rows).max(axis=1, keepdims=True)] = 0.0
    rows /= np.linalg.norm(rows[:, :3], axis=1)[:, None]
    rows = rows[np.lexsort(np.round(rows.T, 9)[::-1])]
    names = _names(rows, sole)
    rows[:, 3:] /= sole.radius
    # moments about the frame's origin: m - c x f
    x, y = shift
    about = rows.copy()
    about[:, 0] += rows[:, 5] * y
    about[:, 1] -= rows[:, 5] * x
    about[:, 2] += rows[:, 4] * x - rows[:, 3] * y
    about.setflags(write=False)
    return about, names


def _names(rows: FloatArray, sole: Sole) -> tuple[str, ...]:
    """Return what the sole does when a row (m, 6), about the centre and over the radius, gives way."""
    normals, edges = _outward(sole.corners), sole.edge_names
    return tuple(_name(row, normals, edges, sole) for row in rows)


def _outward(corners: FloatArray) -> FloatArray:
    """Return the outward normals (k, 2) of the edges of corners in clockwise order."""
    along = np.roll(corners, -1, axis=0) - corners
    return np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(along[:, 0], along[:, 1])[:, None]


def _name(row: FloatArray, normals: FloatArray, edges: tuple[str, ...], sole: Sole) -> str:
    """Return the name of one row: friction at its limit opposes the motion, and pressure is at the edge.

    Points p of the sole slide along -(d + turn z x p), d = row_x, row_y; pressure is at (-m_y, m_x) / f_z.
    """
    slide, tip, turn = row[:2], np.array([-row[4], row[3]]), row[5] / sole.radius
    tips = f"tips over the {edges[int(np.argmax(normals @ tip))]}" if tip.any() else ""
    if turn == 0.0 and not slide.any():
        return tips or "lifts off"
    if turn == 0.0:
        motion = f"slides {_way(-slide)}"
    else:
        x, y = sole.centre + np.array([-slide[1], slide[0]]) / turn
        motion = f"yaws {'right' if turn > 0.0 else 'left'} about ({x:.3f}, {y:.3f}) m"
    return f"{motion} and {tips}" if tips else motion


def _way(slide: FloatArray) -> str:
    """Return a direction in the sole's plane: an axis, or the angle from x."""
    for axis, name in ((0, "x"), (1, "y")):
        if abs(slide[1 - axis]) <= NOTHING * abs(slide[axis]):
            return f"{'+' if slide[axis] > 0.0 else '-'}{name}"
    return f"{math.degrees(math.atan2(slide[1], slide[0])):+.3g}°"


def _rays_of(corners: FloatArray, pyramid: FrictionPyramid) -> FloatArray:
    """Return the (k facets, 6) wrenches of a unit normal force on each edge of each corner's pyramid."""
    rays = pyramid.rays if pyramid.mu > 0.0 else pyramid.rays[:1]
    out = []
    for x, y in corners:
        out.append(np.column_stack([rays, np.cross([x, y, 0.0], rays)]))
    return np.vstack(out)


def caron_rows(sole: Sole, fit: Fit) -> SolePolyhedron:
    """Return the sixteen rows of a rectangle in closed form; see `Sole.closed_form`."""
    _without_pads(sole)
    if sole.length is None or sole.width is None:
        raise ProblemError("the closed form is of a rectangle, Sole(length, width); take Sole.polyhedral")
    checked_fit(fit)
    X, Y = 0.5 * sole.length, 0.5 * sole.width
    m = sole.mu / math.sqrt(2.0) if fit == "inner" else sole.mu
    rows = np.zeros((8, 6))
    for k, (axis, limit) in enumerate(((0, m), (1, m), (3, Y), (4, X))):
        rows[2 * k, axis], rows[2 * k + 1, axis] = 1.0, -1.0
        rows[2 * k : 2 * k + 2, 2] = -limit
    # Caron, Pham and Nakamura 2015: |Y f_x - m τ_x| + |X f_y - m τ_y| - m (X + Y) f_z <= τ_z, one row for
    # each pair of signs of the two, and its mirror image from above
    yaw = [
        [a * Y, b * X, -m * (X + Y), -s * a * m, -s * b * m, -s]
        for s in (1.0, -1.0)  # lower and upper limit of tau_z
        for a, b in _SIGNS
    ]
    every = np.vstack([rows, yaw])
    counted = every * [1.0, 1.0, 1.0, *3 * [1.0 / sole.radius]]
    pyramid = FrictionPyramid(sole.mu, 4, fit, 0.25 * math.pi if fit == "inner" else 0.0)
    return SolePolyhedron(every, _rays_of(sole.corners, pyramid), _names(counted, sole), pyramid)


def _without_pads(sole: Sole) -> None:
    if sole.torsional_radius > 0.0:
        raise ProblemError(
            "polyhedral forms are of soles without a torsional radius: a pad's limit is an ellipsoid"
        )
