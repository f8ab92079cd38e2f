"""How every Surefoot picture looks: figures without pyplot's global state, colours, ranges, saving."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz import palette
from surefoot.app.viz.palette import BAD, FORCE, GOOD, GROUND, INK, MUTED, WARN, blend
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import needs

__all__ = [
    "BAD", "FOOT_COLOURS", "FORCE", "GOOD", "GROUND", "INK", "MUTED", "WARN", "at_least", "blank_figure",
    "draw_columns", "draw_foot_bars", "draw_friction_circle", "draw_panels", "fill_grid", "friction_colour",
    "house_style", "most_of", "new_axis", "new_figure", "new_grid", "new_panels", "save",
]  # fmt: skip

FOOT_COLOURS = palette.LINES

_STYLE = {
    "font.size": palette.TEXT_SIZE,
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.titlesize": palette.TITLE_SIZE,
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": palette.GRID,
    "grid.linewidth": palette.HAIR_WIDTH,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "text.color": INK,
    "legend.frameon": False,
    "lines.linewidth": palette.CURVE_WIDTH,
    "figure.facecolor": palette.PAPER,
    "savefig.facecolor": palette.PAPER,
}


def friction_colour(share: float) -> str:
    """Return the colour of a force that uses so much of its friction: green, orange, red at the border."""
    if share >= LEAST_SLIDING:
        return BAD
    return blend(GOOD, WARN, share)


LEAST_SLIDING = 0.999
"""Share of the friction from which a force is drawn as one at its cone's border."""


def new_figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 4.5), **subplots: Any
) -> tuple[Any, Any]:
    """Return a matplotlib figure and its (rows, columns) array of axes, in the package's style.

    `size` is in inches; further keywords go to `Figure.subplots` (for 3-D axes pass
    ``subplot_kw={"projection": "3d"}``).

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    with house_style():
        figure = blank_figure(size)
        axes = figure.subplots(rows, columns, squeeze=False, **subplots)
    return figure, axes


def new_axis(size: tuple[float, float], title: str = "", **labels: Any) -> tuple[Any, Any]:
    """Return a figure of one axis in the package's style, and the axis; `labels` are those of `Axes.set`."""
    figure, axes = new_figure(size=size)
    axes[0, 0].set(title=title, **labels)
    return figure, axes[0, 0]


def new_panels(
    labels: Sequence[str], size: tuple[float, float], title: str, xlabel: str = "time [s]", **subplots: Any
) -> tuple[Any, Any]:
    """Return a figure of panels below each other over one x axis, and their axes; a y label for each."""
    figure, axes = new_figure(len(labels), 1, size, **({"sharex": True} | subplots))
    for axis, label in zip(axes[:, 0], labels, strict=True):
        axis.set_ylabel(label)
    axes[0, 0].set_title(title)
    axes[-1, 0].set_xlabel(xlabel)
    return figure, axes[:, 0]


def new_grid(
    count: int, columns: int, panel: tuple[float, float], margin: tuple[float, float], **subplots: Any
) -> tuple[Any, list[Any]]:
    """Return a figure of so many panels in rows of at most so many `columns`, and their axes.

    `panel` is the size of each, `margin` what is around all of them [inches].
    """
    with house_style():
        figure = blank_figure()
        return figure, fill_grid(figure, count, columns, panel, margin, **subplots)


