"""How far contacts slid without the friction that maximum dissipation asks for.

While a contact moves over the ground, friction opposes it in full: its power is -mu f_n ||v_t||, and a
contact that uses less than its cone does not move at all. No simulator obeys that within an instant:
regularised friction takes the speed of a foot that touches down away within a time constant (v tau: a
millimetre at 0.5 m/s and 2 ms) with less force than the cone allows, and lags behind a slip that turns. So
the work that is missing is added up over a stance, less a share for that lag, and told as the way that lacks
as much when the friction is gone altogether. The row of a touchdown is left out: its velocity is that of the
free foot, its force the blow that stops it.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import kernel

PIECE = 1e-4
"""Length of the pieces into which a foot's way is cut [m]; shaking within less than that is no way."""
RELEASE = 0.02
"""A stance ends when its contact has been unloaded for this long [s]; a shorter gap is a bounce."""
LAG = 0.05
"""Share of the friction's work that may be missing throughout: its direction is 18 degrees off at most."""


@kernel
def free_slides(
    forces: FloatArray,
    velocities: FloatArray,
    mu: FloatArray,
    dt: FloatArray,
    threshold: float,
    weight: float,
) -> FloatArray:
    """Return the longest way without friction in a stance of each contact: (p,) [m].

    That is the work missing in a stance so far over the greatest friction mu f_n in it, but at most m g. A
    stance's way is cut into pieces of `PIECE` net displacement, each of which lacks its displacement times
    the friction missing on the mean of its way: so shaking on the spot costs nothing, however long, and a
    creep counts in full, however slow. NaN or infinite where numbers are too large to multiply.

    Parameters
    ----------
    forces, velocities
        (T, p, 3) in contact frames [N, m/s].
    mu, dt
        (T, p) friction and (T,) step [s].
    threshold
        Normal force from which a contact is loaded [N].
    weight
        m g [N].
    """
    steps, contacts = forces.shape[0], forces.shape[1]
    worst = np.zeros(contacts)
    for c in range(contacts):
        total = peak = lost = way = x = y = 0.0
        idle = RELEASE
        for k in range(steps):
            normal = forces[k, c, 2]
            if normal <= threshold:
                idle += dt[k]
                if idle >= RELEASE:
                    total = peak = lost = way = x = y = 0.0
                continue
            touchdown, idle = idle >= RELEASE, 0.0
            if touchdown:
                continue
            u, v = dt[k] * velocities[k, c, 0], dt[k] * velocities[k, c, 1]
            moved, friction = np.hypot(u, v), mu[k, c] * normal
            peak = max(peak, friction)
            lost += (1.0 - LAG) * friction * moved + forces[k, c, 0] * u + forces[k, c, 1] * v
            way += moved
            x += u
            y += v
            net = np.hypot(x, y)
            if lost > 0.0 and peak > 0.0:  # friction beyond the cone is the second law's matter
                free = (total + lost * (net / way)) / min(peak, weight)
                worst[c] = free if free > worst[c] or np.isnan(free) else worst[c]
            if net >= PIECE:
                total += max(lost, 0.0) * (net / way)
                lost = way = x = y = 0.0
            if not np.isfinite(total + lost + way):
                worst[c] = np.inf
                break
    return worst
