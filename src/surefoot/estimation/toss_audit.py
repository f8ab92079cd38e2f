"""Which frames of recorded tosses no lawful rigid contact explains, within noise or at all.

The laws are in `toss_laws`; noise is that of free flight, and each law exceeds what it may do once in a
hundred files by chance. Friction and the rounding of the corners are the upper ends of what `identify` finds.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from surefoot.arrays import IntArray, real_number
from surefoot.errors import ProblemError
from surefoot.estimation.free_flight import ENOUGH
from surefoot.estimation.ground_plane import GroundPoints, ground_points
from surefoot.estimation.identify import LEAST, identify, surroundings
from surefoot.estimation.toss_errors import resample
from surefoot.estimation.toss_laws import TossLaw, TossMotion, contact_cone, free_motion, penetration
from surefoot.estimation.tosses import Tosses

COARSE = 0.05
"""Noise limit of a corner's height, in sides, above which a recording tells nothing about contact."""
DRAWS, FITTED = 200, 48
"""Bootstrap samples, and tosses that the contact is fitted to."""
RESTING = 6
"""Tosses at rest that tell where the ground is, and how well."""
SMOOTH = 0.8
"""Noise of second differences, as a share of white noise's, below which the recording was smoothed."""


@dataclass(frozen=True)
class TossViolation:
    """Frames of a toss, one after the other, that no lawful rigid contact explains within noise.

    Attributes
    ----------
    law
        "penetration", "flight", "spin", "pull" or "friction".
    toss
        The toss's id.
    contact
        The corner that is deepest, or "cube".
    start, end
        Since the toss's first frame [s].
    frames
        How many.
    value, limit
        The worst of them, and what noise explains there, in `unit`.
    unit
        Of both.
    """

    law: str
    toss: int
    contact: str
    start: float
    end: float
    frames: int
    value: float
    limit: float
    unit: str


@dataclass(frozen=True)
class LawTally:
    """How many frames a law was judged in, and how many it fails in.

    Attributes
    ----------
    judged
        Frames.
    exact
        Frames that no lawful contact explains if the recording is taken as it is.
    beyond
        Those that it does not explain within noise either.
    jumps
        Of those, frames that are lawful once one frame next to it, or itself, is taken as displaced.
    tosses
        Tosses with frames beyond noise.
    """

    judged: int
    exact: int
    beyond: int
    jumps: int
    tosses: int


