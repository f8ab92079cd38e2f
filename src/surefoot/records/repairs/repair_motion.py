"""The nearest motion that forces exist for, by certificates and shifts in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from surefoot.base.arrays import FloatArray, of_kind
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError
from surefoot.records.certificates.frame_table import NO_WINDOW
from surefoot.records.certificates.motion_report import MotionReport
from surefoot.records.motions.motion import Motion
from surefoot.records.repairs.com_shift import shift_com
from surefoot.records.repairs.foot_paths import FootPaths, find_foot_paths
from surefoot.records.repairs.leg_kinematics import follow_feet
from surefoot.records.repairs.repair_settings import RepairSettings
from surefoot.records.repairs.time_warp import pace_of, warp

ROUNDING = 1e-9
"""Difference of scores that is none: another processor gives another [-]."""


@dataclass(frozen=True, eq=False, repr=False)
class Repair(Drawn):
    """A mended motion, beside the one that it was.

    Attributes
    ----------
    motion
        The mended one, at the same rate.
    report, before
        Its certificate, and that of the motion as it was.
    joint_change, base_change
        Mean change of a joint [rad, m] and of the base's place, the drift of the ground taken out [m].
    times
        (T,) time in the motion as it was of every frame of the mended one [s].
    """

    motion: Motion
    report: MotionReport
    before: MotionReport
    joint_change: float
    base_change: float
    times: FloatArray

    def __repr__(self) -> str:
        return f"Repair({self.motion.name!r}, mended={self.mended:.3g})"

    @property
    def mended(self) -> float:
        """Share of the impossible frames that is none any more [-]; 1 where there were none."""
        return 1.0 - self.report.impossible_share / max(self.before.impossible_share, 1e-12)

    @property
    def is_warped(self) -> bool:
        """Whether some of it is played at another pace."""
        return len(self.times) != len(self.before.motion) or not np.array_equal(
            self.times, self.before.motion.times
        )

    def __str__(self) -> str:
        was, now = 100.0 * self.before.impossible_share, 100.0 * self.report.impossible_share
        changed = f"{self.joint_change:.3f} rad, the base by {100.0 * self.base_change:.1f} cm"
        longer = self.motion.duration - self.before.motion.duration
        lasts = f"; it lasts {self.motion.duration:.2f} s, by {longer:+.2f} s" if self.is_warped else ""
        return (
            f"{self.motion.name}: {was:.1f} % of its frames were impossible, {now:.1f} % are; "
            f"on average joints changed by {changed}{lasts}."
        )


def repair_motion(report: MotionReport, settings: RepairSettings | None = None) -> Repair:
    """Return the nearest motion that forces exist for, as far as one is found.

    Parameters
    ----------
    report
        Of `certify_motion`; what it assumes of friction, ground and window holds for the mended motion.
    settings
        What counts as a resting foot, and how far to go.

    Raises
    ------
    ProblemError
        For a motion that is shorter than a window, or was certified on a terrain.

    Notes
    -----
    Feet that rest come to the ground and stay in one place; the base follows the ground's drift. Then, in
    turn, the certificate gives the contact forces and what they leave, and least squares the smallest shift
    of the centre of mass that takes that; legs follow by inverse kinematics. Stretches that stay impossible
    are smoothed in time. The best of all tries within a mean change of the joints of 0.1 rad is taken,
    the motion itself where none is better. What is impossible then is played at another pace, slower where
    torques or friction do not suffice, or as fast as it would fall, if that mends it. Self-collision is not
    mended.
    """
    of_kind("report", report, MotionReport)
    if not report.judged:
        raise ProblemError("a repair needs a motion with a whole window, this one is shorter")
    if report.data.model.points.normals.shape[0] != 1:
        raise ProblemError("a repair is on level ground; this motion was certified on a terrain")
    chosen = RepairSettings() if settings is None else settings
    best = Repair(report.motion, report, report, 0.0, 0.0, report.motion.times)
    source = report
    for widen in (0.0, 1.0, 2.0):
        q = _calm(source, best.report, widen * chosen.calm)
        start = report.again(replace(report.motion, q=q))
        for one in _tries(report, start, chosen):
            if one.joint_change <= chosen.joints and _is_better(one.report, best.report):
                best = one
        if best.report.impossible_share == 0.0:
            break
    return _in_time(best, chosen)


def _in_time(best: Repair, settings: RepairSettings) -> Repair:
    """Return a repair whose impossible stretches are played at another pace, as long as that mends frames."""
    for _ in range(settings.paces):
        pace = pace_of(best.report, settings)
        if (pace == 1.0).all():
            break
        motion, at = warp(best.motion, pace)
        found = best.before.again(motion)
        if not _is_better(found, best.report):
            break
        times = np.interp(at, np.arange(len(best.times)), best.times)
        best = replace(best, motion=motion, report=found, times=times)
    return best


def _is_better(one: MotionReport, other: MotionReport) -> bool:
    """Return whether one has fewer impossible frames, or as many and a score lower by more than rounding."""
    if one.impossible_share != other.impossible_share:
        return bool(one.impossible_share < other.impossible_share)
    return bool(one.score < other.score - ROUNDING)


def _calm(report: MotionReport, judged: MotionReport, deviation: float) -> FloatArray:
    """Return configurations (T, nq) smoothed in the stretches that a repair left impossible."""
    q = report.motion.q.copy()
    if deviation == 0.0:
        return q
    width = deviation * report.motion.rate
    near = gaussian_filter1d((judged.frames.verdict == "impossible").astype(np.float64), 2.0 * width)
    weight = np.minimum(2.0 * near, 1.0)[:, None]
    flips = np.sign(np.einsum("ij,ij->i", q[1:, 3:7], q[:-1, 3:7]))
    q[1:, 3:7] *= np.cumprod(np.where(flips < 0.0, -1.0, 1.0))[:, None]
    q += weight * (gaussian_filter1d(q, width, axis=0, mode="nearest") - q)
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    return np.asarray(q)


def _tries(before: MotionReport, start: MotionReport, settings: RepairSettings) -> list[Repair]:
    """Return the motions on the way of shifts and certificates in turn."""
    robot, paths = before.motion.robot, find_foot_paths(start.data, start.points, settings)
    base = np.zeros((len(start.motion), 3))
    down = np.stack([np.zeros(len(base)), np.zeros(len(base)), paths.ground], axis=1)
    out: list[Repair] = []
    for _ in range(settings.rounds):
        q = follow_feet(robot, start.motion.q, base - down, paths.shifts)
        motion = replace(before.motion, q=q)
        found = before.again(motion)
        out.append(_repair(before, found, paths))
        if found.impossible_share == 0.0:
            break
        frames, rules = found.frames, found.data.model.rules
        left = np.nan_to_num(np.hstack([frames.force, frames.moment]))
        known = frames.verdict != NO_WINDOW
        needed = np.where(known[:, None], np.nan_to_num(found.needed), 0.0)
        window = found.data.model.window
        base = base + shift_com(left, needed, base, rules.mass, rules.arm, window, settings.reach)
    return out


def _repair(before: MotionReport, after: MotionReport, paths: FootPaths) -> Repair:
    """Return a try with what it changed."""
    was, now = before.motion.q, after.motion.q
    base = now[:, :3] - was[:, :3]
    base[:, 2] += paths.ground
    return Repair(
        after.motion, after, before, float(np.mean(np.abs(now[:, 7:] - was[:, 7:]))),
        float(np.mean(np.linalg.norm(base, axis=1))), before.motion.times,
    )  # fmt: skip
