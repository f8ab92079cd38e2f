"""What became of a log's windows in another world, and what that says of the log's success."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.drawn import Drawn
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot
from surefoot.records import Ending, Log, audit_log

WINDOW = 1.0
"""Time after which the replay starts again from the log's state [s]."""
PROGRESS = 0.8
"""Share of the log's way that a replay must make."""
TILT = math.radians(15.0)
"""Tilt beyond the log's that a replay may show [rad]."""
DRIFT = 0.25
"""A window may end away from the log by this share of the base's height and of the log's way."""
LEAST_WAY = 0.1
"""A log whose windows move the base by less in all has no way to lose [m]."""

Survival: TypeAlias = Literal["survives", "lost", "cannot tell"]
"""Every window holds in the other world; one is lost there and holds in the log's own; neither."""


@dataclass(frozen=True)
class WindowReplay:
    """What became of one window in one world.

    Attributes
    ----------
    start, end
        In the log's time [s]; `end` is where it fell if it did.
    outcome
        "done", "fell" or "invalid".
    way
        Of the base over the ground along the log's own, and the log's [m].
    logged_way
        The log's own [m].
    tilt
        Largest lean of the base against the log's at the same time [rad].
    drift
        Distance of the base from the log's at the end [m].
    broken
        Laws that were broken there, with their worst.
    lost
        Why it does not hold; empty where it does.
    """

    start: float
    end: float
    outcome: str
    way: float
    logged_way: float
    tilt: float
    drift: float
    broken: tuple[str, ...]
    lost: str


@dataclass(frozen=True, repr=False)
class ReplayReport(Drawn):
    """Whether a log's success survives in another world.

    Attributes
    ----------
    world, own
        Names of the worlds; `own` is empty where the log's own is not known here.
    verdict
        "survives", "lost" or "cannot tell".
    reason
        Why, in a line.
    windows, own_windows
        In the other world, and in the log's own where that was needed.
    logs
        Of the windows in the other world.
    subject
        What survives or is lost: the success of a robot that stays up, or the motion of anything.
    """

    world: str
    own: str
    verdict: Survival
    reason: str
    windows: tuple[WindowReplay, ...]
    own_windows: tuple[WindowReplay, ...]
    logs: tuple[Log, ...] = field(repr=False, default=())
    subject: str = "success"

    def __repr__(self) -> str:
        return f"ReplayReport({self.world!r}, {self.verdict!r}, {len(self.windows)} windows)"

    def __str__(self) -> str:
        return self.sentence[0].upper() + self.sentence[1:300] + "."

    @property
    def survives(self) -> bool:
        """Whether the verdict says so."""
        return self.verdict == "survives"

    @property
    def progress(self) -> float:
        """Ratio of the way in the other world to the log's; NaN for a log that goes nowhere."""
        return progress_of(self.windows)

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        said = {
            "survives": f"the {self.subject} survives in the world {self.world}",
            "lost": f"the {self.subject} is lost in the world {self.world}",
            "cannot tell": f"one cannot tell whether the {self.subject} survives in the world {self.world}",
        }
        return f"{said[self.verdict]}: {self.reason}"

    def as_dict(self) -> dict[str, Any]:
        """Return everything but the logs, for JSON."""
        own = {"sentence": self.sentence, "world": self.world, "own": self.own, "verdict": self.verdict}
        rows = {"windows": self.windows, "own_windows": self.own_windows}
        return {**own, "reason": self.reason, **{k: [asdict(w) for w in ws] for k, ws in rows.items()}}