@dataclass(frozen=True)
class TossAudit:
    """What an audit of tosses says.

    Attributes
    ----------
    verdict
        "lawful" (some rigid contact explains every frame within noise), "broken" or "cannot tell".
    laws
        Law to its tally.
    tosses
        Id of a toss to its frames beyond noise, a number for each law; tosses without any are left out.
    violations
        Runs of frames beyond noise, law by law; none where one cannot tell.
    frames
        In all.
    explained, exact
        Frames beyond no law within noise, and those beyond no law without it.
    mu, rounding
        Friction of the cone, and radius of the corners [half sides], that frames were judged with.
    position_noise, rotation_noise
        Standard deviations in free flight [m, rad].
    rest_depth
        How deep the sharp corners of 95 of 100 resting cubes lie at most [m]: an error that stays.
    notes
        Why, and what to know.
    reason
        Why one cannot tell; empty for another verdict.
    """

    verdict: str
    laws: dict[str, LawTally]
    tosses: dict[int, dict[str, int]]
    violations: tuple[TossViolation, ...]
    frames: int
    explained: int
    exact: int
    mu: float
    rounding: float
    position_noise: float
    rotation_noise: float
    rest_depth: float
    notes: tuple[str, ...]
    reason: str = ""

    @property
    def lawful(self) -> bool:
        """Whether the verdict is "lawful"."""
        return self.verdict == "lawful"

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        if self.verdict == "cannot tell":
            return f"cannot tell whether the tosses are lawful ({self.frames} frames): {self.reason}"
        rest = self.frames - self.explained
        without = f"{self.frames - self.exact} without noise"
        if self.lawful:
            return f"lawful: rigid contact explains all {self.frames} frames within noise ({without} do not)"
        return (
            f"broken: no lawful rigid contact explains {rest} of {self.frames} frames within noise, "
            f"in {len(self.tosses)} tosses ({without})"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return everything by name, for JSON."""
        return {"sentence": self.sentence, **asdict(self)}


def audit_tosses(tosses: Tosses, mu: float | None = None, rounding: float | None = None) -> TossAudit:
    """Tell which frames of recorded tosses no lawful rigid contact explains, and whether noise explains them.

    Parameters
    ----------
    tosses
        Eight at least.
    mu, rounding
        Friction of the ground [-], and the radius of the corners [half sides]; None: the upper ends of what
        `identify` finds.

    Raises
    ------
    ProblemError
        If there are too few tosses, mu is no friction, or rounding is not from 0 to 1.
    """
    if len(tosses) < LEAST:
        raise ProblemError(f"an audit needs {LEAST} tosses or more for the ground, got {len(tosses)}")
    found = surroundings(tosses, resample(len(tosses), DRAWS, 0))
    friction = None if mu is None else real_number("mu", mu, low=0.0)
    radius = None if rounding is None else real_number("rounding", rounding, low=0.0, high=1.0)
    if friction is None or radius is None:
        fit = identify(tosses, most=min(FITTED, len(tosses)), resamples=DRAWS)
        friction = fit["mu"].high if friction is None else friction
        radius = fit["rounding"].high if radius is None else radius
    motion, points = TossMotion(tosses, found), ground_points(tosses)
    sharp, laws = penetration(motion, points), [penetration(motion, points, radius)]
    laws += [*free_motion(motion), *contact_cone(motion, friction)]
    broken = np.any([law.beyond for law in laws], axis=0)
    exact = np.any([law.exact for law in laws], axis=0)
    reason = _reason(found.flight.frames, points, laws[0], tosses)
    verdict = "cannot tell" if reason else ("broken" if broken.any() else "lawful")
    per_toss = {law.name: np.add.reduceat(law.beyond, tosses.starts[:-1], dtype=np.int64) for law in laws}
    ids = (
        {}
        if reason
        else {
            int(tosses.ids[k]): {name: int(count[k]) for name, count in per_toss.items()}
            for k in np.flatnonzero(np.sum(list(per_toss.values()), axis=0))
        }
    )
    depth = _rest_depth(motion, points)
    return TossAudit(
        verdict, {law.name: _tally(law, per_toss[law.name]) for law in laws}, ids,
        tuple(v for law in laws for v in _violations(law, motion) if not reason), len(tosses.states),
        int((~broken).sum()), int((~exact).sum()), friction, radius,
        motion.position_noise, motion.rotation_noise, depth,
        (*found.notes, *_why(laws, sharp, depth, motion, radius)), reason,
    )  # fmt: skip


def _reason(flown: IntArray, points: GroundPoints, deep: TossLaw, tosses: Tosses) -> str:
    """Return why one cannot tell; empty if one can."""
    if not (flown >= ENOUGH).any():
        return "no toss flies long enough to tell the noise of the recording"
    rest = int(points.use.sum())
    if not points.resting or rest < RESTING:
        return f"{rest if points.resting else 'too few'} of {len(tosses)} tosses tell where the ground is"
    limit = float(deep.limit.max())
    if limit > COARSE * tosses.cube.width:
        return f"noise alone may put a corner {1e3 * limit:.1f} mm into the ground"
    return ""


def _rest_depth(motion: TossMotion, points: GroundPoints) -> float:
    """Return how deep sharp corners of 95 of 100 resting cubes lie at most [m]; zero where none rests."""
    if not points.resting:
        return 0.0
    deepest = -motion.heights[motion.tosses.starts[1:][points.use] - 1].min(axis=1)
    return float(max(np.percentile(deepest, 95), 0.0))


def _tally(law: TossLaw, per_toss: IntArray) -> LawTally:
    beyond = law.beyond
    jumps = int((beyond & law.jump).sum())
    return LawTally(
        int(law.judged.sum()), int(law.exact.sum()), int(beyond.sum()), jumps, int((per_toss > 0).sum())
    )


def _violations(law: TossLaw, motion: TossMotion) -> Iterator[TossViolation]:
    """Yield the runs of frames beyond noise, ended by the ends of tosses."""
    tosses, bad = motion.tosses, np.flatnonzero(law.beyond)
    if not bad.size:
        return
    owner = tosses.owner
    cuts = np.flatnonzero((np.diff(bad) > 1) | (np.diff(owner[bad]) > 0)) + 1
    for run in np.split(bad, cuts):
        worst = run[np.argmax(law.value[run] / law.limit[run])]
        toss = owner[run[0]]
        first, last = ((run[[0, -1]] - tosses.starts[toss]) * tosses.dt).tolist()
        where = f"corner {int(motion.heights[worst].argmin())}" if law.name == "penetration" else "cube"
        yield TossViolation(
            law.name, int(tosses.ids[toss]), where, first, last + tosses.dt, len(run),
            float(law.value[worst]), float(law.limit[worst]), law.unit,
        )  # fmt: skip


def _why(
    laws: list[TossLaw], sharp: TossLaw, depth: float, motion: TossMotion, rounding: float
) -> Iterator[str]:
    """Yield what speaks for fiducials, and what for another contact than a sharp rigid cube's."""
    deep, rounded = sharp.beyond, laws[0].beyond
    if deep.any():
        stays = int((rounded & (laws[0].value <= depth)).sum())
        yield (
            f"sharp corners would be in the ground in {int(deep.sum())} frames; rounded by {rounding:.2f} "
            f"half sides, the most that the tosses allow, they are in {int(rounded.sum())}; corners of cubes "
            f"at rest are as deep as {1e3 * depth:.2f} mm (95 of 100), where nothing moves: an error of "
            f"fiducials, size or shape that stays, and {stays} of the frames are no deeper than that"
        )
    strays = [law for law in laws[1:] if law.beyond.any()]
    if strays:
        jumps = sum(int((law.beyond & law.jump).sum()) for law in strays)
        count = sum(int(law.beyond.sum()) for law in strays)
        yield (
            f"of {count} forces and moments that no contact gives, {jumps} are lawful once a single frame is "
            f"taken as displaced: a fiducial lost or taken for another"
        )
    if motion.smoothing < SMOOTH:
        yield (
            f"second differences in free flight have {motion.smoothing:.2f} of white noise's: the recording "
            f"was smoothed, and forces are spread over neighbouring frames"
        )
