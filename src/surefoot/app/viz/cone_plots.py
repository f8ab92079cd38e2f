"""Pictures of friction cones and their pyramids."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.shapes import ring
from surefoot.app.viz.style import BAD, FOOT_COLOURS, INK, MUTED, blank_figure, house_style, save
from surefoot.contact import FrictionCone, FrictionPyramid


def draw_pyramids(mu: float, facets: Sequence[int], path: Path) -> Path:
    """Draw inner and outer pyramids with several numbers of sides against the circle.

    One column per number of sides: the section at f_z = 1 above, the cone in 3-D below.
    """
    figure = blank_figure((2.9 * len(facets), 6.2))
    with house_style():
        for column, k in enumerate(facets):
            flat = figure.add_subplot(2, len(facets), column + 1)
            solid = figure.add_subplot(2, len(facets), len(facets) + column + 1, projection="3d")
            inner = FrictionCone(mu).polyhedral(k, "inner")
            outer = FrictionCone(mu).polyhedral(k, "outer")
            _section(flat, mu, inner, outer, first=column == 0)
            _solid(solid, mu, inner, outer)
        figure.suptitle(f"Friction cone of μ = {mu:g} and its pyramids; sections at $f_z$ = 1 N", color=INK)
    return save(figure, path)


def _section(axis: Any, mu: float, inner: FrictionPyramid, outer: FrictionPyramid, first: bool) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 240)
    axis.fill(mu * np.cos(angle), mu * np.sin(angle), color=FOOT_COLOURS[0], alpha=0.12, lw=0)
    axis.plot(mu * np.cos(angle), mu * np.sin(angle), color=FOOT_COLOURS[0], label="exact")
    for pyramid, colour, name in ((inner, FOOT_COLOURS[2], "inner"), (outer, BAD, "outer")):
        axis.plot(*ring(pyramid.rays)[:, :2].T, color=colour, label=name)
    axis.set_aspect("equal")
    span = 1.05 * float(np.abs(outer.rays[:, :2]).max(initial=1e-3))
    ticks = [-mu, 0.0, mu]
    axis.set(xlim=(-span, span), ylim=(-span, span), xlabel="$f_x$ [N]", xticks=ticks, yticks=ticks)
    axis.set_title(
        f"k = {inner.facets}: inner −{100 * inner.fit_error.radial:.1f} %, "
        f"outer +{100 * outer.fit_error.radial:.1f} %",
        fontsize=9,
    )
    if first:
        axis.set_ylabel("$f_y$ [N]")
        axis.legend(loc="upper left", fontsize=7, borderpad=0.0)


def _solid(axis: Any, mu: float, inner: FrictionPyramid, outer: FrictionPyramid) -> None:
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 60), np.linspace(0.0, 1.0, 2))
    around, across = mu * height * np.cos(angle), mu * height * np.sin(angle)
    # strides that leave a rest make a last face with fewer corners, which Matplotlib fills up with anything
    axis.plot_surface(around, across, height, color=FOOT_COLOURS[0], alpha=0.18, rstride=1, cstride=1)
    for pyramid, colour in ((inner, FOOT_COLOURS[2]), (outer, BAD)):
        axis.plot(*ring(pyramid.rays).T, color=colour, lw=1.0)
        for ray in pyramid.rays:
            axis.plot(*np.stack([np.zeros(3), ray], axis=1), color=colour, lw=0.6)
    span = float(np.abs(outer.rays[:, :2]).max(initial=1e-3))
    axis.set(xlim=(-span, span), ylim=(-span, span), zlim=(0, 1))
    axis.set(xticks=[-mu, 0.0, mu], yticks=[-mu, 0.0, mu], zticks=[0.0, 0.5, 1.0])
    axis.set_box_aspect((1, 1, 0.9))
    axis.tick_params(labelbottom=False, labelleft=False, labelright=False, colors=MUTED)
    for name in "xyz":
        getattr(axis, f"set_{name}label")(f"$f_{name}$", labelpad=-14)
    axis.view_init(elev=22, azim=-55)
