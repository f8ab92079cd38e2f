"""Linear bounds on contact forces beside the cones, and the equations that hold them all.

Normal bounds of contacts and torque limits of joints are the same thing: rows @ forces <= bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, of_kind
from surefoot.contact import Fit, FrictionPyramid
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.point_contacts import axis_scale, load_scale, spread
from surefoot.mechanics.statics.row_blocks import IN_ONE, find_blocks

_IRRELEVANT = 1e7


@dataclass(frozen=True)
class ForceLimits:
    """Linear bounds rows @ forces <= bound on the stacked contact forces of a stance.

    Attributes
    ----------
    rows
        (l, stance.dim), over forces and soles' wrenches in contact frames [unit of bound per N, N m].
    bound
        (l,), finite [N, N m, or what the rows make of forces].
    names
        One per row, for messages.
    """

    rows: FloatArray
    bound: FloatArray
    names: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.bound)

    def and_also(self, other: ForceLimits) -> ForceLimits:
        """Return both sets of bounds as one."""
        rows, bound = np.vstack([self.rows, other.rows]), np.concatenate([self.bound, other.bound])
        return ForceLimits(rows, bound, self.names + other.names)


@dataclass(eq=False, slots=True)
class Question:
    """What a stance is asked: whether it can give a load, and with which forces.

    Attributes
    ----------
    stance
        Contacts.
    com
        (3,) point that moments refer to, the centre of mass in most questions, world axes [m].
    load
        (6,) [force; moment about the point] that the contacts have to give, world axes [N, N m].
    limits
        All bounds on the forces beside their cones, those on normal forces included; None without any.
    facets, fit
        None for exact cones; else the sides of pyramids, "inner" or "outer".
    """

    stance: Stance
    com: FloatArray
    load: FloatArray
    limits: ForceLimits | None = None
    facets: int | None = None
    fit: Fit = "inner"


def all_limits(*parts: ForceLimits | None) -> ForceLimits | None:
    """Return all the bounds given as one set, None where there are none."""
    given = [part for part in parts if part is not None]
    for part in given:
        of_kind("limits", part, ForceLimits)
    return reduce(ForceLimits.and_also, given) if given else None


def _normals(stance: Stance) -> FloatArray:
    """Return (n, dim) rows that pick each contact's normal force out of the stacked forces."""
    return np.eye(stance.dim)[[part.start + 2 for part in stance.slices]]


def normal_limits(stance: Stance) -> ForceLimits | None:
    """Return the bounds on the normal forces of a stance as rows, or None where there are none."""
    if not stance.bounded:
        return None
    found = []
    for contact, normal in zip(stance.contacts, _normals(stance), strict=True):
        if contact.normal_min > 0.0:
            found.append((-normal, -contact.normal_min, f"{contact.name} normal_min"))
        if contact.normal_max < math.inf:
            found.append((normal, contact.normal_max, f"{contact.name} normal_max"))
    rows, bound, names = zip(*found, strict=True)
    return ForceLimits(np.array(rows), np.array(bound), names)


def squeeze_limit(stance: Stance, most: float) -> ForceLimits:
    """Return one bound on the sum of all normal forces [N]."""
    total = _normals(stance).sum(axis=0, keepdims=True)
    return ForceLimits(total, np.array([most]), ("total normal force",))


@dataclass(frozen=True)
class Equations:
    """A stance's question in the solver's coordinates: A x = w, x in Lorentz cones and half-lines.

    Attributes
    ----------
    A, e, w
        (p, m), (m,), (p,): the first six rows are the wrench, one more per bound; scaled.
    lorentz
        Number of 3-D cones at the front of x.
    force
        (3 k, m): corner forces [N] = force @ x.
    scale, length, row_scale
        Force [N] and length [m] that were divided out, and the size of each bound's row.
    kept
        Which bounds take part, in the order of the rows; one that is ten million loads away does not.
    blocks
        (g, 6): rows of A that are alone with their columns (`row_blocks`); None without any.
    """

    A: FloatArray
    e: FloatArray
    w: FloatArray
    lorentz: int
    force: FloatArray
    scale: float
    length: float
    row_scale: FloatArray
    kept: IntArray
    blocks: IntArray | None

    def wrench_multiplier(self, y: FloatArray) -> FloatArray:
        """Return the (6,) wrench multiplier of scaled multipliers, so that y.load is in newtons [-, 1/m]."""
        out = y[:6].copy()
        out[3:] /= self.length
        return out

    def limit_multipliers(self, y: FloatArray, count: int) -> FloatArray:
        """Return the (count,) multipliers of the bounds [-], zero for those left out."""
        out = np.zeros(count)
        out[self.kept] = np.maximum(y[6:], 0.0) / self.row_scale
        return out


