"""Friction work that is missing while a contact moves over the ground.

Maximum dissipation says that friction opposes a slide in full: its power is -mu f_n ||v_t||, and a contact
that uses less than its cone does not move at all. What a motion lacks of that work is judged over a stance,
since no simulator stops a foot within an instant: regularised friction takes its speed away within a time
constant, over some tenths of a millimetre, with less force than the cone allows.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import kernel

PIECE = 1e-4
"""Length of the pieces into which a foot's way is cut [m]; shaking within less than that is no way."""
RELEASE = 0.02
"""A stance ends when its contact has been unloaded for this long [s]; a shorter gap is a bounce."""


@kernel
def missing_work(
    forces: FloatArray, velocities: FloatArray, mu: FloatArray, dt: FloatArray, threshold: float
) -> FloatArray:
    """Return the largest friction work missing in a stance of each contact: (p,) [N m].

    The way of a stance is cut into pieces of `PIECE` net displacement. A piece lacks its displacement times
    the friction that was missing on the mean of the way, so that shaking on the spot costs nothing, however
    long, and a creep counts in full, however slow.

    Parameters
    ----------
    forces, velocities
        (T, p, 3) in contact frames [N, m/s].
    mu, dt
        (T, p) friction and (T,) step [s].
    threshold
        Normal force from which a contact is loaded [N].
    """
    steps, contacts = forces.shape[0], forces.shape[1]
    worst = np.zeros(contacts)
    for c in range(contacts):
        total = lost = way = x = y = idle = 0.0
        for k in range(steps):
            normal = forces[k, c, 2]
            if normal <= threshold:
                idle += dt[k]
                if idle >= RELEASE:
                    total = lost = way = x = y = 0.0
                continue
            idle = 0.0
            u, v = velocities[k, c, 0], velocities[k, c, 1]
            speed = math.sqrt(u * u + v * v)
            power = mu[k, c] * normal * speed + forces[k, c, 0] * u + forces[k, c, 1] * v
            lost += dt[k] * power
            way += dt[k] * speed
            x += dt[k] * u
            y += dt[k] * v
            net = math.sqrt(x * x + y * y)
            # friction beyond the cone is the second law's matter, and pays for nothing here
            piece = max(lost, 0.0) * net / way if way > 0.0 else 0.0
            worst[c] = max(worst[c], total + piece)
            if net >= PIECE:
                total += piece
                lost = way = x = y = 0.0
    return worst
