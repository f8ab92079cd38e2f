"""Areas under the curve of certificates and of kinematic filters, on motions that were spoilt."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import surefoot as sf
from benchmarks.certify.corruptions import (
    CORRUPTIONS,
    Corruption,
    float_by,
    jitter,
    jump_root,
    paced,
    resampled,
    warped,
)
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.certificates.motion_report import MotionReport
from surefoot.records.motions.motion import Motion

RATE = 30.0
"""Of the motions that are spoilt [Hz]."""
METHODS = ("certificate", "CoM-CoP", "root jerk")


@dataclass(frozen=True)
class Detection:
    """How a corruption is found.

    Attributes
    ----------
    name
        Of the corruption.
    frames, clips
        Area under the curve by frames that were touched and by clips, of each of `METHODS` or of one measure.
    least_frames, least_clips
        What is expected of the first.
    named
        Share of the clips whose cause is one of the corruption's; NaN where none is expected.
    """

    name: str
    frames: tuple[float, ...]
    clips: tuple[float, ...]
    least_frames: float | None
    least_clips: float | None
    named: float

    @property
    def holds(self) -> bool:
        """Whether the first method does what is expected."""
        frames = self.least_frames is None or self.frames[0] >= self.least_frames
        clips = self.least_clips is None or self.clips[0] >= self.least_clips
        return frames and clips and not self.named < 0.9


def area(spoilt: FloatArray, clean: FloatArray) -> float:
    """Return the area under the curve: the chance that a spoilt value is above a clean one, ties by half."""
    from scipy.stats import rankdata

    n, m = len(spoilt), len(clean)
    ranks = rankdata(np.concatenate([spoilt, clean]))
    return float((ranks[:n].sum() - n * (n + 1) / 2.0) / (n * m))


def kinematics(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return two filters by frames (T,): distance of the CoM to the feet's middle [m], and root jerk [m/s³].

    The centre of pressure of a reference is taken for the middle of the feet within 2 cm of the ground, or of
    the lower one.
    """
    robot, step = motion.robot, 1.0 / motion.rate
    far = np.empty(len(motion))
    foot = np.asarray(robot.contact_points.foot)
    for k, q in enumerate(motion.q):
        places, lows = robot.foot_positions(q), np.asarray(robot.sphere_bottoms(q))
        low = np.array([lows[foot == n].min() for n in range(len(robot.feet))])
        near = low <= max(0.02, float(low.min()))
        far[k] = np.linalg.norm(robot.com(q)[:2] - places[near, :2].mean(axis=0))
    jerk = np.zeros(len(motion))
    if len(motion) > 3:
        jerk[1:-2] = np.linalg.norm(np.diff(motion.q[:, :3], 3, axis=0), axis=1) / step**3
    return far, jerk


@dataclass(frozen=True, eq=False)
class Measured:
    """A motion's report and the values (3, T) of `METHODS`."""

    report: MotionReport
    values: FloatArray

    @property
    def judged(self) -> BoolArray:
        """(T,) the frames with a verdict."""
        return np.isfinite(self.report.frames.share)

    @property
    def scores(self) -> FloatArray:
        """(3,) of the whole clip: its score, and the filters' means."""
        return np.array([self.report.score, *self.values[1:, self.judged].mean(axis=1)])


def measure(motion: Motion) -> Measured:
    """Certify a motion and filter it."""
    report = sf.certify_motion(motion.robot, motion)
    return Measured(report, np.stack([report.frames.share, *kinematics(motion)]))


def detect(motions: Sequence[Motion], seed: int = 0) -> list[Detection]:
    """Return how every corruption of motions is found."""
    slow = [resampled(motion, RATE) for motion in motions]
    clean = [measure(motion) for motion in slow]
    found = [_found(c, slow, clean, np.random.default_rng(seed)) for c in CORRUPTIONS]
    rng = np.random.default_rng(seed)
    found.append(_by_clips("double speed", [paced(m, 2.0) for m in slow], clean, 0.94))
    found.append(_by_clips("time warp", [warped(m, rng) for m in slow], clean, 0.90))
    shaken = Corruption("", jitter(3e-3))
    for name, corruption, column in (
        ("sinking 5 cm, by penetration", Corruption("", float_by(-0.05)), "penetration"),
        ("jitter 3 mm, by noise", shaken, "noise"),
        ("root jumps 5 cm, by noise", Corruption("", jump_root), "noise"),
    ):
        found.append(_by_column(name, corruption, column, slow, clean, rng))
    return found


def _found(
    corruption: Corruption, motions: Sequence[Motion], clean: Sequence[Measured], rng: np.random.Generator
) -> Detection:
    spoilt, touched = [], []
    for motion in motions:
        q, on = corruption.spoil(motion, rng)
        spoilt.append(measure(replace(motion, q=q)))
        touched.append(on & spoilt[-1].judged)
    bad = np.hstack([m.values[:, on] for m, on in zip(spoilt, touched, strict=True)])
    good = np.hstack([m.values[:, m.judged] for m in clean])
    frames = tuple(area(bad[k], good[k]) for k in range(3))
    clips = _clip_areas(spoilt, clean)
    named = [_cause(m.report) in corruption.causes for m in spoilt if m.report.segments]
    share = float(np.mean(named)) if corruption.causes and named else np.nan
    return Detection(corruption.name, frames, clips, corruption.frames, corruption.clips, share)


def _clip_areas(spoilt: Sequence[Measured], clean: Sequence[Measured]) -> tuple[float, ...]:
    a, b = (np.array([m.scores for m in group]) for group in (spoilt, clean))
    return tuple(area(a[:, k], b[:, k]) for k in range(3))


def _by_clips(name: str, motions: Sequence[Motion], clean: Sequence[Measured], least: float) -> Detection:
    return Detection(name, (), _clip_areas([measure(m) for m in motions], clean), None, least, np.nan)


def _by_column(
    name: str, corruption: Corruption, column: str, motions: Sequence[Motion], clean: Sequence[Measured],
    rng: np.random.Generator,
) -> Detection:  # fmt: skip
    """Return how well a column of the frames tells what was spoilt."""
    bad = []
    for motion in motions:
        q, touched = corruption.spoil(motion, rng)
        bad.append(getattr(sf.certify_motion(motion.robot, replace(motion, q=q)).frames, column)[touched])
    good = [getattr(m.report.frames, column) for m in clean]
    frames = area(np.concatenate(bad), np.concatenate(good))
    return Detection(name, (frames,), (), 0.98, None, np.nan)


def _cause(report: MotionReport) -> str:
    """Return the cause of most impossible frames of a motion."""
    causes = report.frames.cause
    return str(Counter(causes[causes != ""].tolist()).most_common(1)[0][0])
