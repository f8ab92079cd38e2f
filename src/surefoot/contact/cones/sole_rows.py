"""A sole's cone as half-spaces with names: the sum of its corners' pyramids, and Caron's closed form.

A row is a motion of the sole, a twist that no corner force of the pyramids feeds: turning about an edge,
sliding, or turning about a vertical axis somewhere, also while tipping.

S. Caron, Q.-C. Pham, Y. Nakamura, "Stability of Surface Contacts for Humanoid Robots: Closed-Form
Formulae of the Contact Wrench Cone for Rectangular Support Areas", ICRA 2015.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.contact.cones.cone import Fit
from surefoot.contact.cones.polyhedral import FrictionPyramid, PolyhedralCone, checked_fit
from surefoot.contact.cones.sole_shape import edge_names, middle_of, outward

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


def corner_pyramids(corners: FloatArray, mu: float, facets: int, fit: Fit) -> SolePolyhedron:
    """Return the sum of the pyramids at corners (k, 2) [m]; see `Sole.polyhedral`."""
    pyramid = FrictionPyramid(mu, facets, fit)
    rows, turns, names = _rows_of_one(_key(corners), pyramid.facets, pyramid.fit)
    halfspaces = rows.copy()
    halfspaces[turns, 2:5] *= mu
    return SolePolyhedron(halfspaces, _rays_of(corners, pyramid), names, pyramid)


def unit_rows(corners: FloatArray, facets: int, fit: Fit) -> tuple[FloatArray, BoolArray]:
    """Return the rows (m, 6) of a sole's pyramids with friction one, and those that friction scales: (m,).

    Friction scales (f_x, f_y, m_z), so that entries 2, 3, 4 of such rows times mu serve for every mu, in the
    same number: those of mu = 0 hold the three at zero. Not to be written to.
    """
    rows, turns, _ = _rows_of_one(_key(corners), facets, checked_fit(fit))
    return rows, turns


def _key(corners: FloatArray) -> bytes:
    return np.ascontiguousarray(corners).tobytes()


@lru_cache(maxsize=KEPT)
def _rows_of_one(corners: bytes, facets: int, fit: Fit) -> tuple[FloatArray, BoolArray, tuple[str, ...]]:
    """Return rows, which of them friction scales, and names, for corners (k, 2) with friction one."""
    places = np.frombuffer(corners).reshape(-1, 2)
    shift, radius = middle_of(places)
    # about the centre and over the radius, where all entries are of one size
    rays = _rays_of((places - shift) / radius, FrictionPyramid(1.0, facets, fit))
    rows = PolyhedralCone.from_rays(rays).halfspaces
    rows[np.abs(rows) < NOTHING * np.abs(rows).max(axis=1, keepdims=True)] = 0.0
    rows /= np.linalg.norm(rows[:, :3], axis=1)[:, None]
    rows = rows[np.lexsort(np.round(rows.T, 9)[::-1])]
    names = _names(rows, places)
    rows[:, 3:] /= radius
    # moments about the frame's origin: m - c x f
    x, y = shift
    about = rows.copy()
    about[:, 0] += rows[:, 5] * y
    about[:, 1] -= rows[:, 5] * x
    about[:, 2] += rows[:, 4] * x - rows[:, 3] * y
    about.setflags(write=False)
    return about, np.abs(about[:, [0, 1, 5]]).max(axis=1) > 0.0, names


def _names(rows: FloatArray, corners: FloatArray) -> tuple[str, ...]:
    """Return what the sole does when a row (m, 6), about the centre and over the radius, gives way."""
    normals = outward(corners)
    edges, (centre, radius) = edge_names(normals), middle_of(corners)
    return tuple(_name(row, normals, edges, centre, radius) for row in rows)


def _name(
    row: FloatArray, normals: FloatArray, edges: tuple[str, ...], centre: FloatArray, radius: float
) -> str:
    """Return the name of one row: friction at its limit opposes the motion, and pressure is at the edge.

    Points p of the sole slide along -(d + turn z x p), d = row_x, row_y; pressure is at (-m_y, m_x) / f_z.
    """
    slide, tip, turn = row[:2], np.array([-row[4], row[3]]), row[5] / radius
    tips = f"tips over the {edges[int(np.argmax(normals @ tip))]}" if tip.any() else ""
    if turn == 0.0 and not slide.any():
        return tips or "lifts off"
    if turn == 0.0:
        motion = f"slides {_way(-slide)}"
    else:
        x, y = centre + np.array([-slide[1], slide[0]]) / turn
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


def caron_rows(length: float, width: float, mu: float, fit: Fit) -> SolePolyhedron:
    """Return the sixteen rows of a rectangle in closed form; see `Sole.closed_form`."""
    checked_fit(fit)
    X, Y = 0.5 * length, 0.5 * width
    m = mu / math.sqrt(2.0) if fit == "inner" else mu
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
    corners = _SIGNS * [X, Y]
    counted = every * [1.0, 1.0, 1.0, *3 * [1.0 / math.hypot(X, Y)]]
    pyramid = FrictionPyramid(mu, 4, fit, 0.25 * math.pi if fit == "inner" else 0.0)
    return SolePolyhedron(every, _rays_of(corners, pyramid), _names(counted, corners), pyramid)
