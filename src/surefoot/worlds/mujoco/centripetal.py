"""The acceleration of a foot by velocities alone, which MuJoCo's contacts leave out.

A contact of MuJoCo brings J q̈ to a reference -b J v - k r, as if that were how J v changes; what is
missing is J̇ v [1]_. A foot on a leg that is stretched fast is to have 20 m/s² by its joints' speeds alone.
It creeps by as much over b, and where Go2 takes off for a backflip friction drives it. Taken from the
reference between the halves of MuJoCo's step, the term leaves next to nothing of that.

References
----------
.. [1] E. Todorov, "Convex and analytically-invertible dynamics with contacts and constraints", ICRA 2014; the
   reference acceleration: MuJoCo's documentation, chapter Computation, section "Constraint model".
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import IntArray


def step_with_centripetal(mujoco: Any, model: Any, data: Any, owner: IntArray) -> None:
    """Make a step of MuJoCo in which feet on the ground accelerate as a whole.

    Parameters
    ----------
    mujoco, model, data
        The module and its own; the integrator is Euler's or implicit.
    owner
        See `mujoco_links.owners`: contacts of a foot's sphere with the ground alone are changed.
    """
    mujoco.mj_step1(model, data)
    slope, spin, contact = np.empty((3, model.nv)), np.empty((3, model.nv)), data.contact
    for geoms, row, dim, place, frame in zip(
        contact.geom, contact.efc_address, contact.dim, contact.pos, contact.frame, strict=True
    ):
        side = int(np.argmax(owner[geoms]))
        if row < 0 or owner[geoms[side]] < 0 or owner[geoms[1 - side]] != -1:
            continue
        foot = int(geoms[side])
        centre = data.geom_xpos[foot]
        mujoco.mj_jacDot(model, data, slope, spin, centre, model.geom_bodyid[foot])
        # the point of contact stays below the sphere's centre: no term of the sphere's own turning
        change = slope @ data.qvel + np.cross(spin @ data.qvel, place - centre)
        data.efc_aref[row : row + dim] -= (1 if side else -1) * (frame.reshape(3, 3) @ change)[:dim]
    mujoco.mj_step2(model, data)
