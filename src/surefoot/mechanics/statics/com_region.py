"""Where the centre of mass or the zero-moment point may be: polygons with a certified gap."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, positive_number
from surefoot.base.errors import ProblemError
from surefoot.contact import Fit
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.limits import (
    ForceLimits,
    Question,
    all_limits,
    normal_limits,
    squeeze_limit,
)
from surefoot.mechanics.statics.region import Region, convex_hull
from surefoot.mechanics.statics.region_search import RegionOutline, Rows, trace_outline
from surefoot.mechanics.statics.statics import MOST_MU, needed_wrench

SQUEEZE = 10.0
"""Total normal force, as a multiple of the load, where contacts could squeeze without limit."""


def com_region(
    stance: Stance,
    mass: float,
    tol: float = 1e-3,
    acceleration: ArrayLike = (0.0, 0.0, 0.0),
    external_wrench: ArrayLike | float = 0.0,
    height: float | None = None,
    facets: int | None = None,
    fit: Fit = "inner",
    limits: ForceLimits | None = None,
) -> Region:
    """Return where the centre of mass may be so that the contacts can hold the robot.

    Parameters
    ----------
    stance
        Contacts, at any heights and slopes.
    mass
        > 0 [kg].
    tol
        Largest distance between the inner and the outer polygon [m].
    acceleration
        (3,) of the centre of mass, world axes [m/s^2], at constant angular momentum; zero is standing
        still. The region then leans: its axis is that of gravity minus acceleration.
    external_wrench
        (6,) [force; moment about the centre of mass] on the robot besides gravity [N, N m].
    height
        Height of the horizontal plane that the polygon lies in [m]; the mean height of the contacts
        unless given. Without acceleration or side force the polygon is the same at every height.
    facets, fit, limits
        As for `can_stand`.

    Returns
    -------
    Region
        Inner polygon (all of it can be held), outer polygon (nothing beyond it can), and their gap.
        Where contacts can squeeze each other without limit, or carry the weight ever farther out by ever
        larger forces, the total normal force is held to ten times the load, and `Region.force_limit`
        says so.

    Raises
    ------
    ProblemError
        If the load does not push the robot down, or for values that are not numbers.

    Notes
    -----
    T. Bretl, S. Lall, "Testing Static Equilibrium for Legged Robots", IEEE T-RO 2008.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> stance = Stance([PointContact([x, y, 0]) for x in (0.2, -0.2) for y in (0.1, -0.1)])
    >>> region = com_region(stance, mass=15.0)
    >>> round(region.area, 6), region.contains([0.19, 0.09]), region.contains([0.21, 0.0])
    (0.08, True, False)
    """
    step = finite_array("acceleration", acceleration, (3,))
    load = needed_wrench(mass, external_wrench)
    load[:3] += mass * step
    if load[2] <= 1e-9 * float(np.linalg.norm(load[:3])):
        raise ProblemError(
            f"the load must rest on the contacts, got {load[2]:g} N of vertical force to carry"
        )
    anchor = _anchor(stance, height)
    question = Question(stance, anchor, load, limits, facets, fit)
    return _region(question, tol, _com_rows(load, anchor), anchor[2], load[:3] / load[2])


def zmp_region(
    stance: Stance,
    com: ArrayLike,
    mass: float,
    tol: float = 1e-3,
    height: float | None = None,
    facets: int | None = None,
    fit: Fit = "inner",
    limits: ForceLimits | None = None,
) -> Region:
    """Return where the zero-moment point may be, in a horizontal plane under the centre of mass.

    The robot moves as a pendulum of constant height: no vertical acceleration, no change of angular
    momentum, so that the contact force points from the zero-moment point to the centre of mass. The
    region of all contacts then differs from the support polygon wherever contacts are not in one
    plane, or friction is short.

    Parameters
    ----------
    stance, mass, tol, facets, fit, limits
        As for `com_region`.
    com
        (3,) centre of mass, world axes [m].
    height
        Height of the plane [m], the mean height of the contacts unless given; not that of the centre
        of mass.

    Returns
    -------
    Region
        Inner and outer polygon.

    Raises
    ------
    ProblemError
        If the plane goes through the centre of mass.

    Notes
    -----
    The pendular support area of S. Caron, Q.-C. Pham, Y. Nakamura, "ZMP Support Areas for
    Multi-contact Mobility Under Frictional Constraints", IEEE T-RO 2017.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> stance = Stance([PointContact([x, y, 0], mu=1) for x in (0.2, -0.2) for y in (0.1, -0.1)])
    >>> round(zmp_region(stance, com=[0, 0, 0.3], mass=15.0).area, 6)
    0.08
    """
    about = finite_array("com", com, (3,))
    load = needed_wrench(mass)
    anchor = _anchor(stance, height)
    drop = about[2] - anchor[2]
    if abs(drop) < 1e-9 * max(1e-300, abs(about[2]) + abs(anchor[2])):
        raise ProblemError(f"height must differ from the centre of mass's, got {anchor[2]:g} m for both")
    # F_z is the weight and the moment about the centre of mass zero; F_x and F_y are free. F is parallel to
    # the line from the point to the centre of mass: p = c - (c_z - p_z) F / F_z.
    wrench = np.array([[0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1.0]])
    goal = np.array([load[2], 0.0, 0.0, 0.0])
    pick = np.zeros((2, 6))
    pick[0, 0] = pick[1, 1] = -drop / load[2]
    question = Question(stance, about, load, limits, facets, fit)
    return _region(question, tol, (wrench, goal, pick, about[:2]), anchor[2], np.array([0.0, 0.0, 1.0]))


def _com_rows(load: FloatArray, anchor: FloatArray) -> Rows:
    """Return the fixed rows and the point for a centre of mass in the plane through the anchor.

    The wrench about the anchor is [F; c x F + M]: its force is fixed, its moment along F too, and
    the other two components say where c is.
    """
    force, moment = load[:3], load[3:]
    axis = force / np.linalg.norm(force)
    rows = np.zeros((4, 6))
    rows[:3, :3] = np.eye(3)
    rows[3, 3:] = axis
    goal = np.array([*force, axis @ moment])
    pick = np.zeros((2, 6))
    pick[0, 4], pick[1, 3] = -1.0 / force[2], 1.0 / force[2]
    offset = anchor[:2] + np.array([moment[1], -moment[0]]) / force[2]
    return rows, goal, pick, offset


def _anchor(stance: Stance, height: float | None) -> FloatArray:
    """Return the middle of the contacts, at the height of the plane."""
    of_kind("stance", stance, Stance)
    middle = stance.positions.mean(axis=0) if stance.contacts else np.zeros(3)
    if height is not None:
        middle[2] = finite_array("height", height, ())
    return middle


def _region(question: Question, tol: float, rows: Rows, height: float, axis: FloatArray) -> Region:
    """Trace the region of a point that depends linearly on the contact wrench about `question.com`."""
    tol, stance = positive_number("tol", tol, "m"), question.stance
    if not stance.contacts:
        return RegionOutline.nothing(0.0).region(height, axis, tol)
    question = replace(question, limits=all_limits(normal_limits(stance), question.limits))
    force_limit = math.inf
    found = _within_reason(question, rows, tol)
    if found.unbounded:
        force_limit = SQUEEZE * float(np.linalg.norm(question.load[:3]))
        limits = all_limits(question.limits, squeeze_limit(stance, force_limit))
        found = _within_reason(replace(question, limits=limits), rows, tol)
    if found.unbounded:
        raise ProblemError("the region has no bound: give the contacts a normal_max")
    return found.region(height, axis, tol, force_limit)


def _within_reason(question: Question, rows: Rows, tol: float) -> RegionOutline:
    """Trace the region; where rounding says nothing of very much friction, the part that less of it gives.

    What less friction holds, more holds as well: the polygon stands, the half-planes around it do not.
    """
    found, mu = trace_outline(question, rows, tol), question.stance.mu
    if found.unbounded or math.isfinite(found.gap) or not mu.max() > MOST_MU:
        return found
    part = trace_outline(
        replace(question, stance=question.stance.with_friction(np.minimum(mu, MOST_MU))), rows, tol
    )
    return RegionOutline(part.inner, np.zeros((0, 2)), np.zeros(0), math.inf, part.unbounded)


def support_polygon(stance: Stance) -> FloatArray:
    """Return the convex hull of the contacts, corners of soles included, seen from above.

    The classical rule for standing still on flat ground with enough friction, and for nothing else:
    see `com_region` for slopes, walls and scarce friction.

    Returns
    -------
    FloatArray
        (k, 2) corners, counter-clockwise [m]; fewer than three for contacts in a line or a point.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> support_polygon(Stance([PointContact([x, 0, 0]) for x in (0.0, 1.0, 2.0)]))
    array([[0., 0.], [2., 0.]])
    """
    return convex_hull(stance.points().positions[:, :2])
