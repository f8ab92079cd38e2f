"""Pictures of softened complementarity: the regularised function, the way to a solution, what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.transcription.forms import fischer_burmeister, fischer_burmeister_eps
from surefoot.viz.style import BAD, FOOT_COLOURS, MUTED, new_figure, save

BOOK = (0.1, 0.01, 0.001)
"""Smoothings as books write them, in sqrt(a² + b² + eps²)."""
Trace = Sequence[tuple[float, int, float]]
"""(smoothing, iterations so far, max |min(a, b)|) of the stages of a continuation."""


def plot_function(folder: Path) -> Path:
    """Write the regularised function, its slope by a and its curvature along b = 0.02, for each smoothing."""
    figure, axes = new_figure(1, 3, size=(11.0, 3.6))
    b = 0.02
    a = np.linspace(-0.1, 0.2, 1201)
    for colour, book in zip(FOOT_COLOURS, BOOK, strict=False):
        eps = fischer_burmeister_eps(book)
        root = np.sqrt(a * a + b * b + 2.0 * eps)
        curves = (fischer_burmeister(a, b, eps), 1.0 - a / root, (b * b + 2.0 * eps) / root**3)
        for axis, curve in zip(axes[0], curves, strict=True):
            axis.plot(a, curve, color=colour, label=f"eps = {book:g}")
    axes[0, 0].plot(a, 2.0 * np.minimum(a, b), "--", color=MUTED, lw=0.9, label="2 min(a, b)")
    axes[0, 0].axhline(0.0, color=MUTED, lw=0.7)
    names = ("a + b - sqrt(a² + b² + eps²)", "slope by a", "curvature by a, with the other sign")
    for axis, name in zip(axes[0], names, strict=True):
        axis.set(title=name, xlabel=f"a, at b = {b:g}")
    axes[0, 2].set_yscale("log")
    axes[0, 0].legend(fontsize=8)
    return save(figure, folder / "fischer-burmeister.png")


def plot_heat_maps(folder: Path) -> Path:
    """Write heat maps of the function and of its gradient's length, with its zero, for each smoothing."""
    figure, axes = new_figure(2, len(BOOK), size=(10.5, 6.4), sharex=True, sharey=True)
    line = np.linspace(-0.1, 0.3, 401)
    a, b = np.meshgrid(line, line)
    for column, book in enumerate(BOOK):
        eps = fischer_burmeister_eps(book)
        root = np.sqrt(a * a + b * b + 2.0 * eps)
        value, gradient = fischer_burmeister(a, b, eps), np.hypot(1.0 - a / root, 1.0 - b / root)
        shown = ((value, "RdBu", -0.5, 0.5), (gradient, "viridis", 0.0, 2.0))
        for axis, (field, colours, low, high) in zip(axes[:, column], shown, strict=True):
            image = axis.pcolormesh(
                a, b, field, cmap=colours, vmin=low, vmax=high, shading="gouraud", rasterized=True
            )
            axis.contour(a, b, value, levels=[0.0], colors=BAD, linewidths=1.2)
            axis.set_aspect("equal")
            axis.grid(False)
            if column == len(BOOK) - 1:
                figure.colorbar(image, ax=axis, shrink=0.8)
        axes[0, column].set_title(f"eps = {book:g}")
        axes[1, column].set_xlabel("a")
    axes[0, 0].set_ylabel("function;  b")
    axes[1, 0].set_ylabel("length of its gradient;  b")
    return save(figure, folder / "fischer-burmeister-maps.png")


def plot_traces(folder: Path, traces: Mapping[tuple[str, str], Trace], name: str = "continuation") -> Path:
    """Write how the error of the laws falls with the iterations, a panel for each problem.

    Parameters
    ----------
    folder
        Where the picture goes.
    traces
        (problem, form) to the stages from one start.
    name
        Of the file, without its ending.
    """
    problems = list(dict.fromkeys(problem for problem, _ in traces))
    figure, axes = new_figure(1, len(problems), size=(max(3.1 * len(problems), 4.5), 4.4), sharey=True)
    forms = list(dict.fromkeys(form for _, form in traces))
    for axis, problem in zip(axes[0], problems, strict=True):
        for colour, form in zip(FOOT_COLOURS, forms, strict=False):
            stages = traces.get((problem, form), ())
            error = [max(e, 1e-13) if np.isfinite(e) else np.nan for _, _, e in stages]
            axis.semilogy([n for _, n, _ in stages], error, "o-", ms=3, color=colour, label=form)
        axis.axhline(1e-6, color=BAD, lw=0.9, ls="--")
        axis.set(title=problem, xlabel="iterations, first start")
    axes[0, 0].set_ylabel("max |min(a, b)|")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    return save(figure, folder / f"{name}.png")


def plot_motions(
    folder: Path, found: Mapping[str, tuple[float, Sequence[str], FloatArray, FloatArray]]
) -> Path:
    """Write the gaps and normal forces of a motion of each problem over time.

    Parameters
    ----------
    folder
        Where the picture goes.
    found
        Problem to the length of a knot [s], the contacts' names, and (N, p) gaps [m] and impulses [N s].
    """
    figure, axes = new_figure(2, len(found), size=(max(3.1 * len(found), 4.5), 5.0), sharex="col")
    for column, (name, (dt, contacts, gaps, impulses)) in enumerate(found.items()):
        time = dt * np.arange(1, len(gaps) + 1)
        _draw(axes[0, column], contacts, time, gaps)
        _draw(axes[1, column], contacts, time, impulses / dt)
        axes[0, column].set_title(name)
        axes[1, column].set_xlabel("time [s]")
        axes[0, column].legend(fontsize=7)
    axes[0, 0].set_ylabel("gap [m]")
    axes[1, 0].set_ylabel("normal force [N]")
    return save(figure, folder / "softened-motions.png")


def _draw(axis: Any, contacts: Sequence[str], time: Any, curves: FloatArray) -> None:
    """Draw a column of curves for each contact."""
    for k, name in enumerate(contacts):
        axis.plot(time, curves[:, k], ".-", ms=3, color=FOOT_COLOURS[k], label=name)
    if np.ptp(curves) < 1e-6:  # a constant: no magnified rounding
        axis.set_ylim(curves.mean() - 0.1, curves.mean() + 0.1)
