"""The cone page: its figures are those of the cones, its section is drawn where they are."""

from __future__ import annotations

import re

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.cone import SCALE, ConePage, ConeState, cone_drawing, section
from surefoot.app.lab.drawing import Ball
from surefoot.app.lab.page import Grip


@pytest.mark.parametrize(("facets", "inner", "outer"), [(4, "29.3 %", "41.4 %"), (8, "7.6 %", "8.2 %")])
def test_the_errors_of_the_pyramids_are_told(facets: int, inner: str, outer: str) -> None:
    text = cone_drawing(ConeState(facets=facets)).text
    assert f"gives up {inner}" in text
    assert f"overshoots by {outer}" in text


@pytest.mark.parametrize("force", [(35.0, 20.0, 80.0), (60.0, 0.0, 80.0), (0.0, 0.0, -20.0), (0.0, 0.0, 0.0)])
def test_what_is_said_of_a_force_is_what_the_cone_says(force: tuple[float, float, float]) -> None:
    cone = sf.FrictionCone(0.6)
    shown = cone_drawing(ConeState(force=force))
    holds = bool(cone.contains(force))
    assert ("Sticks" in shown.text) == holds
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", shown.text)
    assert cells[:3] == ["round cone", "yes" if holds else "no", f"{float(cone.margin(force)):.2f}"]
    if holds:
        assert "/projection" not in shown.shapes
    else:
        ball = shown.shapes["/projection"]
        assert isinstance(ball, Ball)
        np.testing.assert_allclose(ball.position, SCALE * cone.project(force), atol=1e-12)


def test_the_mouse_moves_the_tip() -> None:
    page, eye = ConePage(), np.array([2.2, -2.2, 1.5])
    wanted = SCALE * np.array([-20.0, 45.0, 80.0])
    page.grip(Grip("/tip", "update", wanted, eye + 0.5 * (wanted - eye), eye))
    np.testing.assert_allclose(page.state.force, [-20.0, 45.0, 80.0], atol=1e-9)


def test_the_section_draws_the_force_from_the_axis_to_its_dot() -> None:
    """The axis is in the middle of the picture, where the grid's lines cross; the dot is the force's end."""
    drawn = section(ConeState(force=(35.0, 20.0, 80.0)))
    lines = [
        np.array([[float(x) for x in place.split(",")] for place in points.split()])
        for points in re.findall(r'<polyline points="([^"]*)"', drawn)
    ]
    across, up, force = lines
    middle = across.mean(axis=0)
    np.testing.assert_allclose(up.mean(axis=0), middle, atol=0.1)
    np.testing.assert_allclose(force[0], middle, atol=0.1)
    dot = re.search(r'<circle cx="([^"]*)" cy="([^"]*)"', drawn)
    assert dot is not None
    np.testing.assert_allclose(force[1], [float(x) for x in dot.groups()], atol=0.1)
    right, down = force[1] - force[0]
    assert right > 0.0 > down  # a picture's second axis goes down
    assert right / -down == pytest.approx(35.0 / 20.0, rel=0.01)
