"""Stretches of a motion that are impossible for one reason, and what would cure them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.frame_data import FrameData
from surefoot.records.certificates.frame_kernels import Answer
from surefoot.records.certificates.frame_table import FrameTable

JOINED = 0.1
"""Impossible frames no further apart than this are one segment [s]."""
PACES = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.0)
"""Shares of the motion's speed that are tried as a cure [-]."""


@dataclass(frozen=True)
class Segment:
    """A stretch of impossible frames.

    Attributes
    ----------
    start, end
        First and last impossible frame [s].
    first, last
        Their numbers.
    cause
        Of most of it, see `FrameTable`.
    worst
        Largest residual [m g].
    detour
        Largest way by which the centre of mass would have to leave its own, see `FrameTable` [m].
    where
        The joint or the part at fault; "" where it is all of it.
    cure
        What would mend it, in words.
    """

    start: float
    end: float
    first: int
    last: int
    cause: str
    worst: float
    detour: float
    where: str
    cure: str

    def __str__(self) -> str:
        name = f"{self.cause} ({self.where})" if self.where else self.cause
        return f"{self.start:.2f} to {self.end:.2f} s: {name}, {self.worst:.2f} m g: {self.cure}"


def find_segments(
    data: FrameData, answer: Answer, table: FrameTable, links: tuple[str, ...], limit: float
) -> tuple[Segment, ...]:
    """Return the impossible stretches of a motion, in order."""
    bad = np.flatnonzero(table.verdict == "impossible")
    if not len(bad):
        return ()
    gap = max(int(JOINED / data.model.window.step), 1)
    groups = np.split(bad, np.flatnonzero(np.diff(bad) > gap) + 1)
    return tuple(one for group in groups for one in _of_group(data, answer, table, links, limit, group))


def _of_group(
    data: FrameData, answer: Answer, table: FrameTable, links: tuple[str, ...], limit: float, group: IntArray
) -> Iterator[Segment]:
    causes, share = table.cause[group], table.share[group]
    names = sorted(set(causes.tolist()))
    weights = [float(share[causes == name].sum()) for name in names]
    cause = names[int(np.argmax(weights))]
    of_it = group[causes == cause]
    worst = int(of_it[np.argmax(table.share[of_it])])
    where, cure = _cure(data, answer, table, links, limit, cause, of_it, worst)
    yield Segment(
        float(table.time[group[0]]), float(table.time[group[-1]]), int(group[0]), int(group[-1]), cause,
        float(share.max()), float(table.detour[group].max()), where, cure,
    )  # fmt: skip


def _cure(
    data: FrameData, answer: Answer, table: FrameTable, links: tuple[str, ...], limit: float, cause: str,
    frames: IntArray, worst: int,
) -> tuple[str, str]:  # fmt: skip
    """Return what is at fault and what would cure it, in words."""
    if cause == "hangs":
        return "", f"lower the root by {100.0 * float(np.median(table.gap[frames])):.0f} cm"
    if cause == "dynamics in flight":
        return "", _flight(data, answer, frames)
    if cause == "slides":
        point, speed = _slider(data, worst)
        return links[point], f"hold it in place: it slides {speed:.1f} m/s"
    where = str(table.joint[worst])
    for pace in PACES:
        share = data.solve(np.array([worst]), pace=pace).share[worst]
        if share <= limit:
            return where, f"slow to {pace:.1f}" if pace else "slow down: standing still there is possible"
    if cause == "tips over the sole":
        side = answer.wrench[worst, 3:5] / (data.model.rules.mass * GRAVITY)
        return (
            where,
            f"no pace helps: bring the centre of mass {100.0 * float(np.linalg.norm(side)):.0f} cm nearer",
        )
    if where:
        return where, f"no pace helps: it lacks {abs(_most(answer.torques[worst])):.0f} N m"
    return where, "no pace helps: press the feet on the ground from above"


def _most(values: FloatArray) -> float:
    return float(values[np.argmax(np.abs(values))])


def _flight(data: FrameData, answer: Answer, frames: IntArray) -> str:
    """Return what gravity asks of a flight."""
    falls = GRAVITY - float(np.median(answer.needed[frames, 2])) / data.model.rules.mass
    if falls <= 0.0:
        return "it does not fall in the air: shorten the flight"
    pace = float(np.sqrt(GRAVITY / falls))
    return f"it falls at {falls:.1f} m/s², not at {GRAVITY:.2f}: play the flight at {pace:.2f} of its speed"


def _slider(data: FrameData, k: int) -> tuple[int, float]:
    """Return the point near the ground that slides most slowly at a frame, and its speed [m/s]."""
    near = np.flatnonzero(data.model.points.gaps[k] <= data.model.rules.clearance)
    if not len(near):
        near = np.array([int(np.argmin(data.model.points.gaps[k]))])
    at = min(k, len(data.model.points.slides) - 1)
    speeds = np.linalg.norm(data.model.points.slides[at, near], axis=1)
    best = int(np.argmin(speeds))
    return int(data.model.points.owner[near[best]]), float(speeds[best])
