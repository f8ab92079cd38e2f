"""What a certificate says of a motion: verdict, frames, segments, and the proof of each frame."""

from __future__ import annotations

import csv
import json
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, writing
from surefoot.base.text_files import free_path, plain_value
from surefoot.records.certificates.certificate_settings import CertificateSettings
from surefoot.records.certificates.frame_certificate import (
    FrameCertificate,
    certificate_of,
    link_wrenches,
)
from surefoot.records.certificates.frame_data import FrameData
from surefoot.records.certificates.frame_table import NO_WINDOW, FrameTable, MotionVerdict
from surefoot.records.certificates.segments import Segment
from surefoot.records.certificates.touching_points import TouchingPoints
from surefoot.records.motions.motion import Motion


@dataclass(frozen=True, eq=False, repr=False)
class MotionReport(Drawn):
    """Whether the ground and the motors could give the forces of a motion, frame by frame.

    Attributes
    ----------
    motion
        What was certified.
    frames
        Arrays over its frames.
    segments
        Its impossible stretches.
    window, noise
        Length of the window over which forces are averaged [s], and what the noise of the data amounts to in
        the needed wrench, one deviation [m g].
    possible, impossible
        Residuals up to which a frame is possible, and above which it is impossible [m g].
    notes
        What was assumed, and what was guessed when the motion was read, a line each.
    settings
        Of the certificate.
    needed
        (T, 6) force and moment about the centre of mass that the ground would have to give, world axes [N,
        N m].
    again
        The same question, of another motion of the robot.
    """

    motion: Motion
    frames: FrameTable
    segments: tuple[Segment, ...]
    window: float
    noise: float
    possible: float
    impossible: float
    notes: tuple[str, ...]
    settings: CertificateSettings
    data: FrameData
    points: TouchingPoints
    needed: FloatArray
    again: Callable[[Motion], MotionReport]

    @cached_property
    def judged(self) -> int:
        """Number of frames with a verdict."""
        return int(np.sum(self.frames.verdict != NO_WINDOW))

    @cached_property
    def impossible_share(self) -> float:
        """Share of the judged frames that are impossible [-]; NaN without any."""
        if self.judged == 0:
            return math.nan
        return float(np.sum(self.frames.verdict == "impossible")) / self.judged

    @cached_property
    def causes(self) -> dict[str, int]:
        """Number of impossible frames by their cause, the most frequent first."""
        counted = Counter(self.frames.cause[self.frames.verdict == "impossible"].tolist())
        return dict(counted.most_common())

    @cached_property
    def score(self) -> float:
        """Distance from possible, from 0 to 1: the mean over frames of residual over limit, 1 at most.

        NaN where no frame has a window.
        """
        share = self.frames.share[self.frames.verdict != NO_WINDOW]
        return float(np.mean(np.minimum(share / self.impossible, 1.0))) if len(share) else math.nan

    @cached_property
    def verdict(self) -> MotionVerdict:
        """The verdict of the whole motion.

        "impossible" where more than a share of `CertificateSettings.least_share` of its frames are,
        "possible" where no more than that are not possible, and "cannot tell" otherwise.
        """
        if self.judged == 0:
            return "cannot tell"
        if self.impossible_share > self.settings.least_share:
            return "impossible"
        doubtful = float(np.sum(self.frames.verdict == "cannot tell")) / self.judged
        return "possible" if doubtful + self.impossible_share <= self.settings.least_share else "cannot tell"

    def good(self, least: float = 1.0) -> tuple[tuple[float, float], ...]:
        """Return stretches (start, end) to train on, without an impossible frame, of `least` length [s]."""
        bad = np.flatnonzero(self.frames.verdict == "impossible")
        edges = np.concatenate([[-1], bad, [len(self.frames)]])
        out = []
        for first, last in zip(edges[:-1] + 1, edges[1:] - 1, strict=True):
            if last >= first and (last - first) / self.motion.rate >= least:
                out.append((float(self.frames.time[first]), float(self.frames.time[last])))
        return tuple(out)

    def certificate(self, frame: int) -> FrameCertificate:
        """Return the proof of a frame's verdict, checkable with NumPy alone; see `FrameCertificate`.

        Raises
        ------
        ProblemError
            For a frame that is none of the motion, or whose window is not whole.
        """
        k = whole_number("frame", frame)
        if k >= len(self.frames) or self.frames.verdict[k] == NO_WINDOW:
            reach = self.data.model.window.reach
            raise ProblemError(
                f"frame must have a whole window: {reach} to {len(self.frames) - 1 - reach}, got {k}"
            )
        return certificate_of(self.data, self.points, self.motion.robot.joint_names, k)

    def contact_wrenches(self) -> dict[str, FloatArray]:
        """Return what the best forces of each link that may touch the ground sum to.

        Returns
        -------
        dict
            (T, 6) force and moment about the centre of mass, world axes, by link [N, N m]; NaN without a
            window. Their sum, and what `frames` say is left, is `needed`, but for torque limits that bind.
        """
        return link_wrenches(self.data, self.points)

    def columns(self) -> dict[str, Any]:
        """Return columns by name: of `frames`, of the needed wrench and of `contact_wrenches`."""
        out = self.frames.columns()
        wrenches = {"needed": self.needed}
        wrenches |= {f"contact_{link}": wrench for link, wrench in self.contact_wrenches().items()}
        for name, wrench in wrenches.items():
            for k, axis in enumerate("xyz"):
                out[f"{name}_force_{axis}"] = wrench[:, k]
            for k, axis in enumerate("xyz"):
                out[f"{name}_moment_{axis}"] = wrench[:, 3 + k]
        return out

    def __repr__(self) -> str:
        frames, name = len(self.motion), self.motion.name
        return f"MotionReport({name!r}, {self.verdict!r}, {frames} frames, {len(self.segments)} segments)"

    def __str__(self) -> str:
        name, count = self.motion.name, len(self.frames)
        if self.judged == 0:
            return f"{name}: cannot tell: its {count} frames are fewer than a window of {self.window:.2f} s."
        bad = int(np.sum(self.frames.verdict == "impossible"))
        if not bad:
            most = float(np.nanmax(self.frames.share))
            return f"{name}: {self.verdict}: forces within friction and torques leave at most {most:.3f} m g."
        worst = max(self.segments, key=lambda s: s.worst * (s.last - s.first + 1))
        share = f"{bad} of {self.judged} frames ({100.0 * self.impossible_share:.1f} %)"
        return f"{name}: {self.verdict}: {share} need forces that nothing can give; {worst}."

    def as_dict(self) -> dict[str, Any]:
        """Return all but the frames as plain values."""
        return {
            "name": self.motion.name,
            "robot": self.motion.robot.name,
            "verdict": self.verdict,
            "score": self.score,
            "impossible_share": self.impossible_share,
            "frames": len(self.frames),
            "judged": self.judged,
            "causes": self.causes,
            "rate": self.motion.rate,
            "window": self.window,
            "noise": self.noise,
            "possible": self.possible,
            "impossible": self.impossible,
            "sentence": str(self),
            "segments": [asdict(s) for s in self.segments],
            "good": [list(g) for g in self.good()],
            "notes": list(self.notes),
        }

    def plain(self) -> dict[str, Any]:
        """Return `as_dict` with None for what is not finite, as JSON has it."""
        out: dict[str, Any] = plain_value(self.as_dict())
        return out

    def to_json(self, path: Path | str) -> Path:
        """Write verdict, segments and `columns` as JSON into a new file and return its path."""
        place = free_path(path)
        columns = plain_value(self.columns())
        text = json.dumps({**self.plain(), "columns": columns}, indent=1)
        with writing(place):
            place.write_text(text + "\n", encoding="utf-8")
        return place

    def to_csv(self, path: Path | str) -> Path:
        """Write `columns`, a row a frame, as CSV into a new file and return its path."""
        place, columns = free_path(path), self.columns()
        with writing(place), place.open("w", newline="", encoding="utf-8") as file:
            out = csv.writer(file)
            out.writerow(columns)
            out.writerows(zip(*plain_value(columns).values(), strict=True))
        return place
