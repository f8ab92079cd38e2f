"""How far contacts slid without the friction that maximum dissipation asks for.

While a contact moves over the ground, friction opposes it in full: its power is -mu f_n ||v_t||, and a
contact that uses less than its cone does not move at all. No simulator obeys that within an instant:
regularised friction takes the speed of a foot that touches down away within a time constant (v tau: a
millimetre at 0.5 m/s and 2 ms) with less force than the cone allows, and lags behind a slip that turns. So
the work that is missing is added up over a stance, less a share for that lag, and given as the way that lacks
as much when the friction is gone altogether. The row of a touchdown is left out: its velocity is that of the
free foot, its force the blow that stops it.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel

PIECE = 1e-4
"""Length of the pieces into which a foot's way is cut [m]; shaking within less than that is no way."""
RELEASE = 0.02
"""A stance ends when its contact has been unloaded for this long [s]; a shorter gap is a bounce."""
LAG = 0.05
"""Share of the friction's work that may be missing throughout: its direction is 18 degrees off at most."""


TOTAL, PEAK, LOST, WAY, X, Y, IDLE, WORST, BEYOND = range(9)
"""Columns of the state of each contact between two pieces of a log."""


def start_slides(contacts: int) -> FloatArray:
    """Return the state of (p,) contacts before the first row of a log: (p, 9)."""
    state = np.zeros((contacts, 9))
    state[:, IDLE] = RELEASE
    return state


@kernel
def slide_on(
    state: FloatArray,
    forces: FloatArray,
    velocities: FloatArray,
    mu: FloatArray,
    dt: FloatArray,
    threshold: float,
    weight: float,
) -> None:
    """Move the state on by some rows; its column `WORST` is the longest way without friction in a stance [m].

    That is the work missing in a stance so far over the greatest friction mu f_n in it, but at most m g. A
    stance's way is cut into pieces of `PIECE` net displacement, each of which lacks its displacement times
    the friction missing on the mean of its way: so shaking on the spot costs nothing, however long, and a
    creep counts in full, however slow. NaN or infinite where numbers are too large to multiply.

    Parameters
    ----------
    state
        (p, 9) of `start_slides`, overwritten.
    forces, velocities
        (T, p, 3) in contact frames [N, m/s].
    mu, dt
        (T, p) friction and (T,) step [s].
    threshold
        Normal force from which a contact is loaded [N].
    weight
        m g [N].
    """
    for c in range(forces.shape[1]):
        if state[c, BEYOND] != 0.0:
            continue
        total, peak, lost = state[c, TOTAL], state[c, PEAK], state[c, LOST]
        way, x, y, idle = state[c, WAY], state[c, X], state[c, Y], state[c, IDLE]
        worst = state[c, WORST]
        for k in range(forces.shape[0]):
            normal = forces[k, c, 2]
            if normal <= threshold:
                idle += dt[k]
                # a lift-off ends the slide
                if idle >= RELEASE:
                    total = peak = lost = way = x = y = 0.0
                continue
            touchdown, idle = idle >= RELEASE, 0.0
            if touchdown:
                continue
            # the way of a row, and the work that friction should have taken out on it less what it did
            u, v = dt[k] * velocities[k, c, 0], dt[k] * velocities[k, c, 1]
            moved, friction = np.hypot(u, v), mu[k, c] * normal
            peak = max(peak, friction)
            # Full friction takes mu f_n per metre; what the force did is f_t . v dt, negative where it
            # brakes.
            lost += (1.0 - LAG) * friction * moved + forces[k, c, 0] * u + forces[k, c, 1] * v
            way += moved
            x += u
            y += v
            net = np.hypot(x, y)
            if lost > 0.0 and peak > 0.0:  # friction beyond the cone is the second law's matter
                # Of a stretch that is not closed yet, only the net part of its way counts, too.
                free = (total + lost * (net / way)) / min(peak, weight)
                worst = free if free > worst or np.isnan(free) else worst
            # a stretch is closed: what friction owed on it, as far as it led anywhere
            if net >= PIECE:
                total += max(lost, 0.0) * (net / way)
                lost = way = x = y = 0.0
            if not np.isfinite(total + lost + way):
                worst, state[c, BEYOND] = np.inf, 1.0
                break
        state[c, TOTAL], state[c, PEAK], state[c, LOST] = total, peak, lost
        state[c, WAY], state[c, X], state[c, Y], state[c, IDLE] = way, x, y, idle
        state[c, WORST] = worst
