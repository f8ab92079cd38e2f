"""Pictures of a sweep: survival over each parameter with its interval, and maps over pairs of parameters."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.app.viz.style import (
    BAD,
    FOOT_COLOURS,
    GROUND,
    INK,
    MUTED,
    blank_figure,
    fill_grid,
    house_style,
    new_grid,
    save,
)
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.worlds.sweep import SweepConfig, SweepResult
    from surefoot.worlds.sweep.survival import Margin

SURVIVED = FOOT_COLOURS[2]
MOST_MARGINS, MOST_MAPS = 9, 4
COLUMNS = 3


def draw_sweep(config: SweepConfig, table: Any, folder: Path) -> list[Path]:
    """Draw ``survival.png`` and, where two numbers or more are drawn, ``survival-map.png``.

    Parameters
    ----------
    config, table
        Of a `SweepResult`.
    folder
        Pictures of these names in it are replaced.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    from surefoot.worlds.sweep.survival import margins

    found = margins(config, table)
    pictures = [_draw_margins(config, found, folder / "survival.png")] if found else []
    pairs = config.maps or _pairs(config, found)
    if pairs:
        pictures.append(_draw_maps(config, table, pairs[:MOST_MAPS], folder / "survival-map.png"))
    return pictures


def _pairs(config: SweepConfig, found: list[Margin]) -> tuple[tuple[str, str], ...]:
    """Return the pairs among the three numbers that matter most."""
    numbers = [m for m in found if m.name in config.space.drawn]
    strongest = {m.name for m in sorted(numbers, key=lambda m: -m.effect())[:3]}
    return tuple(itertools.combinations([m.name for m in numbers if m.name in strongest], 2))


def _draw_margins(config: SweepConfig, found: list[Margin], path: Path) -> Path:
    """Draw the share that survived over each parameter."""
    figure = blank_figure()
    with house_style():
        _fill_margins(config, found, figure)
    return save(figure, path)


def draw_survival(result: SweepResult, figure: Any) -> None:
    """Draw the share that survived over each parameter into an empty figure."""
    from surefoot.worlds.sweep.survival import margins

    found = margins(result.config, result.table)
    if not found:
        raise ProblemError("nothing of this sweep was drawn from a range: there is nothing to draw")
    _fill_margins(result.config, found, figure)


def _fill_margins(config: SweepConfig, found: list[Margin], figure: Any) -> None:
    shown = sorted(found, key=lambda m: -m.effect())[:MOST_MARGINS]
    axes = fill_grid(figure, len(shown), COLUMNS, (3.4, 2.7), (0.6, 0.5))
    for axis, margin in zip(axes, shown, strict=True):
        _draw_margin(axis, config, margin)
    figure.suptitle(f"{config.name}: share that {config.experiment.goal}, with 95 % intervals", color=INK)


def _draw_margin(axis: Any, config: SweepConfig, margin: Margin) -> None:
    shares = margin.shares()
    middle = 0.5 * (margin.edges[:-1] + margin.edges[1:])
    if _log(config, margin.name):
        axis.set_xscale("log")
        middle = np.sqrt(margin.edges[:-1] * margin.edges[1:])
    value, low, high = (np.array([getattr(s, part) for s in shares]) for part in ("value", "low", "high"))
    axis.errorbar(middle, value, [value - low, high - value], fmt="o", ms=4, color=SURVIVED, ecolor=MUTED)
    if margin.name not in config.space.drawn:  # texts
        axis.set_xticks(middle, margin.labels, rotation=20)
    axis.set(xlabel=config.label(margin.name), ylim=(-0.03, 1.03))


def _draw_maps(config: SweepConfig, table: Any, pairs: tuple[tuple[str, str], ...], path: Path) -> Path:
    """Draw the share that survived over pairs of parameters, and the samples that did not."""
    from matplotlib.colors import LinearSegmentedColormap

    from surefoot.worlds.sweep.survival import survival_grid

    figure, axes = new_grid(len(pairs), COLUMNS, (4.1, 3.4), (0.9, 0.5))
    colours = LinearSegmentedColormap.from_list("survival", [BAD, GROUND, SURVIVED])
    for axis, pair in zip(axes, pairs, strict=True):
        x, y, number, survived = survival_grid(config, table, *pair)
        share = np.ma.masked_where(number == 0, survived / np.maximum(number, 1))
        image = axis.pcolormesh(x, y, share.T, cmap=colours, vmin=0.0, vmax=1.0)
        for name, scale in zip(pair, (axis.set_xscale, axis.set_yscale), strict=True):
            if _log(config, name):
                scale("log")
        axis.set(xlabel=config.label(pair[0]), ylabel=config.label(pair[1]))
        axis.grid(visible=False)
    with house_style():
        figure.colorbar(image, ax=figure.axes, label=f"share that {config.experiment.goal}")
        figure.suptitle(f"{config.name}: {table.num_rows} samples; white: none", color=INK)
    return save(figure, path)


def _log(config: SweepConfig, name: str) -> bool:
    return getattr(config.space.ranges[name], "scale", "") == "log"
