"""Drawings of cones on given axes: friction cones and pyramids, cones of wrenches in section, soles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.app.viz.shapes import ring
from surefoot.app.viz.style import BAD, FOOT_COLOURS, FORCE, INK, MUTED
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, count_of
from surefoot.contact import Fit
from surefoot.contact.cones import FrictionCone, FrictionPyramid, PolyhedralCone, Sole
from surefoot.mechanics.statics.wrench_cone import StanceCone

EXACT, INNER, OUTER = FOOT_COLOURS[0], FOOT_COLOURS[2], BAD
_MOST_MU = 50.0
"""A cone wider than this is drawn as one of this width."""
_ANGLES = 120
"""Directions in which the border of a section is looked for."""


def draw_friction_cone(cone: FrictionCone, axes: Any, facets: int | None = None, fit: Fit = "inner") -> None:
    """Draw a friction cone up to a normal force of one, in space or in section, beside a pyramid of its own.

    Parameters
    ----------
    cone, axes
        What is drawn where.
    facets, fit
        Of the pyramid; None for none.
    """
    mu = min(cone.mu, _MOST_MU)
    pyramid = None if facets is None else FrictionPyramid(mu, facets, fit)
    draw_circle(axes, mu, "exact")
    if pyramid is not None:
        draw_sides(axes, pyramid)
    span = max(mu, 0.05) if pyramid is None else float(np.abs(pyramid.rays[:, :2]).max(initial=0.05))
    _frame_cone(axes, span, f"friction cone, μ = {cone.mu:g}")


def draw_friction_pyramid(pyramid: FrictionPyramid, axes: Any) -> None:
    """Draw a pyramid up to a normal force of one, beside the cone that it stands for."""
    draw_circle(axes, pyramid.mu, "exact")
    draw_sides(axes, pyramid)
    error = 100.0 * pyramid.fit_error.radial
    sign = "−" if pyramid.fit == "inner" else "+"
    title = f"μ = {pyramid.mu:g}, {pyramid.facets} sides, {pyramid.fit}: {sign}{error:.1f} %"
    _frame_cone(axes, float(np.abs(pyramid.rays[:, :2]).max(initial=0.05)), title)


def draw_circle(axes: Any, mu: float, label: str = "") -> None:
    """Draw a friction cone up to a normal force of one: as a surface, or its section on plane axes."""
    if axes.name != "3d":
        angle = np.linspace(0.0, 2.0 * np.pi, 240)
        axes.fill(mu * np.cos(angle), mu * np.sin(angle), color=EXACT, alpha=0.12, lw=0)
        axes.plot(mu * np.cos(angle), mu * np.sin(angle), color=EXACT, label=label)
        return
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 60), np.linspace(0.0, 1.0, 2))
    # strides that leave a rest make a last face with fewer corners, which Matplotlib fills up with anything
    sheet = mu * height * np.cos(angle), mu * height * np.sin(angle), height
    axes.plot_surface(*sheet, color=EXACT, alpha=0.18, rstride=1, cstride=1)
    if label:
        axes.plot(*(part[1] for part in sheet), color=EXACT, lw=1.0, label=label)


def draw_sides(axes: Any, pyramid: FrictionPyramid) -> None:
    """Draw a pyramid up to a normal force of one: its edges, or its section on plane axes."""
    colour = INNER if pyramid.fit == "inner" else OUTER
    rim = ring(pyramid.rays)
    if axes.name != "3d":
        axes.plot(*rim[:, :2].T, color=colour, label=pyramid.fit)
        return
    axes.plot(*rim.T, color=colour, lw=1.0, label=pyramid.fit)
    for ray in pyramid.rays:
        axes.plot(*np.stack([np.zeros(3), ray], axis=1), color=colour, lw=0.6)


def _frame_cone(axes: Any, span: float, title: str) -> None:
    limit = (-1.05 * span, 1.05 * span)
    axes.set(xlim=limit, ylim=limit, xlabel="$f_x / f_z$", ylabel="$f_y / f_z$", title=title)
    if axes.name == "3d":
        axes.set(zlim=(0.0, 1.0), zlabel="$f_z$ [N]", xlabel="$f_x$ [N]", ylabel="$f_y$ [N]")
        axes.set_box_aspect((1, 1, 0.9), zoom=0.9)
        axes.locator_params(nbins=4)
        axes.tick_params(labelsize=7, pad=-1)
        axes.view_init(elev=22, azim=-55)
    else:
        axes.set_aspect("equal")
    axes.legend(fontsize=8, loc="upper left")


def draw_polyhedral_cone(cone: PolyhedralCone, axes: Any) -> None:
    """Draw the section of a cone of forces, or of wrenches without moments but those of its mean ray.

    Raises
    ------
    ProblemError
        For cones of other dimensions, or without a point whose third entry is positive.
    """
    if cone.dim not in (3, 6):
        raise ProblemError(f"a picture shows cones of forces (3) or wrenches (6), got dimension {cone.dim}")
    mean = cone.rays.mean(axis=0) if len(cone.rays) else np.zeros(cone.dim)
    if not mean[2] > 0.0:
        raise ProblemError("the cone has no forces along its third axis: there is no section to draw")
    _draw_section(
        axes, mean / mean[2], cone.contains, f"section of a cone of {count_of(len(cone.rays), 'ray')}"
    )


def draw_stance_cone(cone: StanceCone, axes: Any) -> None:
    """Draw which horizontal forces a stance can give for each newton of its normal forces, without moments.

    The section goes through the wrench of equal normal forces of all its points, and keeps its moments.
    """
    points = cone.stance.points()
    if not len(points):
        raise ProblemError("a stance without contacts gives no forces: there is nothing to draw")
    normals = np.tile([0.0, 0.0, 1.0 / len(points)], len(points))
    middle = points.grasp_map(cone.about) @ normals
    if not middle[2] > 0.0:
        raise ProblemError("the mean of the contacts' normals does not point up: there is no section to draw")
    title = f"forces of {len(cone.stance)} contacts together"
    _draw_section(axes, middle / middle[2], cone.contains, title)


def _draw_section(axes: Any, middle: FloatArray, contains: Callable[[FloatArray], Any], title: str) -> None:
    """Draw the points of a convex cone with the third entry of `middle` whose first two differ from it."""
    angle = np.linspace(0.0, 2.0 * np.pi, _ANGLES, endpoint=False)
    across = np.zeros((_ANGLES, len(middle)))
    across[:, 0], across[:, 1] = np.cos(angle), np.sin(angle)
    low, high = np.zeros(_ANGLES), np.full(_ANGLES, 1e-3)
    for _ in range(16):  # up to 65 times the normal force
        inside = np.asarray(contains(middle + high[:, None] * across))
        low, high = np.where(inside, high, low), np.where(inside, 2.0 * high, high)
    for _ in range(18):
        half = 0.5 * (low + high)
        inside = np.asarray(contains(middle + half[:, None] * across))
        low, high = np.where(inside, half, low), np.where(inside, high, half)
    border = ring((middle + low[:, None] * across)[:, :2])
    axes.fill(*border.T, color=EXACT, alpha=0.15, lw=0)
    axes.plot(*border.T, color=EXACT)
    axes.plot(*middle[:2], "+", color=INK, ms=8)
    axes.set(xlabel="$f_x / f_z$", ylabel="$f_y / f_z$", title=title, aspect="equal")


def draw_sole(sole: Sole, axes: Any) -> None:
    """Draw a sole from above, its edges by name, and the friction of each corner that carries its share."""
    corners = sole.corners
    axes.fill(*corners.T, color=MUTED, alpha=0.18, lw=0)
    axes.plot(*ring(corners).T, color=INK, lw=1.6)
    size = float(np.ptp(corners, axis=0).max())
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    radius = 0.25 * size * min(sole.mu, 2.0) / max(len(corners), 1)
    for corner in corners:
        disc = corner + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        axes.fill(*disc.T, color=FORCE, alpha=0.18, lw=0)
        axes.plot(*corner, "o", color=INK, ms=3)
    following = np.roll(corners, -1, axis=0)
    for name, start, end in zip(sole.edge_names, corners, following, strict=True):
        middle = 0.5 * (start + end)
        along = end - start
        turn = float(np.degrees(np.arctan2(along[1], along[0])))
        outwards = np.array([-along[1], along[0]]) / float(np.linalg.norm(along))  # the corners go clockwise
        label = {"ha": "center", "va": "center", "fontsize": 8, "color": INK}
        axes.annotate(name, middle + 0.05 * size * outwards, rotation=(turn + 90.0) % 180.0 - 90.0, **label)
    axes.plot(*sole.centre, "+", color=INK, ms=8)
    title = f"sole, {len(corners)} corners, μ = {sole.mu:g}"
    axes.set(xlabel="x [m]", ylabel="y [m]", title=title)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
