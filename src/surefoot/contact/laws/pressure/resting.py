"""How a compliant sole lies on flat ground: its depth and lean for a load and a centre of pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array, real_number
from surefoot.contact.laws.pressure.field import PressurePatch
from surefoot.contact.laws.pressure.pieces import CompliantSolid
from surefoot.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.contact.laws.pressure.field import PressureField


def resting_pose(
    field: PressureField, solid: CompliantSolid, load: float, centre: ArrayLike | None = None
) -> tuple[FloatArray, FloatArray, PressurePatch]:
    """Return rotation_world_body (3, 3), position (3,) [m] and the patch of a body at rest on z = 0.

    Parameters
    ----------
    field, solid
        The contact.
    load
        Normal force [N], > 0.
    centre
        (2,) where the load acts, in the body's x and y [m]; None for the middle of its underside.

    Raises
    ------
    ProblemError
        If the load lies outside the underside, so near its edge that the overlap would exceed the body, or is
        more than it can carry.
    """
    from scipy.optimize import root

    weight = real_number("load", load, low=np.finfo(float).tiny, high=1e300)
    low = solid.corners[:, 2].min()
    rim = solid.corners[solid.corners[:, 2] <= low + 1e-12 + 1e-9 * np.ptp(solid.corners[:, 2])]
    middle, size = rim[:, :2].mean(axis=0), float(np.ptp(rim[:, :2], axis=0).max())
    wanted = middle if centre is None else finite_array("centre", centre, (2,))
    if not (solid.distances(np.array([*wanted, low])) >= -1e-12).all():
        raise ProblemError(f"centre {wanted.tolist()} lies outside the underside")
    scale = weight * field.thickness / (field.modulus * np.prod(np.ptp(rim[:, :2], axis=0)))

    def laid(x: FloatArray) -> tuple[FloatArray, FloatArray, PressurePatch]:
        """Return the pose in which the ground is z = low + x0 + x1 (x - x_m) + x2 (y - y_m) for the body."""
        depth, tilt = scale * x[0], scale / size * x[1:]
        R = _levelling(np.array([-tilt[0], -tilt[1], 1.0]))
        on = np.array([*middle, low + depth])
        position = np.array([0.0, 0.0, -(R @ on)[2]])
        return R, position, field.contact(solid, R, position)

    def off(x: FloatArray) -> FloatArray:
        """Return what force and centre are off, in units of the load and the size; of no force -1, 0, 0."""
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


def _levelling(normal: FloatArray) -> FloatArray:
    """Return the least rotation that takes a direction (3,) with z > 0 to z."""
    n = normal / np.linalg.norm(normal)
    K = np.array([[0.0, 0.0, -n[0]], [0.0, 0.0, -n[1]], [n[0], n[1], 0.0]])  # of n x z
    turned: FloatArray = np.eye(3) + K + K @ K / (1.0 + n[2])
    return turned
