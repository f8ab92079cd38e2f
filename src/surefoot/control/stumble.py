"""Feet that strike an edge in the air: told from feet that land by the direction of the force on them.

Ground pushes up, within its friction; an edge pushes back. A foot in the air that is pushed sideways more
than upwards, and does not get on, has struck something: it is not on the ground, and it is lifted over what
it struck [1]_. A leg that brakes, or a jolt of the body, looks like a push, but its foot goes on.

References
----------
.. [1] M. Focchi et al., "Heuristic planning for rough terrain locomotion in presence of external disturbances
   and variable perception quality", in Advances in Robotics Research, Springer 2020 (a step reflex like it).
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.walking_feet import Feet

STRUCK = 0.1
"""Force against its motion from which a foot has struck something, as a share of m g."""
STEEP = 1.0
"""Ground gives no more force sideways than this times that along its normal."""
SENSED = 0.06
"""Force along the normal below which a foot in the air has not found the ground, likewise: what is estimated
of the force on a leg that is braked in the air is not zero."""
STOPPED = 0.5
"""A foot that has struck something has less than this share of the speed that it should have, along it."""
SOONEST, LATEST = 0.15, 1.0
"""Shares of its swing between which a foot can strike something: lift-off drags."""


def sort_touches(
    feet: Feet, sensed: BoolArray, forces: FloatArray, speeds: FloatArray, moving: FloatArray, weight: float
) -> tuple[BoolArray, BoolArray]:
    """Return which feet feel the ground, and which have struck an edge in the air: (n,) each.

    Parameters
    ----------
    feet
        The feet.
    sensed
        (n,) which feet feel anything.
    forces
        (n, 3) on the feet, world axes [N].
    speeds
        (n, 3) of the feet, as wanted, world axes [m/s].
    moving
        (n, 3) of the feet, as they are, likewise.
    weight
        m g [N].
    """
    normals = feet.frames[:, :, 2]
    along = (forces * normals).sum(axis=1)
    sideways = forces - along[:, None] * normals
    size = np.linalg.norm(sideways, axis=1)
    struck = ~feet.carrying & (size > STRUCK * weight) & (size > STEEP * along)
    against = (sideways[:, :2] * speeds[:, :2]).sum(axis=1) < 0.0
    stopped = (moving[:, :2] * speeds[:, :2]).sum(axis=1) < STOPPED * (speeds[:, :2] ** 2).sum(axis=1)
    swinging = ~feet.late & ~feet.again & (feet.share > SOONEST) & (feet.share < LATEST)
    light = ~feet.carrying & (along < SENSED * weight)
    return sensed & ~struck & ~light, struck & against & stopped & swinging