def pieces_of(rows: int, row: float, window: float) -> list[tuple[int, int]]:
    """Return (first, last) rows of windows, for rows that last `row` seconds; a short rest is of the last."""
    length = max(2, round(window / row))
    starts = list(range(0, max(rows - length // 2, 1), length))
    return list(zip(starts, [*starts[1:], rows], strict=True))


def report_of(
    world: str,
    own: str,
    made: Sequence[tuple[WindowReplay, Log]],
    compared: Callable[[], tuple[WindowReplay, ...]],
    subject: str = "success",
) -> ReplayReport:
    """Return the report on windows and their logs; `compared` replays them in the log's own world."""
    windows, logs = tuple(w for w, _ in made), tuple(log for _, log in made)
    if not any(w.lost for w in windows) and not progress_of(windows) < PROGRESS:
        return ReplayReport(world, own, "survives", summary_of(windows), windows, (), logs, subject)
    home = compared()
    verdict, reason = compare_windows(windows, home, own)
    return ReplayReport(world, own, verdict, reason, windows, home, logs, subject)


def judge_window(
    start: float,
    outcome: str,
    seen: FloatArray,
    logged: FloatArray,
    height: float,
    again: Log,
    robot: Robot | None = None,
) -> WindowReplay:
    """Return what became of a window.

    Parameters
    ----------
    start
        In the log's time [s].
    outcome
        Of the replay, see `Ending`.
    seen, logged
        (n, 7) places [m] and quaternions x, y, z, w of the base, row by row.
    height
        Of the base over the ground at the start [m].
    again
        Log of the replay, which is audited, of a robot where it does not hold its own model.
    """
    end = start + float(again["time"][-1])
    planned, moved = logged[-1, :2] - logged[0, :2], seen[-1, :2] - seen[0, :2]
    length = float(np.linalg.norm(planned))
    tilt, way = largest_lean(seen, logged), float(moved @ planned) / length if length > 0.0 else 0.0
    drift = float(np.linalg.norm(seen[-1, :3] - logged[-1, :3]))
    report = audit_log(again, robot)
    first_of = {v.law: str(v) for v in reversed(report.violations)}
    broken = tuple(first_of[law] for law in report.laws_broken)
    lost = failure_reason(outcome, end, tilt, broken)
    if not lost and drift > DRIFT * (abs(height) + length):
        lost = f"it is {drift:.2f} m from the log at {end:.3f} s"
    return WindowReplay(start, end, outcome, way, length, tilt, drift, broken, lost)


def failure_reason(outcome: str, end: float, tilt: float, broken: tuple[str, ...]) -> str:
    """Return the reason why a window's replay fails; empty where it does not."""
    if outcome != Ending.DONE:
        return f"it {'falls' if outcome == Ending.FELL else 'cannot go on'} at {end:.3f} s"
    if tilt > TILT:
        return f"it leans {math.degrees(tilt):.0f} deg more than the log before {end:.3f} s"
    return f"it breaks {broken[0]}" if broken else ""


def largest_lean(q: FloatArray, logged: FloatArray) -> float:
    """Return the largest angle between the vertical axes of (n, 7) or wider poses over rows [rad]."""
    ups = [rotation_from_quaternion(part[:, 3:7])[:, :, 2] for part in (q, logged[: len(q)])]
    chord = np.linalg.norm(ups[0] - ups[1], axis=1)
    return float(2.0 * np.arcsin(min(0.5 * float(chord.max(initial=0.0)), 1.0)))


def progress_of(windows: tuple[WindowReplay, ...]) -> float:
    """Return the ratio of the windows' ways to the log's; NaN for a log that goes nowhere."""
    logged = sum(w.logged_way for w in windows)
    return sum(w.way for w in windows) / logged if logged >= LEAST_WAY else math.nan


def summary_of(windows: tuple[WindowReplay, ...]) -> str:
    """Return what all windows have in common, in a line."""
    share, count = progress_of(windows), len(windows)
    way = "" if math.isnan(share) else f", {100.0 * share:.0f} % of the log's way"
    lean = math.degrees(max(w.tilt for w in windows))
    drift = max(w.drift for w in windows)
    return (
        f"{count} window{'s' if count > 1 else ''} without a fall or a broken law{way}, at most {lean:.1f} "
        f"deg of lean and {drift:.3f} m from the log"
    )


def compare_windows(
    windows: tuple[WindowReplay, ...], own: tuple[WindowReplay, ...], name: str
) -> tuple[Survival, str]:
    """Return the verdict on windows of which one at least does not hold, by those in the log's own world."""
    failed = [k for k, w in enumerate(windows) if w.lost]
    if not own:
        why = (
            windows[failed[0]].lost if failed else f"it makes {100.0 * progress_of(windows):.0f} % of the way"
        )
        rest = "that is the log's own world" if name else "the log's own world is not here to compare"
        return "cannot tell", f"{why}, and {rest}"
    for k in failed:
        if not own[k].lost:
            return "lost", f"{windows[k].lost}; in the log's own world ({name}) the same replay holds"
    if not failed and not progress_of(own) < PROGRESS:
        shares = f"{100.0 * progress_of(windows):.0f} % of the log's way, {100.0 * progress_of(own):.0f} %"
        return "lost", f"it makes {shares} in the log's own world ({name})"
    why = f"in the log's own world ({name}) the same replay fails too"
    return "cannot tell", f"{why}: {next((w.lost for w in own if w.lost), 'it lags behind')}"
