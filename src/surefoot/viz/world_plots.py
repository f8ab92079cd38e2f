"""One picture of one experiment: every world's line on the closed form's, and how far each is off."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.experiments.experiment import WorldsOutcome
from surefoot.viz.style import BAD, FOOT_COLOURS, INK, MUTED, new_figure, save

LEAST = 1e-16
"""Errors below count as this, so that a logarithmic axis can show them."""

SMALLEST_SHARE = 1e-6
"""Shares of a tolerance below are drawn there."""


def draw_outcome(outcome: WorldsOutcome, path: Path) -> Path:
    """Draw an experiment: left the worlds and the closed form, right errors on their tolerances.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    height = 3.4 + 0.16 * max(0, len(outcome.rows) - 8)
    figure, axes = new_figure(1, 2, size=(10.5, height), width_ratios=(1.0, 1.0))
    _draw_lines(axes[0, 0], outcome)
    _draw_errors(axes[0, 1], outcome)
    return save(figure, path)


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


def _draw_lines(axis: Any, outcome: WorldsOutcome) -> None:
    experiment, theory = outcome.experiment, outcome.experiment.theory()
    styles = ("-", "--", "-.", ":")
    for k, (world, seen) in enumerate(outcome.seen.items()):
        axis.plot(*seen.curve, styles[k % 4], color=FOOT_COLOURS[k], label=world, lw=1.8)
    axis.plot(theory.x, theory.y, color=INK, lw=0.8, label="closed form")
    axis.set(xlabel=experiment.axes[0], ylabel=experiment.axes[1])
    axis.set_title(f"{experiment.name}: {experiment.says}", fontsize=8, loc="left", wrap=True)
    axis.legend(fontsize=8)


def _draw_errors(axis: Any, outcome: WorldsOutcome) -> None:
    """Draw each row's error as a dot on the bar of its tolerance."""
    worlds = list(outcome.seen)
    quantities = list(dict.fromkeys(row.quantity for row in outcome.rows))
    places, labels = [], []
    for row in outcome.rows:
        group, place = quantities.index(row.quantity), worlds.index(row.world)
        y = -(group * (len(worlds) + 1) + place)
        floor = min(LEAST, 0.1 * row.tolerance)
        axis.barh(y, row.tolerance - floor, left=floor, height=0.7, color="#e3e7ea")
        good = row.verdict == "agrees"
        axis.plot(
            max(row.error, LEAST), y, "o" if good else "X", ms=5, color=FOOT_COLOURS[place] if good else BAD
        )
        places.append(y)
        labels.append(f"{row.quantity}, {row.world}" if place == 0 else row.world)
    axis.set_xscale("log")
    axis.set_xlim(left=0.3 * LEAST)
    axis.set_yticks(places, labels, fontsize=7, color=MUTED)
    axis.set_xlabel("distance from the closed form; bar: twice the world's own step error", fontsize=8)
    axis.grid(axis="y", visible=False)
    axis.set_xticks(np.logspace(-16, 0, 5))
