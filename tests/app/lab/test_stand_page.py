"""The stand page: what it shows is what the statics say, for every control and every move of the mouse."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.drawing import Arrows, Ball, Lines
from surefoot.app.lab.page import Grip
from surefoot.app.lab.stand import CONES, StandPage, StandState, stand_drawing, start_state
from surefoot.base.errors import ProblemError

EYE = np.array([1.3, -1.3, 0.9])


@pytest.fixture(scope="module")
def state() -> StandState:
    return start_state(sf.load_robot("go2"))


def shifted(state: StandState, x: float, y: float = 0.0) -> np.ndarray:
    """The centre of mass somewhere else."""
    return state.com + np.array([x, y, 0.0])


def contacts(state: StandState) -> sf.Stance:
    """The stance again, by hand."""
    tilt, way = np.radians(state.slope), np.radians(state.direction)
    n = np.array([-np.sin(tilt) * np.cos(way), -np.sin(tilt) * np.sin(way), np.cos(tilt)])
    feet = [
        sf.PointContact([x, y, -(n[0] * x + n[1] * y) / n[2]], n, mu, name)
        for (x, y), mu, name, on in zip(state.feet, state.mu, state.names, state.on, strict=True)
        if on
    ]
    return sf.Stance(feet)


@pytest.mark.parametrize("cones", CONES)
@pytest.mark.parametrize(
    ("slope", "direction", "x"), [(0.0, 0.0, 0.0), (20.0, 0.0, 0.02), (25.0, 130.0, 0.3)]
)
def test_the_verdict_and_the_region_are_those_of_the_statics(
    state: StandState, cones: str, slope: float, direction: float, x: float
) -> None:
    tilted = replace(state, slope=slope, direction=direction, com=shifted(state, x), cones=cones)
    facets, fit = CONES[cones]
    stance = contacts(tilted)
    verdict = sf.can_stand(stance, tilted.com, tilted.mass, facets=facets, fit=fit)
    region = sf.com_region(stance, tilted.mass, 1e-3, facets=facets, fit=fit)
    shown = stand_drawing(tilted)
    assert ("It can stand" in shown.text) == verdict.feasible
    if verdict.feasible:
        assert f"Margin {verdict.margin:.2f} N" in shown.text
    else:
        assert "/motion" in shown.shapes
    border = shown.shapes.get("/region/border")
    if region.empty:
        assert border is None
    else:
        assert border is not None
        assert isinstance(border, Lines)
        drawn = border.points[:, 0, :2]
        assert len(drawn) == len(region.inner)
        for corner in drawn:  # in another order where the last bits differ
            assert np.linalg.norm(region.inner - corner, axis=1).min() < 1e-6


def test_the_arrows_are_the_forces(state: StandState) -> None:
    told = stand_drawing(state).shapes["/forces"]
    assert isinstance(told, Arrows)
    forces = told.points[:, 1] - told.points[:, 0]
    total = forces.sum(axis=0)
    assert abs(total[:2]).max() < 1e-6 * total[2]
    places = told.points[:, 0] - state.com
    moment = np.cross(places, forces).sum(axis=0)
    assert np.abs(moment).max() < 1e-6 * total[2]


def test_the_mouse_moves_a_foot_on_the_tilted_ground(state: StandState) -> None:
    page = StandPage(replace(state, slope=20.0, direction=45.0))
    place = page.state.on_ground(np.array([[0.3, 0.2]]))[0]
    name = state.names[1]
    page.grip(Grip(f"/feet/{name}", "update", place, EYE + 1.7 * (place - EYE), EYE))
    np.testing.assert_allclose(page.state.feet[1], [0.3, 0.2], atol=1e-12)
    ball = page.drawing().shapes[f"/feet/{name}"]
    assert isinstance(ball, Ball)
    np.testing.assert_allclose(ball.position, place, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("mu", float("nan")), ("mu", -1.0), ("mu", "x"), ("mu", None), ("mu", [1.0]), ("mu", True),
        ("x", 1e300), ("cones", "round"), ("cones", 3), ("on FL_foot", 1.0), ("nothing", 1.0), ("reset", 1.0),
        ("slope", 90.0),
    ],
)  # fmt: skip
def test_a_value_that_cannot_be_is_refused_and_changes_nothing(
    state: StandState, name: str, value: object
) -> None:
    page = StandPage(state)
    before = page.drawing().text
    with pytest.raises(ProblemError):
        page.change(name, value)
    assert page.drawing().text == before


@pytest.mark.parametrize("point", [[np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], [1e9, 0.0, 0.0], [0.0, 0.0]])
def test_a_mouse_that_points_nowhere_is_refused(point: list[float]) -> None:
    with pytest.raises(ProblemError, match="nowhere"):
        Grip("/com", "update", np.zeros(3), np.array(point), EYE)


@pytest.mark.parametrize(
    "sole", [sf.Sole(0.2, 0.08), sf.Sole.of_corners([[0.14, 0], [-0.06, 0.07], [-0.06, -0.07]])]
)
@pytest.mark.parametrize("x", [0.0, 0.06, 0.3])
def test_soles_stand_as_the_statics_say(sole: sf.Sole, x: float) -> None:
    """Two soles, rectangles or triangles: verdict, region, pressure inside, and what binds by name."""
    feet = np.array([[0.0, 0.1], [0.0, -0.1]])
    state = StandState(
        ("left", "right"),
        feet,
        np.ones(2, bool),
        np.full(2, 0.5),
        np.array([x, 0.02, 0.7]),
        30.0,
        soles=(sole, sole),
    )
    own = sole.with_friction(0.5)
    stance = sf.Stance(
        [sf.SoleContact([*p, 0.0], own, name=n) for p, n in zip(feet, state.names, strict=True)]
    )
    verdict, shown = sf.can_stand(stance, state.com, 30.0), stand_drawing(state)
    assert ("It can stand" in shown.text) == verdict.feasible == (x < 0.2)
    region = sf.com_region(stance, 30.0, 1e-3)
    assert f"region {1e4 * region.area:.0f} cm²" in shown.text
    outline = shown.shapes["/soles/left"]
    assert isinstance(outline, Lines)
    np.testing.assert_allclose(outline.points[:, 0, :2], sole.corners + feet[0], atol=1e-12)
    if not verdict.feasible:
        assert "/motion" in shown.shapes
        return
    arrows = shown.shapes["/forces"]
    assert isinstance(arrows, Arrows)
    pressed, forces = arrows.points[:, 0], arrows.points[:, 1] - arrows.points[:, 0]
    middle = forces[:, 2] @ pressed[:, :2] / forces[:, 2].sum()  # the pressure of both is below the weight
    np.testing.assert_allclose(middle, state.com[:2], atol=1e-6)
    for k, contact in enumerate(stance):
        wrench = verdict.stacked[6 * k : 6 * k + 6]
        assert contact.sole.contains(wrench)
        assert f"{100.0 * float(contact.sole.use(wrench).total):.0f} % of its sole" in shown.text


def test_a_robot_on_soles_begins_on_them() -> None:
    state = start_state(sf.load_robot("g1"))
    assert all(sole is not None for sole in state.soles)
    assert "It can stand" in stand_drawing(state).text
