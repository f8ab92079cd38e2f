"""The picture of `surefoot bench walk`: time per MPC step, and what pyramids give away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from surefoot.viz.style import FOOT_COLOURS, FORCE, INK, MUTED, new_figure, save


def plot_mpc_bench(bench: Any, folder: Path) -> Path:
    """Write walk.png from a `WalkBench`: every method's time per scene, and the friction it leaves unused."""
    scenes = list(dict.fromkeys(row.scene for row in bench.rows))
    methods = list(dict.fromkeys(row.method for row in bench.rows))
    figure, axes = new_figure(1, 2, size=(11.0, 4.8), width_ratios=[2.3, 1.0])
    _draw_times(axes[0, 0], bench.rows, scenes, methods)
    axes[0, 0].set_title(f"One MPC step, {bench.horizon} steps ahead: dot median, bar to the 99th percentile")
    _draw_lost(axes[0, 1], bench.rows, methods)
    return save(figure, folder / "walk.png")


def _colour(method: str, methods: list[str]) -> str:
    """Return a colour per solver; ours stands out."""
    solvers = list(dict.fromkeys(m.split(",")[0] for m in methods[1:]))
    palette = [c for c in FOOT_COLOURS if c != FORCE]
    return FORCE if method == methods[0] else palette[solvers.index(method.split(",")[0]) % len(palette)]


def _draw_times(ax: Any, rows: list[Any], scenes: list[str], methods: list[str]) -> None:
    """Draw one column of dots per method within each scene's band; hollow dots are the finer pyramids."""
    width = 0.8 / len(methods)
    for row in rows:
        place = scenes.index(row.scene) - 0.4 + (methods.index(row.method) + 0.5) * width
        colour = _colour(row.method, methods)
        low, high = 1e6 * row.timing.median, 1e6 * row.timing.p99
        ax.plot([place, place], [low, high], color=colour, linewidth=1.4)
        fill = "white" if "8 facets" in row.method else colour
        ax.plot([place], [low], "o", color=colour, markerfacecolor=fill, markersize=4.5)
    ax.set_yscale("log")
    ax.axhline(1000.0, color=MUTED, linewidth=0.9, linestyle="--")
    ax.annotate(
        "1 ms", (1.0, 1000.0), xycoords=("axes fraction", "data"), xytext=(3, 0),
        textcoords="offset points", va="center", fontsize=8, color=MUTED,
    )  # fmt: skip
    ax.set_xticks(range(len(scenes)), scenes)
    ax.set_xlim(-0.5, len(scenes) - 0.5)
    ax.grid(axis="x", visible=False)
    for edge in range(1, len(scenes)):
        ax.axvline(edge - 0.5, color=MUTED, linewidth=0.4)
    ax.set_ylabel("time per call [µs]")
    for method in methods:
        colour = _colour(method, methods)
        fill = "white" if "8 facets" in method else colour
        ax.plot([], [], "o", color=colour, markerfacecolor=fill, label=method, markersize=4.5)
    ax.legend(
        fontsize=7.5,
        ncols=5,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.08),
        handletextpad=0.2,
        frameon=False,
    )


def _draw_lost(ax: Any, rows: list[Any], methods: list[str]) -> None:
    """Draw the share of friction left unused, averaged over the scenes where the optimum uses all of it."""
    lost = [np.array([r.lost for r in rows if r.method == m and np.isfinite(r.lost)]) for m in methods]
    values = [100.0 * max(float(v.mean()), 0.0) if v.size else 0.0 for v in lost]
    places = np.arange(len(methods))[::-1]
    ax.barh(places, values, color=[_colour(m, methods) for m in methods], height=0.6, zorder=2)
    for place, value in zip(places, values, strict=True):
        ax.annotate(
            f"{value:.1f} %", (value, place), xytext=(4, 0), textcoords="offset points",
            va="center", fontsize=8, color=INK,
        )  # fmt: skip
    ax.set_yticks(places, methods, fontsize=8)
    ax.set_xlim(0.0, 1.25 * max([*values, 1.0]))
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("friction left unused [%]")
    ax.set_title("Feet at their friction limit")
