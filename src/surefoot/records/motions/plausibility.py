"""Plausibility of a motion: feet that stand stay in place and flat, joints stay in their ranges.

Everything is compared frame with frame, so that no rate is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.libraries import import_pinocchio

if TYPE_CHECKING:
    from surefoot.mechanics import Robot

SAMPLES = 120
"""Pairs of frames that a motion is judged by, evenly over it."""
APART = 2
"""Frames from one of a pair to the other: a fifteenth of a second at 30 Hz."""
STILL = 2e-3
"""Motion between the frames of a pair that tells nothing [m]."""
WEIGHT_SLIDE, WEIGHT_CENTRE, WEIGHT_LEAN = 5.0, 3.0, 0.5
"""Weights of the parts of `Plausibility.cost` beside a radian of tilt or of a range left: found on the 40
motions of LAFAN1, seven of PBHC and thirteen of ../shared, so that each costs less as it is than with its
quaternion turned about, inverse, its joints in breadth-first or random order, or its sides exchanged
(`python -m benchmarks.motion_reading`, 2026-11-26).
"""


@dataclass(frozen=True)
class Plausibility:
    """How plausible a reading is, each part small where it is right.

    Attributes
    ----------
    tilt
        Median angle [rad] of the flattest sole; zero for point feet.
    slide
        Motion of the foot that moves least, as a share of what all feet and the base move together.
    excess
        Angles beyond the joints' ranges, summed over the joints, mean over the frames [rad].
    centre
        Mean square of the angles' places in their ranges: 0 in the middle, 1 at the ends.
    lean
        One less the cosine of the base's tilt, median.
    """

    tilt: float
    slide: float
    excess: float
    centre: float
    lean: float

    @property
    def cost(self) -> float:
        """All parts together."""
        parts = (
            WEIGHT_SLIDE * self.slide, WEIGHT_CENTRE * min(self.centre, 2.0), WEIGHT_LEAN * self.lean
        )  # fmt: skip
        return self.tilt + min(self.excess, 5.0) + sum(parts)

    def __str__(self) -> str:
        return (
            f"the steadiest foot moves {100.0 * self.slide:.0f} % of what feet and base move and tilts "
            f"{np.degrees(self.tilt):.0f}°, joints leave their ranges by {self.excess:.2f} rad"
        )


@dataclass(frozen=True)
class Ranges:
    """Ranges of a robot's joints: middles and halves [rad], (joints,) each."""

    middle: FloatArray
    half: FloatArray

    def excess(self, angles: FloatArray) -> FloatArray:
        """Return how far angles (..., joints) are beyond the ranges [rad]."""
        return np.maximum(np.abs(angles - self.middle) - self.half, 0.0)

    def column_costs(self, columns: FloatArray) -> FloatArray:
        """Return how badly columns (T, n) of angles fit each joint's range: (n, joints)."""
        rows = columns[np.unique(np.linspace(0, len(columns) - 1, SAMPLES).astype(np.int64))]
        place = (rows[:, :, None] - self.middle) / self.half
        beyond = np.maximum(np.abs(place) - 1.0, 0.0) * self.half
        fit = WEIGHT_CENTRE * np.minimum(place**2, 2.0) / len(self.half) + np.minimum(beyond, 1.0)
        return np.asarray(fit.mean(axis=0))


def ranges_of(robot: Robot) -> Ranges:
    """Return the ranges of a robot's joints; a turn where the model gives none."""
    first = int(robot.model.nq) - robot.joints
    low = np.array(robot.model.lowerPositionLimit[first:], dtype=np.float64)
    high = np.array(robot.model.upperPositionLimit[first:], dtype=np.float64)
    known = np.isfinite(low) & np.isfinite(high) & (high > low) & (high - low < 4.0 * np.pi)
    low, high = np.where(known, low, -np.pi), np.where(known, high, np.pi)
    return Ranges(0.5 * (low + high), np.maximum(0.5 * (high - low), 0.05))


def sample_pairs(count: int) -> tuple[IntArray, IntArray]:
    """Return first and second frames (k,) of the pairs that a motion of `count` frames is judged by."""
    apart = min(APART, count - 1)
    first = np.unique(np.linspace(0, count - 1 - apart, min(SAMPLES, count - apart)).astype(np.int64))
    return first, first + apart


def judge(robot: Robot, ranges: Ranges, q: FloatArray, pairs: tuple[IntArray, IntArray]) -> Plausibility:
    """Return how plausible a motion is.

    Parameters
    ----------
    robot, ranges
        The robot, and the ranges of its joints.
    q
        (T, nq) configurations [m, -, rad], quaternions of length one.
    pairs
        Frames to compare, see `sample_pairs`.
    """
    at = np.stack(pairs, axis=1)
    angles = q[at[:, 0], int(robot.model.nq) - robot.joints :]
    excess = float(ranges.excess(angles).sum(axis=1).mean())
    centre = float((((angles - ranges.middle) / ranges.half) ** 2).mean())
    if not robot.floating:
        return Plausibility(0.0, 0.0, excess, centre, 0.0)
    lean = float(np.median(2.0 * (q[at[:, 0], 3] ** 2 + q[at[:, 0], 4] ** 2)))
    tilt, slide = (0.0, 0.0) if not robot.feet else _feet(robot, q, at)
    return Plausibility(tilt, slide, excess, centre, lean)


def _feet(robot: Robot, q: FloatArray, at: IntArray) -> tuple[float, float]:
    """Return the tilt [rad] and slide of the steadiest foot, medians over the pairs (k, 2) that move."""
    pinocchio = import_pinocchio()
    model, data = robot.model, robot.model.createData()
    places = np.empty((*at.shape, len(robot.feet), 3))
    axes = np.empty((*at.shape, len(robot.feet), 3, 3))
    for index in np.ndindex(*at.shape):
        pinocchio.framesForwardKinematics(model, data, q[int(at[index])])
        for foot, one in enumerate(robot.feet):
            pose = data.oMf[one.frame]
            places[index][foot], axes[index][foot] = pose.translation, pose.rotation
    flat = [foot for foot, one in enumerate(robot.feet) if one.flat]
    tilt = 0.0
    if flat:
        tilt = float(np.median(np.arccos(np.clip(axes[:, 0, flat, 2, 2], -1.0, 1.0)).min(axis=1)))
    moves = np.empty((len(at), len(robot.feet)))
    for foot, one in enumerate(robot.feet):
        points = places[:, :, foot, None] + np.einsum("kpij,cj->kpci", axes[:, :, foot], one.centres)
        moves[:, foot] = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1).mean(axis=1)
    base = np.linalg.norm(q[at[:, 1], :3] - q[at[:, 0], :3], axis=1)
    whole = moves.sum(axis=1) + base
    busy = whole >= 0.5 * np.median(whole)
    return tilt, float(np.median((moves.min(axis=1) / (whole + STILL))[busy]))
