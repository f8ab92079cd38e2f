"""How far points are outside the hulls of a few others, many times over."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray

FLAT = 1e-12
"""Width of a hull over its length, below which it has no sides."""
CHUNK = 50_000
"""Products of a block of samples."""


def outside_hulls(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far points (S, 2) are beyond the sides of the hulls of corners (S, n, 2): (S,), zero inside.

    The distance is that to the farthest side's line. Of a flat hull, as of a robot that moves in a plane, and
    of two corners it is that to the way between its ends; NaN where a corner is.
    """
    size = corners.shape[1]
    block = max(CHUNK // max(size**3, 1), 1)
    parts = [_outside(corners[k : k + block], points[k : k + block]) for k in range(0, len(points), block)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _outside(corners: FloatArray, points: FloatArray) -> FloatArray:
    """See `outside_hulls`; a side is a pair of corners with all others to its left."""
    if corners.shape[1] < 2:
        return np.asarray(np.linalg.norm(corners - points[:, None], axis=2).min(axis=1))
    along = corners[:, None] - corners[:, :, None]  # from the second index's corner to the third's
    length = np.linalg.norm(along, axis=3)
    nearest = _beside_way(corners, points, along, length)
    if corners.shape[1] == 2:
        return nearest
    with np.errstate(invalid="ignore", divide="ignore"):
        outward = np.stack([along[..., 1], -along[..., 0]], axis=3) / length[..., None]
        height = np.einsum("sijd,skd->sijk", outward, corners)
        start = np.einsum("sijd,sid->sij", outward, corners)
        beyond = height - start[..., None]
        slack = FLAT * length.max(axis=(1, 2))[:, None, None]
        side = (beyond.max(axis=3) <= slack) & (length > slack)
        flat = ~np.any(side & (beyond.min(axis=3) < -slack), axis=(1, 2))
        distance = np.where(side, np.einsum("sijd,sd->sij", outward, points) - start, -np.inf)
    out = np.where(flat, nearest, np.maximum(distance.max(axis=(1, 2)), 0.0))
    return np.asarray(np.where(np.isfinite(nearest), out, np.nan))


def _beside_way(corners: FloatArray, points: FloatArray, along: FloatArray, length: FloatArray) -> FloatArray:
    """Return how far points (S, 2) are from the longest of the ways (S, n, n, 2) between corners: (S,)."""
    size, samples = corners.shape[1], np.arange(len(points))
    first, last = np.divmod(np.nan_to_num(length).reshape(len(points), -1).argmax(axis=1), size)
    start, way = corners[samples, first], along[samples, first, last]
    square = np.einsum("sd,sd->s", way, way)
    share = np.einsum("sd,sd->s", points - start, way) / np.where(square > 0.0, square, 1.0)
    ends = start + np.clip(share, 0.0, 1.0)[:, None] * way
    known = np.isfinite(corners).all(axis=(1, 2))
    return np.asarray(np.where(known, np.linalg.norm(points - ends, axis=1), np.nan))
