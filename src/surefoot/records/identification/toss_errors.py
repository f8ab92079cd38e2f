"""How far simulated tosses are from recorded ones, and whether one simulator is nearer than another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.records.identification.tosses import Tosses, pose_differences

LOST = 10.0
"""Error, and deviation, in widths of what did not stay finite."""
EARLY = 0.034
"""Time after the first touch at which errors are given [s]: five frames of a camera of 148 Hz."""


@dataclass(frozen=True)
class TossErrors:
    """Mean errors over the frames of each toss.

    Attributes
    ----------
    position
        (B,) distance of the first link's origins, in widths of the body [-].
    rotation
        (B,) angle between the orientations of the first link [deg].
    early
        (B,) the distance `EARLY` after the first touch, of the same kind [-].
    """

    position: FloatArray
    rotation: FloatArray
    early: FloatArray


def deviations(tosses: Tosses, poses: FloatArray, width: float, arm: float) -> FloatArray:
    """Return (N, 6 + joints) how far poses (N, nq) are from the recorded ones, in widths of the body.

    A turn counts by the way of an arm [m], so that the square of a row is the corners' mean square distance.
    Rows of poses that are not finite, of a toss that blew up, are NaN.
    """
    good = np.all(np.isfinite(poses), axis=1)[:, None]
    out = pose_differences(np.where(good, poses, tosses.poses), tosses.poses)  # SciPy refuses NaN for a turn
    out[:, 3:] *= arm
    return np.where(good, out / width, np.nan)


class TossMeasure(NamedTuple):
    """By what tosses of a body are measured.

    Attributes
    ----------
    width, arm
        The unit of deviations [m], and by how much a turn counts [m].
    weights
        (N, m) of the deviations of certain tosses, see `frame_weights`; None for 1.
    """

    width: float
    arm: float
    weights: FloatArray | None = None

    def deviations(self, tosses: Tosses, poses: FloatArray) -> FloatArray:
        """Return (N, m) deviations of poses (N, nq), weighed; see the function."""
        rows = deviations(tosses, poses, self.width, self.arm)
        return rows if self.weights is None else rows * self.weights


def clip_deviations(rows: FloatArray) -> FloatArray:
    """Return deviations (N, m) cut off at `LOST`, NaN as `LOST`."""
    return np.asarray(np.clip(np.nan_to_num(rows, nan=LOST), -LOST, LOST))


def toss_errors(tosses: Tosses, poses: FloatArray, width: float, before: IntArray) -> TossErrors:
    """Return the errors of (N, nq) poses, row by row those of the tosses of a body so wide [m].

    `before` (B,) are the frames before the first touch.
    """
    rows = deviations(tosses, poses, width, width)
    away = np.nan_to_num(np.linalg.norm(rows[:, :3], axis=1), nan=LOST)
    turned = np.nan_to_num(np.degrees(np.linalg.norm(rows[:, 3:6], axis=1)), nan=180.0)
    late = np.minimum(before + round(EARLY / tosses.dt), tosses.frames - 1)
    position, rotation = (np.add.reduceat(e, tosses.starts[:-1]) / tosses.frames for e in (away, turned))
    return TossErrors(position, rotation, away[tosses.starts[:-1] + late])


def resample(tosses: int, count: int, seed: int) -> FloatArray:
    """Return (count, tosses) how often each toss is drawn in each bootstrap sample."""
    random = np.random.default_rng(seed)
    return random.multinomial(tosses, np.full(tosses, 1.0 / tosses), size=count).astype(np.float64)


@dataclass(frozen=True)
class Difference:
    """Mean of paired differences, ours less the rival's, and its 95 % bootstrap interval."""

    value: float
    low: float
    high: float


def paired_difference(ours: FloatArray, rival: FloatArray, seed: int = 0, count: int = 4000) -> Difference:
    """Return the mean of ours - rival over (B,) tosses, with its interval, in the unit of both.

    Raises
    ------
    ProblemError
        If they are not of the same tosses.
    """
    if ours.shape != rival.shape:
        raise ProblemError(f"errors of {ours.shape} and {rival.shape} tosses cannot be paired")
    gap = ours - rival
    means = resample(gap.size, count, seed) @ gap / gap.size
    low, high = np.percentile(means, [2.5, 97.5])
    return Difference(float(gap.mean()), float(low), float(high))
