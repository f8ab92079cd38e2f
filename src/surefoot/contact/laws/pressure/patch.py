"""What a pressure field does to a body: forces, where they act, and over which area."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.arrays import FloatArray


class PressurePatch(NamedTuple):
    """The contact of a compliant body with the ground; forces on the body, world axes.

    Attributes
    ----------
    force
        (3,) pressure and friction [N].
    moment
        (3,) of all of it about `centre` [N m].
    normal_force
        Pressure integrated over the area, whatever its directions [N].
    centre
        (3,) centre of pressure [m]; NaN without contact.
    area
        Wetted, in the ground's surface [m²].
    largest
        Largest pressure at a corner of the wetted polygons, damping included [Pa].
    friction_force, friction_torque
        (3,) [N], and about the mean normal at the centre [N m].
    spin_limit
        Largest torque about the mean normal at the centre that friction gives to a body that only turns
        there [N m].
    polygons, pressures
        The wetted pieces (k, 3) [m] with the pressures at their corners (k,) [Pa].
    """

    force: FloatArray
    moment: FloatArray
    normal_force: float
    centre: FloatArray
    area: float
    largest: float
    friction_force: FloatArray
    friction_torque: float
    spin_limit: float
    polygons: list[FloatArray]
    pressures: list[FloatArray]

    def wrench(self, about: FloatArray) -> FloatArray:
        """Return (6,) [force; moment about a point (3,) [m]] [N, N m], zeros without contact."""
        if not self.normal_force > 0.0:
            return np.zeros(6)
        lever = self.centre - np.asarray(about, dtype=np.float64)
        return np.concatenate([self.force, self.moment + np.cross(lever, self.force)])
