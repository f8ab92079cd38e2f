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
from surefoot.base.kernels import releasing_kernel
from surefoot.records.audit.limits import LawLimits

TOTAL, PEAK, LOST, WAY, X, Y, IDLE, WORST, BEYOND = range(9)
"""Columns of the state of each contact between two pieces of a log."""


def start_slides(contacts: int, limits: LawLimits) -> FloatArray:
    """Return the state of (p,) contacts before the first row of a log: (p, 9)."""
    state = np.zeros((contacts, 9))
    state[:, IDLE] = limits.release
    return state


def slide_rules(limits: LawLimits) -> tuple[float, float, float]:
    """Return the last three arguments of `slide_on`."""
    return limits.slide_piece, limits.release, limits.lag


@releasing_kernel
def slide_on(
    state: FloatArray,
    forces: FloatArray,
    velocities: FloatArray,
    mu: FloatArray,
    dt: FloatArray,
    threshold: float,
    weight: float,
    piece: float,
    release: float,
    lag: float,
) -> None:
    """Move the state on by some rows; its column `WORST` is the longest way without friction in a stance [m].

    That is the work missing in a stance so far over the greatest friction mu f_n in it, but at most m g. A
    stance's way is cut into pieces of `piece` net displacement, each of which lacks its displacement times
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
    piece, release, lag
        `LawLimits.slide_piece` [m], `release` [s] and `lag` [-].
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
                if idle >= release:
                    total = peak = lost = way = x = y = 0.0
                continue
            touchdown, idle = idle >= release, 0.0
            if touchdown:
                continue
            # the way of a row, and the work that friction should have taken out on it less what it did
            u, v = dt[k] * velocities[k, c, 0], dt[k] * velocities[k, c, 1]
            moved, friction = np.hypot(u, v), mu[k, c] * normal
            peak = max(peak, friction)
            # Full friction takes mu f_n per metre; what the force did is f_t . v dt, negative where it
            # brakes.
            lost += (1.0 - lag) * friction * moved + forces[k, c, 0] * u + forces[k, c, 1] * v
            way += moved
            x += u
            y += v
            net = np.hypot(x, y)
            if lost > 0.0 and peak > 0.0:  # friction beyond the cone is the second law's matter
                # Of a stretch that is not closed yet, only the net part of its way counts, too.
                free = (total + lost * (net / way)) / min(peak, weight)
                worst = free if free > worst or np.isnan(free) else worst
            # a stretch is closed: what friction owed on it, as far as it led anywhere
            if net >= piece:
                total += max(lost, 0.0) * (net / way)
                lost = way = x = y = 0.0
            if not np.isfinite(total + lost + way):
                worst, state[c, BEYOND] = np.inf, 1.0
                break
        state[c, TOTAL], state[c, PEAK], state[c, LOST] = total, peak, lost
        state[c, WAY], state[c, X], state[c, Y], state[c, IDLE] = way, x, y, idle
        state[c, WORST] = worst