def corner_basis(mu: FloatArray, facets: int | None, fit: Fit) -> tuple[FloatArray, FloatArray]:
    """Return the map from cone coordinates to corner forces, and the axis of the cones in them.

    Exact cones have three coordinates each, (f_z, f_x / mu, f_y / mu); pyramids one per ray.
    """
    count = 3 if facets is None else FrictionPyramid(1.0, facets).facets  # checked
    force, e = np.zeros((3 * len(mu), count * len(mu))), np.zeros(count * len(mu))
    for k, m in enumerate(mu):
        rows, columns = slice(3 * k, 3 * k + 3), slice(count * k, count * (k + 1))
        if facets is None:
            force[rows, columns] = [[0.0, m, 0.0], [0.0, 0.0, m], [1.0, 0.0, 0.0]]
            e[count * k] = axis_scale(m)
        else:
            pyramid = FrictionPyramid(float(m), count, fit)
            face = m * np.cos(np.pi / count) if fit == "inner" else m
            force[rows, columns] = pyramid.rays.T
            e[columns] = axis_scale(face) / count
    return force, e


def equations(question: Question) -> Equations:
    """Set up A x = w for a stance with bounds and, if asked, pyramids for cones.

    Contacts that are off (normal_max = 0) have no columns, so that nothing has to have a margin to them.
    """
    stance, limits = question.stance, question.limits
    points = stance.points()
    on = points.normal_max > 0.0
    whole, axis = corner_basis(points.mu, question.facets, question.fit)
    unit = len(axis) // max(1, len(points))
    off = not on.all()
    columns = np.repeat(on, unit) if off else slice(None)
    force, axis = whole[:, columns], axis[columns]
    length = spread(points.positions, question.com)
    scale = load_scale(question.load, length)
    A = points.grasp_map(question.com) @ force
    A[3:] /= length
    w = question.load / scale
    w[3:] /= length
    lorentz = int(on.sum()) if question.facets is None else 0
    kept: IntArray = np.zeros(0, dtype=np.int64)
    blocks: IntArray | None = IN_ONE
    row_scale = np.zeros(0)
    if limits is not None and len(limits):
        size = np.linalg.norm(limits.rows, axis=1)
        kept = np.flatnonzero((limits.bound < _IRRELEVANT * scale * size) | (size == 0.0))
        by_corner = limits.rows[kept] if stance.points() is stance else limits.rows[kept] @ stance.corner_map
        rows = _times_cones(by_corner, whole, len(points))[:, columns]
        if off:  # what bounds their forces says nothing
            # 0 <= bound is nothing to ask; 0 <= a negative bound is a contradiction, which has to be found.
            says = rows.any(axis=1) | (limits.bound[kept] < 0.0)
            kept, rows = kept[says], rows[says]
        order, groups = find_blocks(rows, unit)
        kept, rows = kept[order], rows[order]
        size = np.where(size > 0.0, size, 1.0)[kept]
        # rows f + slack = bound, slack >= 0: a half-line each. Its axis makes the margin of a bound a
        # distance of the forces from it, as it is one from the cones.
        distance = limits.bound[kept] / (size * scale)  # of the bound from zero force, in loads
        reach = np.maximum(1.0, np.abs(distance))  # slacks are counted in it, to be of size one
        row_scale = size * reach
        count = len(row_scale)
        blocks = groups + np.array([6, 6, 0, 0, len(axis), len(axis)]) if len(groups) else IN_ONE
        A = np.block([[A, np.zeros((6, count))], [rows / row_scale[:, None], np.eye(count)]])
        w = np.concatenate([w, distance / reach])
        axis = np.concatenate([axis, 1.0 / reach])
        force = np.hstack([force, np.zeros((len(force), count))])
    return Equations(
        np.ascontiguousarray(A), axis, w, lorentz, force * scale, scale, length, row_scale, kept, blocks
    )


def _times_cones(rows: FloatArray, force: FloatArray, corners: int) -> FloatArray:
    """Return rows (l, 3 k) @ force (3 k, m), corner by corner: `force` is blocks of three rows."""
    each = np.arange(corners)
    cones = force.reshape(corners, 3, corners, -1)[each, :, each]  # (k, 3, m / k)
    product: FloatArray = np.einsum("lki,kij->lkj", rows.reshape(-1, corners, 3), cones)
    return product.reshape(len(rows), corners * cones.shape[2])
