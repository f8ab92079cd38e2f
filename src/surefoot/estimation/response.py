"""A quadratic through the losses of many tosses at a few points, and where it is least.

The loss of one toss jumps: a corner lands earlier and another face comes to lie on the ground. Their mean is
smooth only over distances at which many tosses have jumped. No derivative at a point is of use; a quadratic
fitted by least squares over a box is. It is linear in the losses, which makes the bootstrap free: one
fit per toss, then sums over resampled tosses.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import qmc

from surefoot.arrays import FloatArray

CANDIDATES = 512
"""Points at which the quadratic is looked at, before the best is polished."""
SWEEPS = 60
"""Exact minimisations along the coordinates, in turn."""


def coefficients(dimension: int) -> int:
    """Return how many numbers a quadratic has."""
    return (dimension + 1) * (dimension + 2) // 2


def _features(z: FloatArray) -> FloatArray:
    """Return (n, q) the constant, the coordinates and their products at (n, d) points."""
    d = z.shape[1]
    products = [z[:, i] * z[:, j] for i in range(d) for j in range(i, d)]
    return np.column_stack([np.ones(len(z)), z, *products])


class ResponseSurface:
    """The quadratic of every toss over the box centre +- half.

    Parameters
    ----------
    points
        (n, d) where the losses are known.
    losses
        (n, B) of every toss.
    centre, half
        (d,) the box; it ends at 0 and 1.
    """

    def __init__(self, points: FloatArray, losses: FloatArray, centre: FloatArray, half: FloatArray) -> None:
        self.centre, self.half = centre, half
        self.low, self.high = np.maximum(-1.0, -centre / half), np.minimum(1.0, (1.0 - centre) / half)
        features = _features((points - centre) / half)
        self._per_toss = np.linalg.lstsq(features, losses, rcond=None)[0]
        # what the quadratic of the mean misses, and what that does to its coefficients
        off = (losses - features @ self._per_toss).mean(axis=1)
        noise = off @ off / max(1, len(points) - features.shape[1])
        values, vectors = np.linalg.eigh(features.T @ features)
        self._doubt = vectors * np.sqrt(noise / np.maximum(values, 1e-9 * values[-1]))

    def minimisers(self, weights: FloatArray, seed: int | None = None) -> FloatArray:
        """Return (S, d) where in the box the mean loss is least, for (S, B) weights of the tosses.

        With a seed the coefficients vary by as much as the losses' departure from a quadratic leaves open.
        """
        c = weights @ self._per_toss.T / weights.sum(axis=1, keepdims=True)
        if seed is not None:
            c = c + np.random.default_rng(seed).normal(size=c.shape) @ self._doubt.T
        d = self.centre.size
        slope, curve = c[:, 1 : d + 1], np.zeros((len(c), d, d))
        at = d + 1
        for i in range(d):
            for j in range(i, d):
                curve[:, i, j] += c[:, at]
                curve[:, j, i] += c[:, at]
                at += 1
        unit = qmc.Sobol(d, scramble=False).random(CANDIDATES)
        candidates = self.low + (self.high - self.low) * unit
        z = candidates[np.argmin(c @ _features(candidates).T, axis=1)]
        for _ in range(SWEEPS):
            for i in range(d):
                rest = slope[:, i] + np.einsum("sj,sj->s", curve[:, i], z) - curve[:, i, i] * z[:, i]
                bowl = curve[:, i, i] > 0.0
                inside = -rest / np.where(bowl, curve[:, i, i], 1.0)
                ends = np.where(
                    rest * (self.high[i] - self.low[i])
                    + 0.5 * curve[:, i, i] * (self.high[i] ** 2 - self.low[i] ** 2) < 0.0,
                    self.high[i], self.low[i],
                )  # fmt: skip
                z[:, i] = np.where(bowl, np.clip(inside, self.low[i], self.high[i]), ends)
        return np.asarray(self.centre + self.half * z)
