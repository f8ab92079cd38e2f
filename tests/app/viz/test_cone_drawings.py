"""Drawings of cones and soles: borders where Coulomb's law has them, in colours that say which cone it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import surefoot as sf
from surefoot.app.viz.cone_drawings import (
    draw_circle,
    draw_friction_cone,
    draw_friction_pyramid,
    draw_polyhedral_cone,
    draw_sides,
    draw_sole,
    draw_stance_cone,
)
from surefoot.app.viz.style import BAD, FOOT_COLOURS, FORCE, INK, MUTED
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact.cones import FrictionCone, PolyhedralCone, Sole
from tests.app.viz.drawn_axes import assert_legible, legend_of, lines_in, new_axes, points_of, texts_of

EXACT, INNER, OUTER = FOOT_COLOURS[0], FOOT_COLOURS[2], BAD


def sized(points: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(points[:, 0], points[:, 1]), dtype=np.float64)


def places_of(line: Any) -> FloatArray:
    """Return the (n, 3) points of a line in space."""
    return np.array(line.get_data_3d(), dtype=np.float64).T


def assert_full_circle(points: FloatArray, radius: float) -> None:
    np.testing.assert_allclose(sized(points), radius, rtol=1e-9)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() < radius * np.radians(8.0)
    assert np.linalg.norm(points[0] - points[-1]) < 1e-9 + 1e-9 * radius
    assert steps.sum() == pytest.approx(2.0 * np.pi * radius, rel=1e-2)


def test_the_section_of_a_friction_cone_is_a_circle_of_mu() -> None:
    axes = new_axes()
    draw_friction_cone(FrictionCone(0.6), axes)
    (line,) = axes.lines
    assert_full_circle(points_of(line), 0.6)
    (disc,) = axes.patches
    assert_full_circle(disc.get_xy(), 0.6)
    assert (disc.get_facecolor()[:3], line.get_color()) == (to_rgb(EXACT), EXACT)
    assert 0.05 < disc.get_alpha() < 0.2
    assert disc.get_linewidth() == 0.0
    np.testing.assert_allclose([axes.get_xlim(), axes.get_ylim()], [[-0.63, 0.63]] * 2)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$f_x / f_z$", "$f_y / f_z$")
    assert axes.get_title() == "friction cone, μ = 0.6"
    assert legend_of(axes) == ["exact"]
    assert axes.get_aspect() == 1.0
    assert axes.get_legend()._loc == 2  # upper left
    assert_legible(axes.figure)


def test_a_pyramid_stands_beside_its_cone_and_the_range_holds_both() -> None:
    """Three sides around a circle have their corners twice as far out; three within it, on it."""
    for fit, radius, colour in (("outer", 1.2, OUTER), ("inner", 0.6, INNER)):
        axes = new_axes()
        draw_friction_cone(FrictionCone(0.6), axes, 3, fit)  # type: ignore[arg-type]
        circle, sides = axes.lines
        assert_full_circle(points_of(circle), 0.6)
        np.testing.assert_allclose(sized(points_of(sides)), [radius] * 4, rtol=1e-9)
        np.testing.assert_allclose(points_of(sides)[0], points_of(sides)[-1])
        assert (sides.get_color(), sides.get_label()) == (colour, fit)
        span = 1.05 * np.abs(points_of(sides)).max()
        np.testing.assert_allclose([axes.get_xlim(), axes.get_ylim()], [[-span, span]] * 2)


def test_a_cone_that_is_almost_everything_is_drawn_as_one_of_fifty() -> None:
    axes = new_axes()
    draw_friction_cone(FrictionCone(80.0), axes, 4)
    np.testing.assert_allclose(sized(points_of(axes.lines[0])), 50.0)
    np.testing.assert_allclose(sized(points_of(axes.lines[1])), 50.0)
    assert axes.get_title() == "friction cone, μ = 80"


def test_a_cone_without_friction_has_a_range_nonetheless() -> None:
    axes = new_axes()
    draw_friction_cone(FrictionCone(0.0), axes)
    np.testing.assert_allclose(axes.get_xlim(), [-0.0525, 0.0525])
    thin = new_axes()
    draw_friction_cone(FrictionCone(0.01), thin, 4)
    np.testing.assert_allclose(thin.get_xlim(), [-0.0525, 0.0525])
    slim = new_axes()
    draw_friction_pyramid(FrictionCone(0.01).polyhedral(4, "inner"), slim)
    np.testing.assert_allclose(slim.get_xlim(), [-0.0525, 0.0525])


def test_a_pyramid_says_how_far_it_is_from_its_cone() -> None:
    """Eight sides within a circle come 1 - cos(pi / 8) = 7.6 % short; around it, 1 / cos - 1 = 8.2 % far."""
    for fit, error, radius in (("inner", "−7.6", 0.6), ("outer", "+8.2", 0.6 / np.cos(np.pi / 8.0))):
        axes = new_axes()
        draw_friction_pyramid(FrictionCone(0.6).polyhedral(8, fit), axes)  # type: ignore[arg-type]
        assert axes.get_title() == f"μ = 0.6, 8 sides, {fit}: {error} %"
        assert legend_of(axes) == ["exact", fit]
        assert_full_circle(points_of(axes.lines[0]), 0.6)
        np.testing.assert_allclose(sized(points_of(axes.lines[1])), radius)
        assert axes.get_xlim()[1] == pytest.approx(1.05 * np.abs(points_of(axes.lines[1])).max())


def test_in_space_a_cone_widens_from_its_apex_to_a_rim_at_one_newton() -> None:
    axes = new_axes(space=True)
    draw_friction_cone(FrictionCone(0.6), axes, 5)
    (sheet,) = axes.collections
    rim, ring, *edges = (places_of(line) for line in axes.lines)
    for points, count in ((rim, 60), (ring, 6)):
        assert len(points) == count
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 0.6)
        np.testing.assert_allclose(points[:, 2], 1.0)
        np.testing.assert_allclose(points[0], points[-1], atol=1e-12)
    np.testing.assert_allclose(edges, [[[0.0, 0.0, 0.0], end] for end in ring[:-1]], atol=1e-12)
    assert [line.get_color() for line in axes.lines] == [EXACT, *[INNER] * 6]
    assert all(0.5 <= line.get_linewidth() <= 1.2 for line in axes.lines)
    assert legend_of(axes) == ["exact", "inner"]
    assert 0.1 < sheet.get_alpha() < 0.3
    assert len(sheet._faces) == 59  # a face a step
    corners = sheet._faces.reshape(-1, 3)
    np.testing.assert_allclose(np.hypot(corners[:, 0], corners[:, 1]), 0.6 * corners[:, 2], atol=1e-12)
    assert set(corners[:, 2].round(9).tolist()) == {0.0, 1.0}
    assert_full_circle(rim[:, :2], 0.6)


def test_axes_in_space_are_newtons_from_above_the_ground() -> None:
    axes = new_axes(space=True)
    draw_friction_cone(FrictionCone(0.6), axes)
    assert axes.get_zlim() == (0.0, 1.0)
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == [f"$f_{a}$ [N]" for a in "xyz"]
    assert (axes.elev, axes.azim) == (22, -55)
    x, y, z = axes._box_aspect
    assert x == y
    assert 0.85 < z / x < 0.95
    assert axes._dist * np.linalg.norm(axes._box_aspect) > 0.0
    assert all(len(axis.get_majorticklocs()) <= 7 for axis in (axes.xaxis, axes.yaxis, axes.zaxis))
    assert axes.xaxis.get_tick_params()["labelsize"] == 7.0
    assert axes.xaxis.get_tick_params()["pad"] < 0.0


def test_a_circle_without_a_name_has_no_rim_in_space() -> None:
    axes = new_axes(space=True)
    draw_circle(axes, 0.5)
    assert not axes.lines
    assert len(axes.collections) == 1
    plane = new_axes()
    draw_sides(plane, FrictionCone(0.5).polyhedral(4, "outer"))
    assert [line.get_color() for line in plane.lines] == [OUTER]


def square(wide: float, aside: float = 0.0) -> PolyhedralCone:
    """Return the cone of forces whose section is a square, `aside` of the axis along x."""
    ends = [[wide + aside, wide], [wide + aside, -wide], [aside - wide, wide], [aside - wide, -wide]]
    return PolyhedralCone.from_rays(np.column_stack([2.0 * np.array(ends), np.full(4, 2.0)]))


@pytest.mark.parametrize(("wide", "aside"), [(0.5, 0.25), (40.0, 0.0), (1e-4, 0.0)])
def test_the_section_of_a_cone_of_forces_is_about_its_mean_ray(wide: float, aside: float) -> None:
    axes = new_axes()
    draw_polyhedral_cone(square(wide, aside), axes)
    border, middle = axes.lines
    np.testing.assert_allclose(points_of(middle), [[aside, 0.0]], atol=1e-12)
    away = points_of(border) - [aside, 0.0]
    np.testing.assert_allclose(np.abs(away).max(axis=1), wide, rtol=1e-3)
    assert len(away) == 121
    np.testing.assert_allclose(away[0], away[-1])
    assert np.ptp(np.unwrap(np.arctan2(away[:, 1], away[:, 0]))) == pytest.approx(2.0 * np.pi)
    (area,) = axes.patches
    np.testing.assert_allclose(area.get_xy()[:121], points_of(border))
    assert (area.get_alpha(), area.get_linewidth()) == (0.15, 0.0)
    assert area.get_facecolor()[:3] == to_rgb(EXACT)
    assert (border.get_color(), middle.get_color(), middle.get_marker()) == (EXACT, INK, "+")
    assert 6.0 < middle.get_markersize() < 9.0
    assert axes.get_title() == "section of a cone of 4 rays"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$f_x / f_z$", "$f_y / f_z$")
    assert axes.get_aspect() == 1.0


def test_a_cone_without_an_end_is_drawn_to_about_65_times_the_normal_force() -> None:
    axes = new_axes()
    draw_polyhedral_cone(square(1e6), axes)
    np.testing.assert_allclose(sized(points_of(axes.lines[0])), 1e-3 * 2.0**15, rtol=1.01)
    assert sized(points_of(axes.lines[0])).min() > 30.0
    assert sized(points_of(axes.lines[0])).max() < 70.0


def test_cones_without_a_section_are_refused() -> None:
    with pytest.raises(ProblemError, match=r"forces \(3\) or wrenches \(6\), got dimension 2"):
        draw_polyhedral_cone(PolyhedralCone.from_rays(np.eye(2)), new_axes())
    level = PolyhedralCone.from_rays([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    with pytest.raises(ProblemError, match="no forces along its third axis"):
        draw_polyhedral_cone(level, new_axes())
    with pytest.raises(ProblemError, match="no forces along its third axis"):
        draw_polyhedral_cone(PolyhedralCone(np.vstack([np.eye(3), -np.eye(3)]), np.zeros((0, 3))), new_axes())


def test_a_stance_gives_together_what_its_contacts_give_alone() -> None:
    """Two feet of friction 0.5 on level ground, about their middle: a circle of 0.5."""
    feet = [sf.PointContact([x, 0.0, 0.0], mu=0.5) for x in (0.3, -0.3)]
    axes = new_axes()
    draw_stance_cone(sf.StanceCone(sf.Stance(feet)), axes)
    np.testing.assert_allclose(sized(points_of(axes.lines[0])), 0.5, rtol=1e-4)
    assert axes.get_title() == "forces of 2 contacts together"


def test_a_foot_on_a_slope_gives_forces_about_its_normal() -> None:
    """Its section is where forces are atan(mu) from the normal, 20 degrees from the vertical."""
    normal = np.array([np.sin(np.radians(20.0)), 0.0, np.cos(np.radians(20.0))])
    axes = new_axes()
    draw_stance_cone(sf.StanceCone(sf.Stance([sf.PointContact([0, 0, 0], mu=0.5, normal=normal)])), axes)
    border, middle = axes.lines
    np.testing.assert_allclose(points_of(middle), [[np.tan(np.radians(20.0)), 0.0]], atol=1e-9)
    forces = np.column_stack([points_of(border), np.ones(121)])
    cosine = forces @ normal / np.linalg.norm(forces, axis=1)
    np.testing.assert_allclose(np.tan(np.arccos(cosine)), 0.5, rtol=1e-3)


def test_a_wall_alone_gives_no_section() -> None:
    wall = sf.PointContact([0.0, 0.0, 0.0], mu=0.5, normal=[1.0, 0.0, 0.0])
    with pytest.raises(ProblemError, match="does not point up"):
        draw_stance_cone(sf.StanceCone(sf.Stance([wall])), new_axes())
    with pytest.raises(ProblemError, match="a stance without contacts"):
        draw_stance_cone(sf.StanceCone(sf.Stance([])), new_axes())


def test_a_sole_is_drawn_with_its_corners_and_what_each_of_them_holds() -> None:
    """Discs have a quarter of the length times mu, shared by four corners: 0.25 x 0.22 x 0.6 / 4."""
    axes = new_axes()
    draw_sole(Sole(0.22, 0.09, 0.6), axes)
    outline, *dots, centre = axes.lines
    corners = np.array([[0.11, 0.045], [0.11, -0.045], [-0.11, -0.045], [-0.11, 0.045]])
    np.testing.assert_allclose(points_of(outline), [*corners, corners[0]], atol=1e-12)
    np.testing.assert_allclose([points_of(dot)[0] for dot in dots], corners, atol=1e-12)
    np.testing.assert_allclose(points_of(centre), [[0.0, 0.0]], atol=1e-12)
    area, *discs = axes.patches
    np.testing.assert_allclose(area.get_xy()[:4], corners, atol=1e-12)
    for disc, corner in zip(discs, corners, strict=True):
        assert_full_circle(disc.get_xy()[:60] - corner, 0.25 * 0.22 * 0.6 / 4.0)
    assert [patch.get_facecolor()[:3] for patch in (area, *discs)] == [to_rgb(MUTED), *[to_rgb(FORCE)] * 4]
    assert all(0.1 < patch.get_alpha() < 0.3 and not patch.get_linewidth() for patch in axes.patches)
    assert [dot.get_marker() for dot in (*dots, centre)] == [*"oooo", "+"]
    assert [round(dot.get_markersize()) for dot in (*dots, centre)] == [3, 3, 3, 3, 8]
    assert lines_in(axes, INK) == axes.lines[:]
    assert axes.get_title() == "sole, 4 corners, μ = 0.6"
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_aspect()) == ("x [m]", "y [m]", 1.0)
    assert (axes.get_adjustable(), axes.margins()) == ("datalim", (0.15, 0.15))
    assert_legible(axes.figure)


def test_friction_above_two_is_drawn_as_two_and_on_each_of_three_corners() -> None:
    axes = new_axes()
    draw_sole(Sole.of_corners([[0.1, 0.0], [-0.1, 0.05], [-0.1, -0.05]], mu=9.0), axes)
    for disc in axes.patches[1:]:
        points = disc.get_xy()[:60]
        assert 0.5 * np.ptp(points, axis=0) == pytest.approx(np.full(2, 0.25 * 0.2 * 2.0 / 3.0), rel=1e-2)


def test_edges_are_named_outside_along_them_with_letters_upright() -> None:
    """A twentieth of the length away: 0.011 m."""
    axes = new_axes()
    draw_sole(Sole(0.22, 0.09), axes)
    names = {text.get_text(): text for text in axes.texts}
    assert texts_of(axes) == ["toe edge", "right edge", "heel edge", "left edge"]
    places = {"toe edge": (0.121, 0.0), "right edge": (0.0, -0.056), "left edge": (0.0, 0.056)}
    for name, place in {**places, "heel edge": (-0.121, 0.0)}.items():
        np.testing.assert_allclose(names[name].get_position(), place, atol=1e-9)
        np.testing.assert_allclose(names[name].xy, place, atol=1e-9)
        assert (names[name].get_ha(), names[name].get_va()) == ("center", "center")
    turns = [names[name].get_rotation() % 180.0 for name in ("toe edge", "right edge", "left edge")]
    np.testing.assert_allclose(turns, [90.0, 0.0, 0.0], atol=1e-9)
    slanted = new_axes()
    draw_sole(Sole.of_corners([[0.1, 0.0], [0.0, -0.1], [-0.1, 0.0], [0.0, 0.1]]), slanted)
    turns = [(text.get_rotation() + 180.0) % 360.0 - 180.0 for text in slanted.texts]
    np.testing.assert_allclose(sorted(turns), [-45.0, -45.0, 45.0, 45.0], atol=1e-6)
    for text in slanted.texts:
        x, y = text.get_position()
        assert abs(x) + abs(y) == pytest.approx(0.1 + np.sqrt(2.0) * 0.01)
        assert np.sign(x * y) == -np.sign((text.get_rotation() + 180.0) % 360.0 - 180.0)
