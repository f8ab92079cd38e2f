"""How far simulated tosses are from recorded ones, and whether one simulator is nearer than another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError
from surefoot.estimation.tosses import Tosses

LOST = 10.0
"""Error in sides of a toss whose simulation did not stay finite."""


@dataclass(frozen=True)
class TossErrors:
    """Mean errors over the frames of each toss.

    Attributes
    ----------
    position
        (B,) distance of the centres, in sides of the cube [-].
    rotation
        (B,) angle between the orientations [deg].
    corners
        (B,) root mean square distance of the eight corners, in sides of the cube [-]: both in one number.
    """

    position: FloatArray
    rotation: FloatArray
    corners: FloatArray


def toss_errors(tosses: Tosses, poses: FloatArray) -> TossErrors:
    """Return the errors of (N, 7) poses (position [m], quaternion), row by row those of the tosses."""
    good = np.asarray(np.all(np.isfinite(poses), axis=1))
    poses = np.where(good[:, None], poses, tosses.states[:, :7])
    away = np.linalg.norm(poses[:, :3] - tosses.states[:, :3], axis=1)
    turn = Rotation.from_quat(poses[:, 3:]) * Rotation.from_quat(tosses.states[:, 3:7]).inv()
    angle = turn.magnitude()
    # the corners are at +-a: the mean of |(R1 - R2) c|² over them is a² |R1 - R2|² = 8 a² sin²(angle / 2)
    both = np.sqrt(away**2 + 8.0 * (tosses.cube.half_side * np.sin(0.5 * angle)) ** 2)
    side = tosses.cube.width
    rows = (np.where(good, away / side, LOST), np.where(good, np.degrees(angle), 180.0))
    every = (*rows, np.where(good, both / side, LOST))
    return TossErrors(*(np.add.reduceat(e, tosses.starts[:-1]) / tosses.frames for e in every))


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
