"""The picture of `surefoot bench forces`: how far from the exact forces, against the time it took."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefoot.viz.style import INK, MUTED, new_figure, save

CONE_COLOURS = {"exact": "#b3001b", "4": "#e08e0b", "8": "#2e933c", "16": "#1b6ca8"}
MARKERS = {
    "Surefoot": "*", "Clarabel": "o", "ECOS": "s", "SCS": "D", "DAQP": "^", "quadprog": "v",
    "ProxQP": "P", "OSQP": "X", "PIQP": "<", "HiGHS": ">",
}  # fmt: skip
FLOOR = 1e-10
"""Distances below this are drawn on it [N]."""


def plot_accuracy(rows: Sequence[Any], folder: Path) -> Path:
    """Draw median time and p99 against the worst distance to the exact forces, one panel per class.

    Parameters
    ----------
    rows
        Rows of `benchmarks.forces.race`.
    folder
        Where `forces.png` is written.
    """
    kinds = list(dict.fromkeys(row.instances for row in rows))
    columns = 2
    figure, axes = new_figure(
        (len(kinds) + 1) // columns, columns, size=(11.0, 8.6), sharex=True, sharey=True
    )
    for axis, kind in zip(axes.flat, kinds, strict=False):
        for row in rows:
            if row.instances == kind and row.solved > 0.5:
                _draw(axis, row)
        axis.set_title(kind, loc="left")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.grid(True, which="major")
    for axis in axes[-1]:
        axis.set_xlabel("time per call [µs]: median, line to the 99th percentile")
    for axis in axes[:, 0]:
        axis.set_ylabel("worst distance to the exact forces [N]")
    figure.suptitle(
        "Force distribution for four feet, through Python on one core: exact cones and facets", color=INK
    )
    _legend(figure)
    return save(figure, folder / "forces.png")


def plot_warm_starts(rows: Sequence[Any], folder: Path) -> Path:
    """Draw cold and warm times along trajectories: the compiled part, the call from Python, and p99.

    Parameters
    ----------
    rows
        Rows of `benchmarks.forces.warm`.
    folder
        Where `warm-starts.png` is written.
    """
    figure, axes = new_figure(1, 1, size=(9.0, 1.2 + 0.75 * len(rows)))
    axis = axes[0, 0]
    for k, row in enumerate(rows):
        for shift, colour, loop, whole in (
            (-0.19, "#1b6ca8", row.loop_cold, row.cold),
            (0.19, "#e08e0b", row.loop_warm, row.warm),
        ):
            y = k + shift
            inner, all_of_it, p99 = 1e6 * loop.median, 1e6 * whole.median, 1e6 * whole.p99
            axis.barh(y, inner, height=0.34, color=colour)
            axis.barh(y, all_of_it - inner, left=inner, height=0.34, color=colour, alpha=0.3)
            axis.plot([all_of_it, p99], [y, y], color=INK, linewidth=1.0)
            axis.plot([p99, p99], [y - 0.1, y + 0.1], color=INK, linewidth=1.0)
    names = [f"{row.trajectory}\n(cones active in {row.active:.0%})" for row in rows]
    axis.set_yticks(range(len(rows)), names)
    axis.invert_yaxis()
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.set_axisbelow(True)
    axis.set_xlim(left=0.0)
    axis.grid(True, axis="x")
    axis.set_xlabel(
        "time per call [µs]: solving (dark), the call from Python (light), 99th percentile (line)"
    )
    axis.set_title("Surefoot cold (blue) and warm-started (orange), along trajectories", loc="left")
    return save(figure, folder / "warm-starts.png")


def _draw(axis: Any, row: Any) -> None:
    """Draw one row as a marker with a line to its p99."""
    cone = row.cone.split()[0]
    colour = CONE_COLOURS[cone]
    outer, ours = row.cone.endswith("outer"), row.solver == "Surefoot"
    y = max(row.distance_worst, FLOOR)
    median, p99 = 1e6 * row.timing.median, 1e6 * row.timing.p99
    axis.plot([median, p99], [y, y], color=colour, alpha=0.35, linewidth=1.0, zorder=1)
    axis.scatter(
        [median], [y], marker=MARKERS[row.solver], s=170 if ours else 34, zorder=3 if ours else 2,
        facecolors="none" if outer or row.warm else colour, edgecolors=colour, linewidths=1.0,
    )  # fmt: skip
    if ours and not row.warm:
        axis.annotate(
            f"Surefoot\n{median:.1f} µs", (median, y), xytext=(9, 12), textcoords="offset points",
            color=colour, fontsize=9, fontweight="bold",
        )  # fmt: skip


def _legend(figure: Any) -> None:
    """Explain markers and colours below the panels."""
    from matplotlib.lines import Line2D

    def entry(marker: str, colour: str, label: str, hollow: bool = False) -> Any:
        return Line2D(
            [], [], linestyle="", marker=marker, color=colour, label=label,
            markerfacecolor="none" if hollow else colour, markersize=7,
        )  # fmt: skip

    handles = [entry(marker, MUTED, name) for name, marker in MARKERS.items()]
    handles += [
        entry("o", colour, "exact cone" if cone == "exact" else f"{cone} facets")
        for cone, colour in CONE_COLOURS.items()
    ]
    handles.append(entry("o", MUTED, "outer facets, or warm", hollow=True))
    figure.legend(handles=handles, loc="outside lower center", ncols=8, fontsize=8, frameon=False)
