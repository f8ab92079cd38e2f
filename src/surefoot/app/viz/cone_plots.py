"""Pictures of friction cones and their pyramids."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.viz.cone_drawings import draw_circle, draw_sides
from surefoot.app.viz.style import INK, MUTED, blank_figure, house_style, save
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
    draw_circle(axis, mu, "exact")
    for pyramid in (inner, outer):
        draw_sides(axis, pyramid)
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
    draw_circle(axis, mu)
    for pyramid in (inner, outer):
        draw_sides(axis, pyramid)
    span = float(np.abs(outer.rays[:, :2]).max(initial=1e-3))
    axis.set(xlim=(-span, span), ylim=(-span, span), zlim=(0, 1))
    axis.set(xticks=[-mu, 0.0, mu], yticks=[-mu, 0.0, mu], zticks=[0.0, 0.5, 1.0])
    axis.set_box_aspect((1, 1, 0.9))
    axis.tick_params(labelbottom=False, labelleft=False, labelright=False, colors=MUTED)
    for name in "xyz":
        getattr(axis, f"set_{name}label")(f"$f_{name}$", labelpad=-14)
    axis.view_init(elev=22, azim=-55)
