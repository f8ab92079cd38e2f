"""Differences of states, and feedback on them, compiled: a free flyer's place and rotation, and vectors.

A tangent of a configuration is (position in body axes, rotation vector in body axes, joints): the same to
first order as Pinocchio's. Quaternions are (x, y, z, w).
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.rotations import rotation_of, turn_between


@kernel
def difference(floating: bool, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Fill out (nv,) with the tangent at the configuration a (nq,) that leads to b (nq,)."""
    shift = 1 if floating else 0
    if floating:
        R = np.empty((3, 3))
        rotation_of(a, R)
        for i in range(3):
            out[i] = 0.0
            for j in range(3):
                out[i] += R[j, i] * (b[j] - a[j])
        # The place in body axes but not by the exponential of SE(3): simpler, and the same to first order,
        # which is all that gains about a motion need.
        turn_between(a[3:7], b[3:7], out[3:6])
    for i in range(6 if floating else 0, out.size):
        out[i] = b[i + shift] - a[i + shift]


@kernel
def feedback(
    floating: bool, here: tuple[FloatArray, FloatArray], nominal: tuple[FloatArray, FloatArray],
    torques: FloatArray, step: FloatArray, share: float, gains: FloatArray, limits: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return torques + share step + K (x ⊖ x_nominal), within the limits: (m,) [N m].

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    here, nominal
        (nq,) and (nv,) of the state and of the one that the torques belong to.
    torques, step
        (m,) [N m].
    share
        Of the step.
    gains
        K (m, 2nv).
    limits
        Lower and upper bounds (2, m) [N m].
    """
    n = here[1].size
    off = np.empty(2 * n)
    difference(floating, nominal[0], here[0], off[:n])
    off[n:] = here[1] - nominal[1]
    # The backward pass bounds the step alone: what feedback adds away from the nominal motion is cut here.
    wanted = torques + share * step + gains @ off
    out: FloatArray = np.minimum(np.maximum(wanted, limits[0]), limits[1])
    return out
