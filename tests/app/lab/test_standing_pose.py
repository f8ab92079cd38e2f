"""The robot of the page *stand* has feet and centre of mass where they were dragged, or is not drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.drawing import Mesh
from surefoot.app.lab.stand import StandPage, start_state
from surefoot.app.lab.standing_pose import NEAR, OPACITY, StandingPose

pytest.importorskip("trimesh", reason="viser brings it: pip install -e '.[lab]'")


@pytest.mark.parametrize("name", ["go2", "g1"])
@pytest.mark.parametrize(("moved", "slope"), [((0.0, 0.0, 0.0), 0.0), ((0.05, 0.03, -0.03), 15.0)])
@pytest.mark.sampled(1)
def test_feet_and_centre_of_mass_are_where_they_should_be(
    name: str, moved: tuple[float, float, float], slope: float
) -> None:
    robot = sf.load_robot(name)
    start = start_state(robot)
    state = replace(start, com=start.com + moved, slope=slope)
    q = StandingPose(robot).configuration(state)
    assert q is not None
    ground = sf.SlopeTerrain(slope)
    places = robot.stance(q, terrain=ground).positions  # of spheres and soles over the terrain
    np.testing.assert_allclose(places, state.on_ground(state.feet), atol=NEAR)
    np.testing.assert_allclose(robot.com(q), state.com, atol=NEAR)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    assert ((q[7:] >= low) & (q[7:] <= high)).all()


def test_nothing_is_drawn_where_it_does_not_reach() -> None:
    robot = sf.load_robot("go2")
    start, pose = start_state(robot), StandingPose(robot)
    assert not pose.shapes(replace(start, com=np.add(start.com, [0.5, 0.0, 0.0])))
    assert not pose.shapes(replace(start, on=np.zeros(4, dtype=bool)))


def test_the_page_shows_the_robot_in_place_of_sticks() -> None:
    robot = sf.load_robot("go2")
    page = StandPage(start_state(robot), StandingPose(robot).shapes)
    shapes = page.drawing().shapes
    links = [shape for name, shape in shapes.items() if name.startswith("/robot/")]
    assert len(links) > 10
    assert all(isinstance(link, Mesh) and link.opacity == OPACITY for link in links)
    assert "/body" not in shapes
    page.change("x", 0.6)
    shapes = page.drawing().shapes
    assert "/body" in shapes
    assert not any(name.startswith("/robot/") for name in shapes)
    assert "/body" in StandPage(start_state(robot)).drawing().shapes