def fill_grid(
    figure: Any, count: int, columns: int, panel: tuple[float, float], margin: tuple[float, float],
    **subplots: Any,
) -> list[Any]:  # fmt: skip
    """Give an empty figure the panels of `new_grid` and the size that they take; return their axes."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure.set_size_inches(panel[0] * columns + margin[0], panel[1] * rows + margin[1])
    axes = figure.subplots(rows, columns, squeeze=False, **subplots)
    for axis in axes.flat[count:]:
        axis.set_axis_off()
    return list(axes.flat[:count])


def draw_columns(axis: Any, x: Any, columns: Any, names: Iterable[str], **line: Any) -> None:
    """Draw the columns of a (T, n) array over x, each in its own colour and with its name."""
    for k, name in enumerate(names):
        axis.plot(x, columns[:, k], **({"color": FOOT_COLOURS[k % 8], "label": name} | line))


def draw_foot_bars(axis: Any, bars: Mapping[str, Sequence[tuple[float, float]]]) -> None:
    """Draw when each foot is on the ground, the first above: name -> (begin, length) of its bars."""
    for k, (name, spans) in enumerate(bars.items()):
        row = len(bars) - 1 - k
        axis.broken_barh(spans, (row - 0.33, 0.66), color=FOOT_COLOURS[k % 8], label=name)
    axis.set_yticks(range(len(bars)), [*bars][::-1])
    axis.set(ylim=(-0.7, len(bars) - 0.3))
    axis.grid(axis="y", visible=False)


def draw_friction_circle(axis: Any, colour: str) -> None:
    """Draw the border of a cone in shares of the friction: the unit circle, and the range around it."""
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axis.fill(np.cos(angle), np.sin(angle), color=colour, alpha=0.10, lw=0)
    axis.plot(np.cos(angle), np.sin(angle), color=INK, lw=0.9)
    axis.set(aspect="equal", xticks=[-1, 0, 1], yticks=[-1, 0, 1])


def draw_panels(
    path: Path, x: FloatArray, panels: Mapping[str, tuple[Any, Sequence[str]]], title: str
) -> Path:
    """Write a picture of panels below each other over (n,) x [s]: label -> ((n, k) curves, their names)."""
    figure, axes = new_panels([*panels], (7.5, 0.9 + 1.5 * len(panels)), title)
    for axis, (curves, names) in zip(axes, panels.values(), strict=True):
        values = np.asarray(curves, dtype=np.float64).reshape(len(x), -1)
        draw_columns(axis, x, values, names)
        at_least(axis, values, 1e-3 * max(float(np.abs(values).max()), 1e-9))  # no magnified rounding
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8)
    return save(figure, path)


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the package's style inside this context; nothing global is left changed.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    chatter = logging.getLogger("matplotlib")  # of its caches, where HOME cannot be written: it makes others
    before = chatter.level
    chatter.setLevel(logging.ERROR)
    try:
        with needs("matplotlib", "viz"):
            import matplotlib.font_manager
        with matplotlib.rc_context(_STYLE):
            yield
    finally:
        chatter.setLevel(before)


def blank_figure(size: tuple[float, float] = (8.0, 4.5)) -> Any:
    """Return a matplotlib figure without axes, its size in inches."""
    with house_style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def save(figure: Any, path: Path) -> Path:
    """Write the figure to a new file and return its path; where the disk is full no half file stays."""
    try:
        with house_style():
            figure.savefig(path, dpi=130)
    except OSError:
        path.unlink(missing_ok=True)
        raise
    return path


ROOM = 0.08
"""Free room above and below the curves, as a share of the range."""


def at_least(axis: Any, values: FloatArray, least: float) -> None:
    """Give an axis a y range that holds all values (...), and is no smaller than `least`."""
    low, high = float(np.min(values, initial=np.inf)), float(np.max(values, initial=-np.inf))
    if not low <= high:
        low = high = 0.0
    short = max(least - (high - low), 0.0)
    room = ROOM * max(high - low, least)
    axis.set_ylim(low - 0.5 * short - room, high + 0.5 * short + room)


def most_of(axis: Any, time: FloatArray, values: FloatArray, low: float, high: float, unit: str = "") -> None:
    """Give an axis the y range (low, high), widened a little, and mark what is beyond it with its value.

    Parameters
    ----------
    axis
        Of matplotlib.
    time
        (T,) along x.
    values
        (T,) or (T, k) what is drawn.
    low, high
        Of the range, in the values' unit.
    unit
        Written behind a marked value.
    """
    columns = values.reshape(len(time), -1)
    axis.set_ylim(low, high)
    for extreme, edge, sign, level in ((columns.max(), high, "^", 0.97), (columns.min(), low, "v", 0.03)):
        if (extreme > edge) if edge == high else (extreme < edge):
            row = int(np.argwhere(columns == extreme)[0, 0])
            spot = (time[row], level)
            axis.plot(*spot, sign, color=BAD, ms=6, transform=axis.get_xaxis_transform(), zorder=5)
            axis.annotate(
                f"{extreme:.3g} {unit}".rstrip(), spot, xycoords=axis.get_xaxis_transform(),
                xytext=(6, 0), textcoords="offset points", color=BAD, fontsize=8, va="center", zorder=5,
            )  # fmt: skip
