"""Picture of a friction cone and the pyramid that was asked for."""

from __future__ import annotations

from pathlib import Path

from surefoot.app.viz.cone_drawings import draw_friction_pyramid
from surefoot.app.viz.style import INK, blank_figure, house_style, save
from surefoot.contact import FrictionPyramid

MOST_SIDES = 360
"""A pyramid with more sides is drawn with so many: no eye tells it from its cone."""


def draw_pyramid(pyramid: FrictionPyramid, path: Path) -> Path:
    """Draw a pyramid beside its cone, in section and in space, into a new file."""
    shown = FrictionPyramid(pyramid.mu, min(pyramid.facets, MOST_SIDES), pyramid.fit)
    figure = blank_figure((9.0, 4.4))
    with house_style():
        for place, projection in ((1, None), (2, "3d")):
            axes = figure.add_subplot(1, 2, place, projection=projection)
            draw_friction_pyramid(shown, axes)
            axes.set_title("section at a normal force of 1 N" if projection is None else "up to 1 N")
        sides, error = pyramid.facets, 100.0 * pyramid.fit_error.radial
        does = f"gives up {error:.3g} %" if pyramid.fit == "inner" else f"overshoots by {error:.3g} %"
        title = f"μ = {pyramid.mu:g}: {pyramid.fit} pyramid of {sides} sides, {does} of the friction"
        figure.suptitle(title, color=INK, fontsize=10.5)
    return save(figure, path)
