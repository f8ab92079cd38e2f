"""The pressure under a sole, as a pressure field gives it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.laws import CompliantSolid, PressureField, PressurePatch
from surefoot.viz.shapes import draw_sole
from surefoot.viz.style import FORCE, GROUND, INK, MUTED, new_figure, save

FINENESS = 24
"""Levels of a picture's colours."""


def draw_sole_pressures(
    field: PressureField,
    sole: CompliantSolid,
    load: float,
    centres: Sequence[tuple[float, float]],
    titles: Sequence[str],
    path: Path,
) -> list[PressurePatch]:
    """Draw the pressure under a sole at rest for several centres of pressure, one row each.

    Parameters
    ----------
    field, sole
        The contact.
    load
        Normal force on the sole [N].
    centres
        Where it acts, in the sole's axes [m].
    titles
        One for every row.
    path
        Where the picture goes.

    Returns
    -------
    The patches that are drawn.
    """
    found = [field.rest(sole, load, centre) for centre in centres]
    low = sole.corners[:, 2].min()
    rim = sole.corners[sole.corners[:, 2] <= low + 1e-12][:, :2]
    figure, axes = new_figure(len(found), 1, size=(6.4, 1.7 * len(found) + 0.6), sharex=True)
    for axis, (R, position, patch), title in zip(axes[:, 0], found, titles, strict=True):
        outline = draw_sole(axis, rim, GROUND, INK)
        for polygon, pressure in zip(patch.polygons, patch.pressures, strict=True):
            _shade(axis, (polygon - position) @ R, pressure, figure)
        centre = 1e3 * ((patch.centre - position) @ R)
        axis.scatter(*centre[:2], s=26, color=FORCE, edgecolor="white", zorder=4)
        axis.set_title(
            f"{title}: {1e4 * patch.area:.0f} cm² carry {load:.0f} N, at most {1e-3 * patch.largest:.0f} kPa",
            fontsize=9,
        )
        margin = 0.03 * float(np.ptp(outline, axis=0).max())
        limits = np.array([outline.min(axis=0) - margin, outline.max(axis=0) + margin])
        axis.set(xlim=limits[:, 0], ylim=limits[:, 1], aspect="equal")
        axis.set_ylabel("across [mm]", fontsize=9)
        axis.grid(False)
        axis.tick_params(colors=MUTED)
    figure.supxlabel("along the foot [mm]", fontsize=9)
    save(figure, path)
    return [patch for _, _, patch in found]


def _shade(axis: Any, corners: FloatArray, pressure: FloatArray, figure: Any) -> None:
    """Shade a wetted polygon by its pressure; the scale is its own."""
    fan = np.array([[0, k, k + 1] for k in range(1, len(corners) - 1)])
    x, y = 1e3 * corners[:, 0], 1e3 * corners[:, 1]
    levels = np.linspace(0.0, 1e-3 * float(pressure.max()), FINENESS)
    drawn = axis.tricontourf(x, y, fan, 1e-3 * pressure, levels=levels, cmap="viridis")
    figure.colorbar(drawn, ax=axis, label="kPa", format="%.0f", ticks=levels[:: FINENESS // 3])
