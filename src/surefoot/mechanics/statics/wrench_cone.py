"""The gravito-inertial wrench cone: everything that a stance can do to the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, of_kind, real_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, check_name, count_of
from surefoot.contact import Fit, FrictionPyramid, Method, RayCone
from surefoot.contact import most_rows as most_rows_of
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.margin import UNDECIDED
from surefoot.mechanics.statics.point_contacts import stand

MOST_ROWS = 500_000
"""Half-spaces above which a wrench cone asks before it works them out [-]: a bound, often several times more
than there are (11,820 of at most 63,756 for a sole with 64 facets at each corner)."""


@dataclass(frozen=True)
class WrenchConeSize:
    """How large a wrench cone gets: rays add up, half-spaces can multiply.

    Attributes
    ----------
    rays
        Generators: facets times points (corners for soles).
    most_rows
        Upper bound on the half-spaces (McMullen's upper bound theorem for the 5-D section).
    """

    rays: int
    most_rows: int


def wrench_cone_size(stance: Stance, facets: int = 8) -> WrenchConeSize:
    """Return how large the wrench cone of a stance can become, without building it.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> wrench_cone_size(Stance([PointContact([k, 0, 0]) for k in range(4)]), facets=8)
    WrenchConeSize(rays=32, most_rows=812)
    """
    rays = FrictionPyramid(1.0, facets).facets * len(stance.points())
    return WrenchConeSize(rays, most_rows_of(rays, 6))


def wrench_cone(
    stance: Stance,
    about: ArrayLike = (0.0, 0.0, 0.0),
    facets: int = 8,
    fit: Fit = "inner",
    method: Method = "qhull",
    most_rows: float = MOST_ROWS,
) -> RayCone:
    """Return all wrenches that a stance's contact forces can give the robot, as a cone.

    Parameters
    ----------
    stance
        Contacts; bounds on their normal forces are not part of a cone and are left out.
    about
        (3,) point that moments refer to, world axes [m].
    facets, fit
        Sides of the friction pyramids, inside or around the cones; for exact ones take `StanceCone`.
    method
        "qhull" or "cdd": see `surefoot.contact.cones.representation`.
    most_rows
        Half-spaces that may be expected at most, where they are asked for: see `wrench_cone_size`.

    Returns
    -------
    RayCone
        In R^6, [force; moment]: `contains`, `project` and `support` go by its rays, `halfspaces` and the
        inner `margin` by rows that are worked out when they are asked for. Add gravity yourself: the robot
        can move with linear and angular momentum rates (l', k') if ``[l' - m g; k']`` is in it.

    Raises
    ------
    ProblemError
        For a stance that is none or a point that is not finite; `halfspaces` where there may be too many.

    Notes
    -----
    S. Caron, Q.-C. Pham, Y. Nakamura, "Leveraging Cone Double Description for Multi-contact Stability
    of Humanoids", RSS 2015. Every contact adds its rays; the half-spaces can multiply: four contacts with
    8 facets give a few hundred, four soles (16 corners) may give many thousands.

    Examples
    --------
    >>> from surefoot import PointContact, Stance
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> giwc = wrench_cone(Stance([PointContact(p) for p in feet]), about=[0, 0, 0.3], facets=4)
    >>> bool(giwc.contains([0, 0, 150, 0, 0, 0])), bool(giwc.contains([0, 0, 150, 0, 40, 0]))
    (True, False)
    """
    of_kind("stance", stance, Stance)
    points = stance.points()
    wrench_cone_size(stance, facets)  # refuses facets that are none
    check_name("method", method, get_args(Method))
    rays = [np.zeros((0, 6))]
    grasp = points.grasp_map(about)
    for m, part in zip(points.mu, points.slices, strict=True):
        rays.append(_pyramid_rays(float(m), facets, fit) @ grasp[:, part].T)
    return RayCone(np.vstack(rays), method, real_number("most_rows", most_rows))


class StanceCone(Drawn):
    """All wrenches of a stance's contacts, their friction cones exact.

    Parameters
    ----------
    stance
        Contacts; bounds on their normal forces are left out.
    about
        (3,) point that moments refer to, world axes [m].

    Examples
    --------
    >>> from surefoot import Sole, SoleContact, Stance
    >>> cone = StanceCone(Stance([SoleContact([0, 0, 0], Sole(0.22, 0.09, 0.6))]))
    >>> bool(cone.contains([55.0, 0, 100.0, 0, 0, 0])), bool(cone.contains([61.0, 0, 100.0, 0, 0, 0]))
    (True, False)
    """

    dim = 6

    def __init__(self, stance: Stance, about: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        self.stance, self.about = stance, finite_array("about", about, (3,))

    def __repr__(self) -> str:
        return f"StanceCone({self.stance!r})"

    def __str__(self) -> str:
        return f"All wrenches that {count_of(len(self.stance), 'contact')} can give, friction cones exact."

    def margin(self, wrench: ArrayLike) -> FloatArray:
        """Return the margin of wrenches (..., 6) as `can_stand` has it: (...) [N].

        The least distance of a corner's force to the border of its friction cone where it is largest,
        negative for wrenches that the contacts cannot give; NaN where neither was proven.
        """
        w = finite_array("wrench", wrench)
        if w.ndim == 0 or w.shape[-1] != 6:
            raise ProblemError(f"expected wrenches of shape (..., 6), got {w.shape}")
        points = self.stance.points()
        out = np.array([self._margin(points, one) for one in w.reshape(-1, 6)])
        return out.reshape(w.shape[:-1])

    def contains(self, wrench: ArrayLike, tol: float = 1e-9) -> BoolArray:
        """Tell whether wrenches (..., 6) [N, N m] are in the cone: (...), within tol [-] of their size."""
        w = finite_array("wrench", wrench)
        arms = self.stance.points().positions - self.about
        length = float(np.linalg.norm(arms, axis=1).max(initial=0.0)) or 1.0
        margins = self.margin(w)
        size = np.sqrt((w[..., :3] ** 2).sum(axis=-1) + (w[..., 3:] ** 2).sum(axis=-1) / length**2)
        return np.asarray(margins >= -tol * np.maximum(1.0, size))

    def support(self, direction: ArrayLike, tol: float = 1e-9) -> FloatArray:
        """Return sup of twist . wrench [W] over the cone for twists (..., 6) [m/s, rad/s]: 0 or infinity.

        Zero where no contact force has a product above tol [-] times the twist's size for a newton.
        """
        d = finite_array("direction", direction)
        if d.ndim == 0 or d.shape[-1] != 6:
            raise ProblemError(f"expected directions of shape (..., 6), got {d.shape}")
        points = self.stance.points()
        seen = (d @ points.grasp_map(self.about)).reshape(*d.shape[:-1], len(points), 3)
        over = seen[..., 2] + points.mu * np.hypot(seen[..., 0], seen[..., 1])
        worst = over.max(axis=-1, initial=-np.inf)
        return np.where(worst <= tol * np.maximum(1.0, np.linalg.norm(d, axis=-1)), 0.0, np.inf)

    def _margin(self, points: Stance, wrench: FloatArray) -> float:
        """Return the margin of one wrench (6,) [N]."""
        if not wrench.any():
            return 0.0
        if not len(points):
            return -math.inf
        outcome, margin, _, _, _ = stand(points.positions, points.rotations, points.mu, self.about, wrench)
        return math.nan if outcome == UNDECIDED else float(margin)


def _pyramid_rays(mu: float, facets: int, fit: Fit) -> FloatArray:
    """Return the rays of one pyramid; one only without friction."""
    rays = FrictionPyramid(mu, facets, fit).rays
    return rays if mu > 0.0 else rays[:1]
