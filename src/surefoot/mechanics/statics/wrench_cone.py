"""The gravito-inertial wrench cone: everything that a stance can do to the robot, in half-spaces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, of_kind, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact import Fit, FrictionPyramid, PolyhedralCone
from surefoot.mechanics.stance import Stance

if TYPE_CHECKING:
    from surefoot.contact import Method

MOST_ROWS = 20_000
"""Half-spaces above which `wrench_cone` asks before it starts."""


@dataclass(frozen=True)
class WrenchConeSize:
    """How large a wrench cone gets: rays add up, half-spaces can multiply.

    Attributes
    ----------
    rays
        Generators: facets times points (corners for patches).
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
    if rays < 6:
        return WrenchConeSize(rays, rays + 6)
    # facets of the cyclic 5-polytope with n vertices: 2 C(n - 3, 2)
    return WrenchConeSize(rays, 2 * math.comb(rays - 3, 2))


def wrench_cone(
    stance: Stance,
    about: ArrayLike = (0.0, 0.0, 0.0),
    facets: int = 8,
    fit: Fit = "inner",
    method: Method = "qhull",
    most_rows: int = MOST_ROWS,
) -> PolyhedralCone:
    """Return all wrenches that a stance's contact forces can give the robot, as a polyhedral cone.

    Parameters
    ----------
    stance
        Contacts; bounds on their normal forces are not part of a cone and are left out.
    about
        (3,) point that moments refer to, world axes [m].
    facets, fit
        Sides of the friction pyramids, inside or around the cones.
    method
        "qhull" or "cdd": see `surefoot.contact.cones.representation`.
    most_rows
        Half-spaces that may be expected at most: see `wrench_cone_size`.

    Returns
    -------
    PolyhedralCone
        In R^6, [force; moment], with `halfspaces`, `rays` and `contains`. Add gravity yourself:
        the robot can move with linear and angular momentum rates (l', k') if
        ``[l' - m g; k']`` is in it.

    Raises
    ------
    ProblemError
        If more half-spaces are to be expected than `most_rows`.

    Notes
    -----
    S. Caron, Q.-C. Pham, Y. Nakamura, "Leveraging Cone Double Description for Multi-contact Stability
    of Humanoids", RSS 2015. Every contact adds its rays; the half-spaces can multiply: four contacts with
    8 facets give a few hundred, four patches (16 corners) may give many thousands.

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
    size = wrench_cone_size(stance, facets)
    if size.most_rows > real_number("most_rows", most_rows):
        raise ProblemError(
            f"the wrench cone of {size.rays} rays may have up to {size.most_rows} half-spaces, more than "
            f"most_rows={most_rows}: use fewer facets or contacts, or raise most_rows"
        )
    rays = [np.zeros((0, 6))]
    if len(points):
        grasp = points.grasp_map(about)
        for m, part in zip(points.mu, points.slices, strict=True):
            rays.append(_pyramid_rays(float(m), facets, fit) @ grasp[:, part].T)
    return PolyhedralCone.from_rays(np.vstack(rays), method)


def _pyramid_rays(mu: float, facets: int, fit: Fit) -> FloatArray:
    """Return the rays of one pyramid; one only without friction."""
    rays = FrictionPyramid(mu, facets, fit).rays
    return rays if mu > 0.0 else rays[:1]
