"""How far each world is from each closed form, and what engines at their defaults make of a few scenes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from surefoot.experiments.experiment import WorldsOutcome
from surefoot.viz.style import BAD, FOOT_COLOURS, MUTED, new_figure, save

SMALLEST_SHARE = 1e-6
"""Shares of a tolerance below are drawn there."""


def draw_overview(outcomes: Sequence[WorldsOutcome], path: Path) -> Path:
    """Draw all experiments in one: how far each world is from each closed form, over its tolerance.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    worlds = list(dict.fromkeys(row.world for o in outcomes for row in o.rows))
    lines = list(dict.fromkeys((row.experiment, row.quantity) for o in outcomes for row in o.rows))
    figure, axes = new_figure(1, 1, size=(9.0, 1.2 + 0.22 * len(lines)))
    axis = axes[0, 0]
    axis.axvspan(1.0, 1e12, color="#f6e7e4")
    for k, world in enumerate(worlds):
        rows = [row for o in outcomes for row in o.rows if row.world == world]
        share = [max(row.error / row.tolerance, SMALLEST_SHARE) for row in rows]
        y = [
            -lines.index((row.experiment, row.quantity)) - 0.18 * (k - 0.5 * (len(worlds) - 1))
            for row in rows
        ]
        axis.plot(share, y, "o", ms=4.5, color=FOOT_COLOURS[k], label=world, clip_on=False)
        bad = [j for j, row in enumerate(rows) if row.verdict != "agrees"]
        axis.plot([share[j] for j in bad], [y[j] for j in bad], "x", ms=9, color=BAD)
    axis.set_xscale("log")
    shares = [row.error / row.tolerance for o in outcomes for row in o.rows]
    axis.set_xlim(SMALLEST_SHARE, 10.0 * max([1.0, *(s for s in shares if s < math.inf)]))
    axis.set_yticks(
        [-float(k) for k in range(len(lines))], [f"{e}: {q}" for e, q in lines], fontsize=7, color=MUTED
    )
    axis.set_xlabel(
        "distance from the closed form / tolerance (twice the world's own step error); right of 1: differs"
    )
    axis.legend(fontsize=8, ncol=len(worlds), loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return save(figure, path)


def draw_defaults(found: Mapping[str, Mapping[str, tuple[float, float]]], path: Path) -> Path:
    """Draw engines' errors over their cost, CPU seconds per simulated second, a panel for each scene.

    `found` is engine to scene to both. Hollow marks are engines at their defaults, filled ones tuned, stars
    ours; infinite errors stand at the top.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    from surefoot.experiments.engines.defaults import CASES, ENGINES

    cases = list(next(iter(found.values())))
    worlds = list(dict.fromkeys(ENGINES[engine].world for engine in found))
    marks = "os^DvP"
    figure, axes = new_figure(1, len(cases), size=(3.0 * len(cases) + 0.6, 4.8))
    for axis, case in zip(axes[0], cases, strict=True):
        for engine, by in found.items():
            world, own = (
                ENGINES[engine].world,
                [e for e in found if ENGINES[e].world == ENGINES[engine].world],
            )
            error, cost = by[case]
            colour = FOOT_COLOURS[worlds.index(world)]
            axis.loglog(
                cost, min(max(error, 1e-9), 10.0), marks[own.index(engine) % 6] if world != "rigid" else "*",
                mfc=colour if ENGINES[engine].tuned or world == "rigid" else "none", mec=colour, ms=8,
                label=engine, ls="",
            )  # fmt: skip
        unit = CASES[case].unit
        axis.set_title(f"{case} [{unit}]" if unit else case, fontsize=9, loc="left")
        axis.set_ylim(5e-10, 20.0)
    figure.supxlabel("CPU seconds per simulated second", fontsize=9)
    axes[0, 0].set_ylabel("distance from the closed form", fontsize=9)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), ncol=6, fontsize=7, loc="outside upper center")
    return save(figure, path)
