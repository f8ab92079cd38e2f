"""Models of how a logged force may differ from the true one."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.symptom_limits import FitLimits


def rotation_between(true: FloatArray, logged: FloatArray) -> FloatArray:
    """Return the rotation R that makes R true come closest to logged: (3, 3), of (m, 3) rows (Kabsch)."""
    known = np.isfinite(true).all(axis=1)
    # The third singular direction is turned where the best orthogonal matrix is a reflection: mirrors are a
    # symptom of their own.
    U, _, V = np.linalg.svd(logged[known].T @ true[known])
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ V))])
    return np.asarray(U @ turn @ V)


def rotation_angle(turn: FloatArray) -> float:
    """Return the angle of a rotation (3, 3) [deg]."""
    return float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))


def best_shift(true: FloatArray, logged: FloatArray, most: int, core: slice) -> tuple[float, int]:
    """Return the share of the mismatch explained by the best shift in time, and its rows (late: positive).

    Parameters
    ----------
    true, logged
        (T, 3) with the surroundings of the episode.
    most
        Largest shift that is tried.
    core
        The episode.
    """
    known = np.nan_to_num(true)
    amiss = float(((logged - known)[core] ** 2).sum())
    if amiss <= 0.0:
        return 0.0, 0
    best = (0.0, 0)
    for shift in range(-most, most + 1):
        start, stop = core.start - shift, core.stop - shift
        if start < 0 or stop > len(known):
            continue
        share = 1.0 - float(((logged[core] - known[start:stop]) ** 2).sum()) / amiss
        best = max(best, (share, shift))
    return best


def fitted_pyramid(
    forces: FloatArray, mu: FloatArray, weight: float, limits: FitLimits
) -> tuple[int, float] | None:
    """Return the `pyramid_facets` of forces (..., 3) outside cones of friction mu (...); None for too few.

    Normal forces below a small share of the weight m g [N] are noise.
    """
    use = forces[..., :2] / np.maximum(mu * forces[..., 2], 1e-12)[..., None]
    over = (forces[..., 2] > limits.loaded * weight) & (np.hypot(use[..., 0], use[..., 1]) > limits.outside)
    return pyramid_facets(use[over], limits) if over.sum() >= limits.least_points else None


def pyramid_facets(use: FloatArray, limits: FitLimits) -> tuple[int, float] | None:
    """Return facets and phase [rad] of the pyramid about the unit disk on whose edge points lie; else None.

    Facets touch the disk. A pyramid whose edges lie along the axes, or half way between, shows in points in
    one place; any other phase only by points on more than one side of a corner or along an edge: a single
    point lies on an edge of some pyramid.

    Parameters
    ----------
    use
        (m, 2) f_t / (mu f_n) of the points outside the disk.
    limits
        How near to an edge a point lies on it.
    """
    reach, direction = np.hypot(use[:, 0], use[:, 1]), np.arctan2(use[:, 1], use[:, 0])
    for facets in (4, 8):
        sector = 2.0 * np.pi / facets
        if np.percentile(reach, 90) > limits.corner / np.cos(0.5 * sector):
            continue
        turns = np.exp(1j * facets * direction)  # one place modulo the sector, or several
        spread = 1.0 - abs(turns.mean()) > limits.spread
        free = (
            np.arange(0.0, sector, np.radians(limits.phase_step)) if spread else np.array([0.0, 0.5 * sector])
        )
        for phase in free.tolist():
            # Angle to the middle of the nearest facet, whose distance from the axis is one: reach cos(off) is
            # one on it.
            off = (direction - phase + 0.5 * sector) % sector - 0.5 * sector
            on_edge = reach * np.cos(off)
            high, low = np.percentile(on_edge, 90), np.percentile(on_edge, 10)
            if high < limits.edge_high and low > limits.edge_low:
                return facets, phase
    return None
