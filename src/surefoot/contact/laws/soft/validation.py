"""What every soft law must keep: no pull, no force across a gap, true derivatives, no energy made."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.errors import ProblemError

SLACK = 1e-6
"""Relative error of central differences that is taken for rounding."""


def validate_law(
    law: SoftLaw, *, depth: float = 1e-3, speed: float = 1.0, samples: int = 200, seed: int = 0
) -> None:
    """Check a soft law on random gaps and velocities; for your own laws, too.

    Parameters
    ----------
    law
        What to check.
    depth, speed
        Size of the overlaps [m] and velocities [m/s] that are tried.
    samples, seed
        How many, and which.

    Raises
    ------
    ProblemError
        Naming what is broken and where: a pull, force across a gap, a tangential force beyond friction, a
        derivative that central differences contradict, or a law that gives back more than it stored.
    """
    rng = np.random.default_rng(seed)
    gaps = -depth * rng.uniform(0.02, 2.0, samples)
    velocities = speed * rng.normal(size=(samples, 3))
    forces = law.force(gaps, velocities)
    _require(np.isfinite(forces).all(axis=-1), gaps, velocities, "the force is not finite")
    _require(forces[:, 2] >= 0.0, gaps, velocities, "the normal force pulls")
    across = law.force(-gaps, velocities)
    _require((across == 0.0).all(axis=-1), -gaps, velocities, "there is a force across a gap")
    tangential = np.linalg.norm(forces[:, :2], axis=-1)
    allowed = law.friction.mu * forces[:, 2] * (1.0 + 1e-12)
    _require(tangential <= allowed, gaps, velocities, "the tangential force exceeds the friction")
    sliding = (forces[:, :2] * velocities[:, :2]).sum(axis=-1)
    _require(sliding <= 1e-12 * forces[:, 2] * speed, gaps, velocities, "friction drives the sliding")
    lost = (forces[:, 2] - law.force(gaps, 0.0 * velocities)[:, 2]) * velocities[:, 2]
    _require(lost <= 1e-12 * forces[:, 2] * speed, gaps, velocities, "the damping gives energy")
    _check_derivatives(law, gaps, velocities, depth, speed)


def _check_derivatives(
    law: SoftLaw, gaps: NDArray[Any], velocities: NDArray[Any], depth: float, speed: float
) -> None:
    """Compare Jacobian and energy with central differences, away from the onset of a pull."""
    h, s = 1e-6 * depth, 1e-6 * speed
    normal = law.normal(gaps, velocities[:, 2])
    near = [law.normal(gaps + a * h, velocities[:, 2] + b * s) > 0.0 for a in (-1, 1) for b in (-1, 1)]
    smooth = np.all(near, axis=0) | (normal == 0.0) & ~np.any(near, axis=0)
    gaps, velocities = gaps[smooth], velocities[smooth]
    jacobian = law.jacobian(gaps, velocities)
    scale = np.abs(law.force(gaps, velocities)).max(axis=-1)
    by_gap = (law.force(gaps + h, velocities) - law.force(gaps - h, velocities)) / (2.0 * h)
    slack = SLACK * (scale / depth + np.abs(by_gap).max(axis=-1)) + 1e-300
    bad = np.abs(jacobian.gap - by_gap).max(axis=-1) > slack
    _require(~bad, gaps, velocities, "the derivative by the gap is wrong")
    for axis in range(3):
        step = s * np.eye(3)[axis]
        by_axis = (law.force(gaps, velocities + step) - law.force(gaps, velocities - step)) / (2.0 * s)
        slow = np.linalg.norm(velocities[:, :2], axis=-1)  # exact friction turns within its own speed
        slack = SLACK * (scale / speed + np.abs(by_axis).max(axis=-1)) * (1.0 + speed / slow) ** 2 + 1e-300
        bad = np.abs(jacobian.velocity[..., axis] - by_axis).max(axis=-1) > slack
        _require(~bad, gaps, velocities, f"the derivative by velocity {'xyz'[axis]} is wrong")
    at_rest = law.normal(gaps, 0.0 * gaps)
    slope = -(law.energy(gaps + h) - law.energy(gaps - h)) / (2.0 * h)
    bad = np.abs(slope - at_rest) > SLACK * (at_rest + np.abs(slope)) + 1e-9 * law.energy(gaps) / h * 1e-6
    _require(~bad, gaps, 0.0 * velocities, "the stored energy is not the integral of the force at rest")


def _require(kept: Any, gaps: NDArray[Any], velocities: NDArray[Any], broken: str) -> None:
    if not kept.all():
        k = int(np.argmin(kept))
        raise ProblemError(
            f"{broken}, e.g. at gap {gaps[k]:.6g} m and velocity "
            f"{np.array2string(velocities[k], precision=6)} m/s"
        )
