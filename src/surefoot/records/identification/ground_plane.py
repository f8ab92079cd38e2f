"""Where the ground is: the plane through what bodies came to rest on.

What lies still touches with its lowest corners, so that their middle lies in the ground. Height and slopes
are then a linear regression over the tosses, with nothing to simulate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.spatial.transform import Rotation

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.identification.tosses import Tosses

AT_REST = 0.5
"""Speed over the last frames under which a toss has come to rest, in widths and radians per second."""
LAST = 3
"""Frames at the end that must agree."""
FLAT = 0.06
"""Corners within this share of a width above the lowest one carry what lies still; three at least."""
FEWEST = 3
"""Tosses at rest that make a plane."""
CLEAR = 0.04
"""Height above the ground that counts as flight, in widths, where that is well known."""
OUTLIER = 5.0
"""Distances from the plane beyond this many median ones do not count."""


@dataclass(frozen=True)
class GroundPlane:
    """The ground z = height + slope · (x, y).

    Attributes
    ----------
    height
        [m].
    slope
        (2,) rise per metre along x and y.
    clear
        Height of the lowest corner above it that counts as flight, in widths.
    """

    height: float
    slope: FloatArray
    clear: float = CLEAR

    @property
    def rotation(self) -> Rotation:
        """From the plane's axes to the world's, turning about a horizontal axis."""
        normal = np.array([-self.slope[0], -self.slope[1], 1.0])
        normal /= np.linalg.norm(normal)
        axis = np.array([-normal[1], normal[0], 0.0])
        sine = float(np.linalg.norm(axis))
        return Rotation.from_rotvec(axis * (np.arcsin(sine) / sine if sine > 0.0 else 0.0))

    def above(self, points: FloatArray) -> FloatArray:
        """Return the distance of (..., 3) points from the plane [m], positive above."""
        lift = points[..., 2] - self.height - points[..., :2] @ self.slope
        return np.asarray(lift / np.sqrt(1.0 + self.slope @ self.slope))


@dataclass(frozen=True)
class GroundPoints:
    """One point of the ground from each toss that gives one.

    Attributes
    ----------
    points
        (B, 3) [m]; what is in the rows of other tosses means nothing.
    use
        (B,) which tosses gave one.
    resting
        Whether they are from bodies at rest; else they are the lowest places that a corner reached.
    """

    points: FloatArray
    use: BoolArray
    resting: bool

    def planes(self, weights: FloatArray) -> FloatArray:
        """Return (S, 3) height [m] and slopes [-] for (S, B) weights of the tosses, by least squares.

        At least one of the tosses gives a point.
        """
        x = np.column_stack([np.ones(len(self.points)), self.points[:, :2]])
        w = weights * self.use
        w[~w.any(axis=1)] = self.use  # a resample without any of these tosses says no more than all of them
        normal = np.einsum("sb,bi,bj->sij", w, x, x)
        right = np.einsum("sb,bi,b->si", w, x, self.points[:, 2])
        # a shade of damping: a resample may hold one toss only
        normal += 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])

    def draws(self, weights: FloatArray) -> FloatArray:
        """Return planes (S, 3) of bootstrap samples (S, B), as wide as Student's interval of such a fit.

        Residuals are smaller than errors, by sqrt((n - d) / n), and the bootstrap takes the ones for the
        others.
        """
        tosses, plane = int(self.use.sum()), self.planes(np.ones((1, len(self.points))))
        free = max(1, tosses - plane.size)
        wider = np.sqrt(tosses / free) * stats.t.ppf(0.975, free) / stats.norm.ppf(0.975)
        return np.asarray(plane + wider * (self.planes(weights) - plane))


def ground_points(tosses: Tosses, corners: FloatArray, width: float) -> GroundPoints:
    """Return a point of the ground from each toss: the middle of what it rests on, or its lowest corner.

    `corners` (N, k, 3) are the lowest points of the body's spheres in every row [m], `width` its own [m].
    """
    ends = tosses.starts[1:] - 1
    last, early = tosses.poses[ends], tosses.poses[ends - (LAST - 1)]
    moved = np.linalg.norm(last[:, :3] - early[:, :3], axis=1)
    turned = (Rotation.from_quat(last[:, 3:7]) * Rotation.from_quat(early[:, 3:7]).inv()).magnitude()
    shift = moved / width + turned + np.abs(last[:, 7:] - early[:, 7:]).sum(axis=1)
    places = corners[ends]
    lowest = places[:, :, 2] - places[:, :, 2].min(axis=1, keepdims=True) < FLAT * width
    use = (lowest.sum(axis=1) >= min(3, places.shape[1])) & (shift < AT_REST * (LAST - 1) * tosses.dt)
    points = (places * lowest[..., None]).sum(axis=1) / lowest.sum(axis=1)[:, None]
    resting = bool(use.sum() >= max(FEWEST, len(tosses) // 4))
    if not resting:
        row, which = np.arange(len(corners)), corners[:, :, 2].argmin(axis=1)
        low = corners[row, which]
        rows = [
            a + int(low[a:b, 2].argmin()) for a, b in zip(tosses.starts[:-1], tosses.starts[1:], strict=True)
        ]
        points, use = low[rows], np.ones(len(tosses), dtype=bool)
    return without_outliers(GroundPoints(points, use, resting))


def without_outliers(found: GroundPoints) -> GroundPoints:
    """Drop points far from the plane through the others."""
    for _ in range(3):
        height, *slope = found.planes(np.ones((1, len(found.points))))[0]
        off = np.abs(GroundPlane(height, np.array(slope)).above(found.points))
        limit = OUTLIER * float(np.median(off[found.use])) + 1e-6
        keep = found.use & (off <= limit)
        if keep.sum() < FEWEST:
            break
        found = GroundPoints(found.points, keep, found.resting)
    return found
