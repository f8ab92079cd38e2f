"""What stands on matplotlib's axes, read back: lines, words, arrows, and whether people can read it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.text import Annotation

from surefoot.app.viz.style import blank_figure
from surefoot.base.arrays import FloatArray


def new_axes(space: bool = False) -> Any:
    """Return axes of a figure of their own, plane ones or in space."""
    return blank_figure().add_subplot(projection="3d" if space else None)


def points_of(line: Any) -> FloatArray:
    """Return the (n, 2) points of a line."""
    return np.asarray(line.get_xydata(), dtype=np.float64)


def lines_in(axes: Any, colour: str) -> list[Any]:
    """Return the lines of a colour, in the order of drawing."""
    return [line for line in axes.lines if line.get_color() == colour]


def level_lines(axes: Any) -> list[float]:
    """Return the heights of lines across the whole axes."""
    both = (np.asarray(line.get_data(), dtype=np.float64) for line in axes.lines)
    return [float(y[0]) for x, y in both if x.tolist() == [0.0, 1.0] and y[0] == y[1]]


def texts_of(axes: Any) -> list[str]:
    """Return all words but those of arrows, titles and ticks."""
    return [text.get_text() for text in axes.texts if text.get_text()]


def arrows_of(axes: Any) -> list[Any]:
    """Return the arrows, whose `xyann` is where they start and `xy` is their tip."""
    return [text for text in axes.texts if isinstance(text, Annotation) and text.arrow_patch is not None]


def ends_of(arrow: Any) -> FloatArray:
    """Return the start and the tip of an arrow, (2, 2)."""
    return np.array([arrow.xyann, arrow.xy], dtype=np.float64)


def legend_of(axes: Any) -> list[str]:
    """Return the names in the legend."""
    return [text.get_text() for text in axes.get_legend().get_texts()]


def assert_legible(figure: Any) -> None:
    """Assert that no letters are too small or large to read, and no line too thin or thick to be one."""
    for axes in figure.axes:
        legend = axes.get_legend()
        words = [*axes.texts, *(legend.get_texts() if legend else ())]
        sizes = {float(text.get_fontsize()) for text in words if text.get_text()}
        assert all(6.5 <= size <= 9.5 for size in sizes), sizes
        widths = {float(line.get_linewidth()) for line in axes.lines if line.get_linestyle() != "None"}
        assert all(0.5 <= width <= 3.2 for width in widths), widths


def legend_place(axes: Any) -> FloatArray:
    """Return where the legend is held, in shares of the axes' width and height (2,)."""
    box = axes.get_legend().get_bbox_to_anchor()
    return np.asarray(axes.transAxes.inverted().transform((box.x0, box.y0)), dtype=np.float64)
