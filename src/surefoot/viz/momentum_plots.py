"""Pictures of momentum: how it moves in flight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from surefoot.viz.style import FOOT_COLOURS, draw_columns, new_axis, new_figure, save

AXES = ("x", "y", "z")


def plot_components(
    path: Path,
    time: ArrayLike,
    panels: dict[str, tuple[ArrayLike, tuple[str, ...]]],
    title: str,
) -> Path:
    """Write a picture of one panel per entry below each other, sharing the time axis.

    Parameters
    ----------
    path
        Where the picture goes.
    time
        (n,) [s].
    panels
        Label of the vertical axis -> ((n, k) curves, their k names).
    title
        Heading.
    """
    figure, axes = new_figure(len(panels), 1, size=(7.5, 0.9 + 1.5 * len(panels)), sharex=True)
    for ax, (label, (curves, names)) in zip(axes[:, 0], panels.items(), strict=True):
        values = np.asarray(curves, dtype=np.float64).reshape(len(np.asarray(time)), -1)
        draw_columns(ax, time, values, names)
        ax.set_ylabel(label)
        size = float(np.abs(values).max())
        if np.ptp(values) < 1e-6 * size:  # a constant: no magnified rounding
            ax.set_ylim(values.mean() - 0.2 * size, values.mean() + 0.2 * size)
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8)
    axes[-1, 0].set_xlabel("time [s]")
    figure.suptitle(title, fontsize=10)
    return save(figure, path)


def plot_curves(
    path: Path,
    x: ArrayLike,
    curves: dict[str, ArrayLike],
    x_label: str,
    y_label: str,
    title: str = "",
    scales: tuple[str, str] = ("log", "linear"),
) -> Path:
    """Write a picture of named curves (n,) over x (n,); every second one as dots (the measured ones)."""
    xscale, yscale = scales
    figure, ax = new_axis((6.0, 3.6), title, xlabel=x_label, ylabel=y_label, xscale=xscale, yscale=yscale)
    for k, (name, y) in enumerate(curves.items()):
        style = "o" if k % 2 else "-"
        ax.plot(x, y, style, color=FOOT_COLOURS[k // 2 if len(curves) > 2 else k], label=name, markersize=4)
    for axis, scale in zip((ax.xaxis, ax.yaxis), scales, strict=True):
        if scale == "log":
            axis.set_minor_formatter("")
    ax.legend(fontsize=8)
    return save(figure, path)
