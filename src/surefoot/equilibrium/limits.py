"""Linear bounds on contact forces beside the cones, and the equations that hold them all.

Normal bounds of contacts and torque limits of joints are the same thing: rows @ forces <= bound.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.cones import FrictionPyramid
from surefoot.equilibrium.margin import axis_scale, load_scale, spread
from surefoot.stance import Stance

_IRRELEVANT = 1e7


@dataclass(frozen=True)
class ForceLimits:
    """Linear bounds rows @ forces <= bound on the stacked contact forces of a stance.

    Attributes
    ----------
    rows
        (l, stance.dim), over forces and patch wrenches in contact frames.
    bound
        (l,), finite.
    names
        One per row, for messages.
    """

    rows: FloatArray
    bound: FloatArray
    names: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.bound)

    def and_also(self, other: ForceLimits | None) -> ForceLimits:
        """Return both sets of bounds as one."""
        if other is None:
            return self
        return ForceLimits(
            np.vstack([self.rows, other.rows]),
            np.concatenate([self.bound, other.bound]),
            self.names + other.names,
        )


def normal_limits(stance: Stance) -> ForceLimits | None:
    """Return the bounds on the normal forces of a stance as rows, or None where there are none."""
    rows, bound, names = [], [], []
    for contact, part in zip(stance.contacts, stance.slices, strict=True):
        row = np.zeros(stance.dim)
        row[part.start + 2] = 1.0
        if contact.normal_min > 0.0:
            rows.append(-row)
            bound.append(-contact.normal_min)
            names.append(f"{contact.name} normal_min")
        if contact.normal_max < np.inf:
            rows.append(row)
            bound.append(contact.normal_max)
            names.append(f"{contact.name} normal_max")
    if not rows:
        return None
    return ForceLimits(np.array(rows), np.array(bound), tuple(names))


def squeeze_limit(stance: Stance, most: float) -> ForceLimits:
    """Return one bound on the sum of all normal forces [N]."""
    row = np.zeros((1, stance.dim))
    for part in stance.slices:
        row[0, part.start + 2] = 1.0
    return ForceLimits(row, np.array([most]), ("total normal force",))


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
        Which bounds take part; one that is ten million loads away does not.
    """

    A: FloatArray
    e: FloatArray
    w: FloatArray
    lorentz: int
    force: FloatArray
    scale: float
    length: float
    row_scale: FloatArray
    kept: BoolArray

    def wrench_multiplier(self, y: FloatArray) -> FloatArray:
        """Return the (6,) wrench multiplier of scaled multipliers, so that y.load is in newtons."""
        out = y[:6].copy()
        out[3:] /= self.length
        return out

    def limit_multipliers(self, y: FloatArray, count: int) -> FloatArray:
        """Return the (count,) multipliers of the bounds, zero for those left out."""
        out = np.zeros(count)
        out[self.kept] = np.maximum(y[6:], 0.0) / self.row_scale
        return out


def corner_basis(
    mu: FloatArray, facets: int | None, fit: Literal["inner", "outer"]
) -> tuple[FloatArray, FloatArray]:
    """Return the map from cone coordinates to corner forces, and the axis of the cones in them.

    Exact cones have three coordinates each, (f_z, f_x / mu, f_y / mu); pyramids one per ray.
    """
    count = 3 if facets is None else facets
    force, e = np.zeros((3 * len(mu), count * len(mu))), np.zeros(count * len(mu))
    for k, m in enumerate(mu):
        rows, columns = slice(3 * k, 3 * k + 3), slice(count * k, count * (k + 1))
        if facets is None:
            force[rows, columns] = [[0.0, m, 0.0], [0.0, 0.0, m], [1.0, 0.0, 0.0]]
            e[count * k] = axis_scale(m)
        else:
            pyramid = FrictionPyramid(float(m), facets, fit)
            face = m * np.cos(np.pi / facets) if fit == "inner" else m
            force[rows, columns] = pyramid.rays.T
            e[columns] = axis_scale(face) / facets
    return force, e


def equations(
    stance: Stance,
    com: FloatArray,
    load: FloatArray,
    limits: ForceLimits | None,
    facets: int | None = None,
    fit: Literal["inner", "outer"] = "inner",
) -> Equations:
    """Set up A x = w for a stance with bounds and, if asked, pyramids for cones."""
    points = stance.points()
    force, axis = corner_basis(points.mu, facets, fit)
    length = spread(points.positions, com)
    scale = load_scale(load, length)
    wrench = points.grasp_map(com) @ force
    wrench[3:] /= length
    w = load / scale
    w[3:] /= length
    lorentz = len(points) if facets is None else 0
    kept: BoolArray = np.zeros(0, dtype=np.bool_)
    row_scale = np.zeros(0)
    if limits is not None and len(limits):
        size = np.linalg.norm(limits.rows, axis=1)
        kept = (limits.bound < _IRRELEVANT * scale * size) | (size == 0.0)
        size = np.where(size > 0.0, size, 1.0)[kept]
        distance = limits.bound[kept] / (size * scale)  # of the bound from zero force, in loads
        reach = np.maximum(1.0, np.abs(distance))  # slacks are counted in it, to be of size one
        row_scale = size * reach
        rows = (limits.rows[kept] @ stance.corner_map @ force) / row_scale[:, None]
        count = len(row_scale)
        A = np.block([[wrench, np.zeros((6, count))], [rows, np.eye(count)]])
        w = np.concatenate([w, distance / reach])
        axis = np.concatenate([axis, 1.0 / reach])
        force = np.hstack([force, np.zeros((len(force), count))])
    else:
        A = wrench
    return Equations(np.ascontiguousarray(A), axis, w, lorentz, force * scale, scale, length, row_scale, kept)
