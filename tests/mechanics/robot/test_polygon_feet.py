"""Feet that are convex polygons: every corner is read, and everybody goes by the same corners."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.lab.stand import start_state
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.outlines import area_of, few_corners, hull_of, moved_in
from tests.mechanics.robot.test_foot_reading import stl
from tests.standing_biped import write_biped

TRIANGLE = np.array([[0.14, 0.0], [-0.06, 0.07], [-0.06, -0.07]])
HEXAGON = np.array([[0.14, 0.02], [0.14, -0.02], [0.04, -0.06], [-0.08, -0.02], [-0.08, 0.02], [0.04, 0.06]])
OUTLINES = {"triangle": TRIANGLE, "hexagon": HEXAGON}


def balls(outline: np.ndarray) -> str:
    """Return collision elements: a ball of 5 mm at every corner."""
    shape = '<geometry><sphere radius="0.005"/></geometry>'
    return "".join(
        f'<collision><origin xyz="{x} {y} -0.05"/>{shape}</collision>' for x, y in outline.tolist()
    )


def biped(folder: Path, name: str, kind: str) -> Robot:
    outline = OUTLINES[name]
    text = balls(outline)
    if kind == "mesh":
        flat = np.column_stack([outline, np.full(len(outline), -0.055)])
        stl(folder / "sole.stl", np.vstack([flat, flat + np.array([0.0, 0.0, 0.03])]))
        text = '<collision><geometry><mesh filename="sole.stl"/></geometry></collision>'
    return sf.load_robot(write_biped(folder, text), feet=["left_foot", "right_foot"])


@pytest.mark.parametrize("kind", ["balls", "mesh"])
@pytest.mark.parametrize("name", OUTLINES)
def test_every_corner_of_a_foot_is_read(tmp_path: Path, name: str, kind: str) -> None:
    robot, outline = biped(tmp_path, name, kind), OUTLINES[name]
    foot = robot.feet[0]
    assert f"a sole of {len(outline)} corners" in foot.why
    read = hull_of(foot.centres[:, :2])
    assert len(read) == len(outline) == len(foot.centres)
    own = hull_of(outline)
    if kind == "balls":
        assert np.abs(np.sort(read, axis=0) - np.sort(own, axis=0)).max() < 1e-9
    else:  # the radius of its corners inside of the mesh
        assert np.abs(np.sort(read, axis=0) - np.sort(moved_in(own, 2e-3), axis=0)).max() < 1e-6
    assert foot.centres[:, 2] - foot.radius == pytest.approx(np.full(len(own), -0.055), abs=1e-9)


@pytest.mark.parametrize("name", OUTLINES)
def test_the_stance_has_the_corners_that_controllers_and_worlds_have(tmp_path: Path, name: str) -> None:
    robot = biped(tmp_path, name, "balls")
    q = sf.place(robot)
    stance, points = robot.stance(q, mu=0.6), robot.contact_points
    corners = np.vstack([c.position for c in stance.points()])
    assert len(corners) == len(points)
    places = np.array(
        [
            robot.data.oMf[points.frames[k]].act(c) - [0.0, 0.0, points.radii[i]]
            for i, (k, c) in enumerate(zip(points.foot, points.centres, strict=True))
        ]
    )
    apart = np.linalg.norm(corners[:, None] - places[None], axis=2)
    assert apart.min(axis=0).max() < 1e-6
    # the largest corner of the polygon carries the weight, beyond every rectangle in it
    far = corners[int(corners[:, 0].argmax())]
    near = np.array([far[0] - 5e-3, 0.0, 0.7])
    toes = corners[corners[:, 0] > far[0] - 1e-6]
    assert toes[:, 1].min() < 0.0 < toes[:, 1].max()
    assert sf.can_stand(stance, near, robot.mass)
    assert not sf.can_stand(stance, near + np.array([0.01, 0.0, 0.0]), robot.mass)
    assert sf.com_region(stance, robot.mass).contains(near[:2])


@pytest.mark.parametrize("name", OUTLINES)
def test_a_robot_stands_and_its_wrenches_are_of_the_sole(tmp_path: Path, name: str) -> None:
    pytest.importorskip("mujoco")
    robot = biped(tmp_path, name, "mesh")
    q, ground = sf.place(robot), sf.FlatTerrain()
    controller = sf.StandingController(robot, sf.StandingPlan(robot, ground, q), ground, q)
    log = sf.run(sf.MujocoWorld(robot, mu=0.6), controller, sf.Scenario(duration=1.0, mu=0.6))
    assert not sf.audit_log(log).violations
    last = log["forces"][-1]
    assert last[:, 2].sum() == pytest.approx(9.81 * robot.mass, rel=0.02)
    soles = [foot.sole(0.6) for foot in robot.feet]
    at = 0
    for foot, sole in zip(robot.feet, soles, strict=True):
        forces, count = last[at : at + len(foot.centres)], len(foot.centres)
        arms = np.column_stack([foot.centres[:, :2] - foot.centre[:2], np.zeros(count)])
        wrench = np.concatenate([forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)])
        assert sole.margin(wrench) > 0.2 * wrench[2]
        at += count


def test_outlines_keep_their_large_corners() -> None:
    turns = 2.0 * np.pi * np.arange(40) / 40
    circle = np.column_stack([np.cos(turns), np.sin(turns)])
    eight = few_corners(circle, 8, 0.02)
    assert len(eight) == 8
    assert area_of(eight) > 0.85 * area_of(circle)
    rounded = np.vstack([TRIANGLE, 0.999 * TRIANGLE + [[1e-5, 1e-3], [1e-4, 0], [0, 1e-4]]])
    assert len(few_corners(hull_of(rounded), 8, 0.02)) == 3
    square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    assert np.sort(moved_in(square, 0.25), axis=0) == pytest.approx(0.75 * np.sort(square, axis=0))


def test_a_plan_of_such_feet_is_refused_for_their_number(tmp_path: Path) -> None:
    """Plans through contact are of robots on four feet, whatever their shape."""
    with pytest.raises(ProblemError, match="four feet"):
        sf.plan(biped(tmp_path, "triangle", "balls"), "jump", 0.2)


def test_the_lab_stands_on_the_same_corners(tmp_path: Path) -> None:
    robot = biped(tmp_path, "hexagon", "balls")
    state, foot = start_state(robot), robot.feet[0]
    sole = state.sole(0)
    assert sole is not None
    np.testing.assert_allclose(hull_of(sole.corners), hull_of(foot.sole(0.6).corners), atol=1e-12)
    for drawn, own in zip(state.stance().contacts, robot.stance(robot.nominal, mu=0.6).contacts, strict=True):
        np.testing.assert_allclose(drawn.sole.corners, own.sole.corners, atol=1e-12)
        assert drawn.mu == own.mu
