"""Impossible stretches of a motion played at another pace: the least change of time that mends them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.records.certificates.motion_report import MotionReport
from surefoot.records.motions.motion import Motion
from surefoot.records.motions.resampling import blend_configurations, blend_rows
from surefoot.records.repairs.repair_settings import RepairSettings

PACES = (0.9, 1.1, 0.8, 1.25, 0.7, 1.5, 0.6, 1.75, 0.5, 2.0)
"""Shares of a stretch's speed, the nearest to its own first [-]."""
HELPS = 0.1
"""Share of a stretch's frames that stay impossible at most, at a pace that is taken at once [-]."""


def pace_of(report: MotionReport, settings: RepairSettings) -> FloatArray:
    """Return the pace (T,) at which impossible stretches would have fewer impossible frames, 1 elsewhere."""
    pace = np.ones(len(report.motion))
    bad = np.flatnonzero(report.frames.verdict == "impossible")
    if not len(bad):
        return pace
    step = report.data.model.window.step
    beside = max(int(settings.stretch / step), 1)
    for group in np.split(bad, np.flatnonzero(np.diff(bad) > beside) + 1):
        pace[max(group[0] - beside, 0) : group[-1] + beside + 1] = _pace_of_stretch(report, group, settings)
    return np.asarray(np.exp(gaussian_filter1d(np.log(pace), settings.stretch / step, mode="nearest")))


def _pace_of_stretch(report: MotionReport, frames: IntArray, settings: RepairSettings) -> float:
    """Return the pace nearest to one that helps a stretch, or the one that helps most; 1 where none does."""
    best, least = 1.0, float(len(frames))
    for pace in PACES:
        if not settings.slowest <= pace <= 1.0 / settings.slowest:
            continue
        bound = report.data.solve(frames, pace=pace).bound[frames]
        left = float(np.sum(bound > report.impossible))
        if left < least:
            best, least = pace, left
        if left <= HELPS * len(frames):
            break
    return best


def warp(motion: Motion, pace: FloatArray) -> tuple[Motion, FloatArray]:
    """Return a motion played at (T,) paces, and where its frames were: (T',) in frames of the old one.

    Ends stay ends; the rate is the old one, so that frames become more or fewer.
    """
    length = np.concatenate([[0.0], np.cumsum(2.0 / (pace[1:] + pace[:-1]))])
    count = max(round(float(length[-1])) + 1, 2)
    at = np.interp(np.linspace(0.0, length[-1], count), length, np.arange(len(pace), dtype=np.float64))
    torques = None if motion.torques is None else blend_rows(motion.torques, at)
    q = blend_configurations(motion.robot, np.asarray(motion.q, dtype=np.float64), at)
    return replace(motion, q=q, torques=torques, extra={}), at
