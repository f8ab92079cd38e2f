"""Pictures of what became of runs: transfers, replays, repairs, contact times, many verdicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.viz.style import BAD, FOOT_COLOURS, GOOD, INK, MUTED, WARN, draw_foot_bars
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.app.export.sequence import ContactSequence
    from surefoot.mechanics.statics.statics_batch import Verdicts
    from surefoot.records.audit.contact_times import ContactTimes
    from surefoot.records.repairs.repair_motion import Repair
    from surefoot.worlds.replay.windows import ReplayReport
    from surefoot.worlds.transfer.transfer import TransferReport


def draw_transfer(report: TransferReport, axes: Any) -> None:
    """Draw the share of success in each world with its 95 % interval, the reference first."""
    colours = {"lost": BAD, "gained": GOOD, "reference": INK}
    places = np.arange(len(report.worlds))[::-1]
    for place, row in zip(places.tolist(), report.worlds, strict=True):
        low, high = (100.0 * share for share in row.share)
        share = 100.0 * row.successes / row.runs
        colour = colours.get(row.verdict, MUTED)
        axes.plot([low, high], [place, place], color=colour, lw=2.5, solid_capstyle="butt")
        axes.plot(share, place, "o", color=colour, ms=6)
        said = f"{row.successes} of {row.runs}, {row.verdict}"
        axes.text(104.0, place, said, va="center", fontsize=8, color=INK)
    axes.set_yticks(places, [row.world for row in report.worlds])
    axes.set(
        xlim=(-2.0, 102.0), ylim=(-0.6, len(places) - 0.4), xlabel="runs that succeed [%], 95 % interval"
    )
    axes.grid(axis="y", visible=False)


def draw_replay(report: ReplayReport, axes: Any) -> None:
    """Draw how far the base is from the log's in each window, in green where the window holds."""
    if not report.windows:
        raise ProblemError(f"no window was replayed: {report.reason}")
    for window in report.windows:
        colour = BAD if window.lost else GOOD
        width = max(window.end - window.start, 1e-3)
        axes.bar(window.start, 100.0 * window.drift, width, align="edge", color=colour, ec="white", lw=1.0)
        axes.text(
            window.start + 0.5 * width, 100.0 * window.drift, f"{np.degrees(window.tilt):.1f}°",
            ha="center", va="bottom", fontsize=8, color=INK,
        )  # fmt: skip
    axes.margins(y=0.15)
    axes.set(xlabel="time of the log [s]", ylabel="base from the log's\nat the end [cm]")
    axes.set_title(f"in the world {report.world}: {report.verdict} (numbers: lean beside the log's)")


def draw_repair(repair: Repair, axes: Any) -> None:
    """Draw the residual of the motion as it was and as it is, and the limit beyond which no force is."""
    for report, colour, name in ((repair.before, MUTED, "before"), (repair.report, FOOT_COLOURS[0], "after")):
        share = 100.0 * report.impossible_share
        axes.plot(
            report.frames.time, report.frames.share, color=colour, label=f"{name}: {share:.1f} % impossible"
        )
    axes.axhline(repair.report.impossible, color=BAD, lw=0.9, ls="--", label="no force gives more")
    axes.set(xlabel="time [s]", ylabel="left over [m g]", title=repair.motion.name, ylim=(0.0, None))
    axes.legend(fontsize=8)


def draw_contact_times(times: ContactTimes, axes: Any) -> None:
    """Draw when each foot was on the ground, from its touchdowns and lift-offs."""
    ends = [float(one) for foot in times.feet for one in (*foot.touchdowns, *foot.lift_offs)]
    if not ends:
        raise ProblemError("no foot touched down or lifted off: there is nothing to draw")
    bars = {}
    for foot in times.feet:
        downs, ups = foot.touchdowns.tolist(), foot.lift_offs.tolist()
        stood = ups and ups[0] > min(ends) and (not downs or ups[0] < downs[0])
        first = [min(ends)] if stood else []
        spans = []
        for down in [*first, *downs]:
            up = next((one for one in ups if one > down), max(ends))
            spans.append((down, up - down))
        duty = "" if np.isnan(foot.duty_factor) else f", {100.0 * foot.duty_factor:.0f} %"
        bars[f"{foot.name}{duty}"] = spans
    draw_foot_bars(axes, bars)
    axes.set(xlabel="time [s]", title=f"on the ground, from {times.channel}")


def draw_sequence(sequence: ContactSequence, axes: Any) -> None:
    """Draw which frames touch when, phase by phase."""
    times = sequence.switching
    bars = {
        frame: [
            (float(times[k]), phase.duration)
            for k, phase in enumerate(sequence.phases)
            if frame in phase.names
        ]
        for frame in sequence.frames
    }
    draw_foot_bars(axes, bars)
    for time in times[1:-1]:
        axes.axvline(float(time), color=INK, lw=0.6, ls=":")
    axes.set(xlim=(0.0, sequence.duration), xlabel="time [s]")
    axes.set_title(f"{sequence.robot or 'contact sequence'}: {len(sequence.phases)} phases")


def draw_verdicts(verdicts: Verdicts, axes: Any) -> None:
    """Draw the margins of many stances, in colours of what was found."""
    colours = {"possible": GOOD, "undecided": WARN, "impossible": BAD}
    order = np.argsort(np.where(np.isfinite(verdicts.margin), verdicts.margin, -np.inf), kind="stable")
    margin, status = verdicts.margin[order], verdicts.status[order]
    place = np.arange(len(order))
    for name, colour in colours.items():
        chosen = status == name
        finite = chosen & np.isfinite(margin)
        if chosen.any():
            label = f"{name}: {int(chosen.sum())}"
            axes.plot(place[finite], margin[finite], ".", ms=3, color=colour, label=label)
    axes.axhline(0.0, color=MUTED, lw=0.8)
    axes.set(xlabel="stances, by margin", ylabel="margin [N]", title=f"{len(order)} stances")
    axes.legend(fontsize=8)
