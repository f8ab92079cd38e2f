"""Where feet rest in a motion, how high its ground is there, and where the feet should be instead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import runs_of
from surefoot.records.certificates.frame_data import FrameData
from surefoot.records.certificates.touching_points import TouchingPoints
from surefoot.records.repairs.repair_settings import RepairSettings


@dataclass(frozen=True, eq=False)
class FootPaths:
    """The n feet of a motion of T frames.

    Attributes
    ----------
    rests
        (T, n) whether each rests [-].
    ground
        (T,) height of the ground that the motion was made for, above the real one [m].
    shifts
        (T, n, 3) by which each should be elsewhere: at rest on the ground and in one place, and between two
        such places on the way from one shift to the next [m].
    """

    rests: BoolArray
    ground: FloatArray
    shifts: FloatArray


def find_foot_paths(data: FrameData, points: TouchingPoints, settings: RepairSettings) -> FootPaths:
    """Return where the feet of a motion rest, and where they should."""
    arrays, step = data.model.points, data.model.window.step
    foot, count = points.foot[arrays.owner], len(arrays.gaps)
    lowest = arrays.gaps.min(axis=1)
    slow = np.linalg.norm(np.gradient(arrays.places, step, axis=0), axis=2) <= settings.rest
    low = arrays.gaps <= lowest[:, None] + settings.lowest
    ground = _ground(lowest, (slow & low).any(axis=1), settings.drift / step)
    feet = int(foot.max(initial=-1)) + 1
    rests, shifts = np.zeros((count, feet), dtype=np.bool_), np.zeros((count, feet, 3))
    for n in range(feet):
        own = foot == n
        rests[:, n] = slow[:, own].any(axis=1) & low[:, own].any(axis=1)
        heights = arrays.gaps[:, own].min(axis=1) - ground
        middle = arrays.places[:, own].mean(axis=1)
        shifts[:, n] = _shifts(middle, heights, rests[:, n], settings.handover / step)
    shifts[:, :, 2] -= ground[:, None]
    return FootPaths(rests, ground, shifts)


def _ground(lowest: FloatArray, rests: BoolArray, width: float) -> FloatArray:
    """Return the height of the ground (T,), straight between the times at which anything rests on it."""
    if not rests.any():
        return np.zeros(len(lowest))
    frames = np.arange(len(lowest))
    out = np.interp(frames, frames[rests], lowest[rests])
    return np.asarray(gaussian_filter1d(out, width, mode="nearest"))


def _shifts(places: FloatArray, heights: FloatArray, rests: BoolArray, width: float) -> FloatArray:
    """Return the shifts of one foot (T, 3): none along the ground in the middle of each rest."""
    out, frames = np.zeros((len(places), 3)), np.arange(len(places))
    if not rests.any():
        return out
    for first, end in runs_of(rests):
        middle = np.median(places[first:end, :2], axis=0)
        out[first:end, :2] = middle - places[first:end, :2]
        out[first:end, 2] = -heights[first:end]
    for axis in range(3):
        out[:, axis] = np.interp(frames, frames[rests], out[rests, axis])
    return np.asarray(gaussian_filter1d(out, width, axis=0, mode="nearest"))
