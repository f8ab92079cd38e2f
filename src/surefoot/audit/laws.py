"""The laws of contact as numbers, from measured forces, gaps and velocities alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray

PENETRATION_LIMIT = 1e-3
"""Deepest penetration that still counts as touching [m]."""
PULL_LIMIT = 1e-3
"""Largest pull that counts as rounding, as a share of m g."""
CONE_LIMIT = 1.0 + 1e-3
"""Highest use of the friction cone that counts as inside."""
LOADED_SHARE = 1e-3
"""A contact counts as loaded above this share of m g; below it the use of its cone is noise."""
LEAST_FRICTION = 1e-4
"""Friction below this counts as this much: simulators know no exact zero."""
SLIDING_SPEED = 1e-2
"""Speed from which a contact counts as sliding [m/s]."""


@dataclass(frozen=True)
class Laws:
    """How far a motion went from the three laws.

    Attributes
    ----------
    penetration_max
        Deepest penetration [m].
    unilateral_min
        Least normal force; negative means that the ground pulled [N].
    cone_use_max
        Highest ||f_t|| / (mu f_n) of a loaded contact; one is the cone's surface.
    complementarity_max
        Largest f_n |gap|: force across a distance [N m].
    dissipation_max
        Largest lost friction power of a sliding contact over what its cone allows,
        (mu f_n ||v_t|| + f_t . v_t) / (m g ||v_t||); zero when friction opposes the slip in full.
    """

    penetration_max: float
    unilateral_min: float
    cone_use_max: float
    complementarity_max: float
    dissipation_max: float

    def broken(self, weight: float) -> list[str]:
        """Return one line per broken law, for a robot of the given weight m g [N]."""
        out = []
        if self.penetration_max > PENETRATION_LIMIT:
            out.append(
                f"penetration of {1e3 * self.penetration_max:.2f} mm (limit {1e3 * PENETRATION_LIMIT:g})"
            )
        if self.unilateral_min < -PULL_LIMIT * weight:
            out.append(f"a pull of {-self.unilateral_min:.3g} N")
        if self.cone_use_max > CONE_LIMIT:
            out.append(f"{self.cone_use_max:.3f} times the friction that the cone allows")
        if self.complementarity_max > PENETRATION_LIMIT * weight:
            out.append(f"force across a gap: {self.complementarity_max:.3g} N m")
        return out


def contact_use(forces: ArrayLike, mu: ArrayLike, threshold: float) -> FloatArray:
    """Return ||f_t|| / (mu f_n) of (T, p, 3) forces, zero where f_n is at most `threshold` [N]: (T, p).

    `mu` is (T,), the friction of the ground at each time, taken as `LEAST_FRICTION` at least.
    """
    f = np.asarray(forces, dtype=np.float64)
    limit = np.maximum(np.asarray(mu, dtype=np.float64), LEAST_FRICTION)[:, None] * f[..., 2]
    loaded = f[..., 2] > max(threshold, 0.0)
    return np.divide(np.hypot(f[..., 0], f[..., 1]), limit, out=np.zeros_like(limit), where=loaded)


def check_laws(
    forces: ArrayLike, gaps: ArrayLike, velocities: ArrayLike, mu: ArrayLike, weight: float
) -> Laws:
    """Return the laws as numbers for a motion.

    Parameters
    ----------
    forces
        (T, p, 3) measured contact forces on the robot, contact frames [N].
    gaps
        (T, p) distances to the ground [m].
    velocities
        (T, p, 3) velocities of the feet's material at the contacts [m/s].
    mu
        (T,) friction of the ground.
    weight
        m g of the robot [N]; says what is small.
    """
    f, gap = np.asarray(forces, dtype=np.float64), np.asarray(gaps, dtype=np.float64)
    if f.size == 0:
        return Laws(0.0, 0.0, 0.0, 0.0, 0.0)
    v = np.asarray(velocities, dtype=np.float64)
    normal = f[..., 2]
    speed = np.hypot(v[..., 0], v[..., 1])
    limit = np.asarray(mu, dtype=np.float64)[:, None] * normal
    lost = limit + (f[..., 0] * v[..., 0] + f[..., 1] * v[..., 1]) / np.maximum(speed, 1e-12)
    sliding = (speed > SLIDING_SPEED) & (normal > LOADED_SHARE * weight)
    return Laws(
        penetration_max=float(max(0.0, -gap.min())),
        unilateral_min=float(normal.min()),
        cone_use_max=float(contact_use(f, mu, LOADED_SHARE * weight).max()),
        complementarity_max=float(np.abs(normal * gap).max()),
        dissipation_max=float(np.where(sliding, lost, 0.0).max() / weight),
    )
