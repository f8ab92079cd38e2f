"""Contact forces of a stance for one wanted wrench; flat feet push at the corners of their soles."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics.force_distribution import ForceDistributor


def distribute(
    stance: Stance,
    wrench: ArrayLike,
    about: ArrayLike = (0.0, 0.0, 0.0),
    wrench_weights: ArrayLike = 1.0,
    force_weight: float = 1e-4,
) -> FloatArray:
    """Return contact forces of a stance for a wanted wrench, with exact cones.

    Parameters
    ----------
    stance
        Points and soles; a sole is allocated through its corners.
    wrench
        (6,) wanted [force; moment about the point], world axes [N, N·m].
    about
        (3,) point that moments refer to, usually the centre of mass [m].
    wrench_weights, force_weight
        As for `ForceDistributor`.

    Returns
    -------
    FloatArray
        (n, 3) forces in contact frames [N]. If the stance has soles, the stacked (dim,) vector of
        `Stance.slices` instead: three components for a point, a wrench of six in the contact
        frame for a sole.

    Raises
    ------
    ProblemError
        If the wrench or the point is not finite or has the wrong shape.
    """
    of_kind("stance", stance, Stance)
    w = finite_array("wrench", wrench, (6,))
    points = stance.points()
    distributor = ForceDistributor(
        points.mu, points.normal_min, points.normal_max, wrench_weights, force_weight
    )
    if len(points) == len(stance):
        return distributor.solve(points.grasp_map(about), w)
    forces = distributor.solve_with_rows(points.grasp_map(about), w, *_sole_sums(stance))
    return np.asarray(stance.corner_map @ forces.ravel())


def _sole_sums(stance: Stance) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the (soles, 3n) map from corner forces to the soles' normal forces, and its bounds."""
    soles = [k for k, contact in enumerate(stance.contacts) if contact.dim == 6]
    normals = [stance.slices[k].start + 2 for k in soles]
    return stance.corner_map[normals], stance.normal_min[soles], stance.normal_max[soles]
