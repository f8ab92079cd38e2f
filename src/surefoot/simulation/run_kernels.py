"""Compiled small pieces of a run's loop."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.kernels import kernel


@kernel
def loaded_feet(contact_foot: IntArray, forces: FloatArray, feet: int, least: float) -> BoolArray:
    """Return which feet (feet,) have a contact point with more than the least normal force [N].

    Parameters
    ----------
    contact_foot, forces
        (p,) foot of each contact point, and (p, 3) forces in contact frames [N].
    feet, least
        Number of feet, and the force.
    """
    out = np.zeros(feet, dtype=np.bool_)
    for k in range(len(contact_foot)):
        if forces[k, 2] > least:
            out[contact_foot[k]] = True
    return out


@kernel
def any_reached(torques: FloatArray, limits: FloatArray) -> bool:
    """Return whether a torque (joints,) is at its limit (joints,), of either sign [N m]."""
    out = False
    for j in range(len(torques)):
        out = out or abs(torques[j]) >= limits[j]
    return out
