"""Feet are what their models say: boxes, balls, lines, meshes, and what is missing is named."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.foot_shape import BAND
from tests.mechanics.robot.lint import models
from tests.standing_biped import BOX, SPHERES, write_biped, write_biped_mjcf

FEET = ("left_foot", "right_foot")


def stl(path: Path, points: np.ndarray) -> None:
    """Write the hull of (k, 3) points as a binary STL file."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    rows = [struct.pack("<12fH", *np.zeros(3), *points[s].ravel(), 0) for s in hull.simplices]
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows))


def shoe() -> np.ndarray:
    """Return the corners of a sole of 200 x 90 mm with a wider rim 2 cm above it."""
    flat = [(x, y, -0.06) for x in (-0.06, 0.14) for y in (-0.045, 0.045)]
    rim = [(x, y, -0.04) for x in (-0.08, 0.16) for y in (-0.055, 0.055)]
    return np.array([*flat, *rim, (0.0, 0.0, 0.02)])


def read(path: Path) -> Robot:
    return sf.load_robot(path, feet=list(FEET))


def sole_size(robot: Robot) -> np.ndarray:
    """Return length and width that the first sole has with its edges [m]."""
    foot = robot.feet[0]
    assert foot.flat, foot.why
    return np.array(foot.size) + 2.0 * foot.radius


def test_a_box_is_a_sole(tmp_path: Path) -> None:
    robot = read(write_biped(tmp_path, BOX))
    assert sole_size(robot) == pytest.approx([0.2, 0.1], abs=1e-9)
    assert "a sole of 200 x 100 mm" in robot.feet[0].why
    assert "100 % of its area" in robot.feet[0].why
    assert robot.feet[0].centre == pytest.approx([0.03, 0.0, -0.05], abs=1e-9)
    assert all(any(name in note for note in robot.notes) for name in FEET)
    sf.place(robot)


@pytest.mark.parametrize("named", [False, True])
def test_four_balls_are_a_sole_with_and_without_names(tmp_path: Path, named: bool) -> None:
    robot = read(write_biped_mjcf(tmp_path, SPHERES, named))
    foot = robot.feet[0]
    assert foot.size == pytest.approx((0.16, 0.06), abs=1e-9)
    assert foot.radius == pytest.approx(0.01)
    assert "4 spheres" in foot.why


def test_eight_balls_are_the_rectangle_under_them(tmp_path: Path) -> None:
    ball = '<collision><origin xyz="{} {} -0.05"/><geometry><sphere radius="0.01"/></geometry></collision>'
    row = np.linspace(-0.05, 0.13, 4)
    text = "".join(ball.format(x, y) for x in row for y in (-0.03, 0.03))
    foot = read(write_biped(tmp_path, text)).feet[0]
    assert len(foot.centres) == 4
    assert foot.size == pytest.approx((0.18, 0.06), abs=1e-9)
    assert "8 spheres" in foot.why


def test_two_balls_are_a_line(tmp_path: Path) -> None:
    ball = '<collision><origin xyz="{} 0 -0.05"/><geometry><sphere radius="0.02"/></geometry></collision>'
    foot = read(write_biped(tmp_path, ball.format(-0.05) + ball.format(0.1))).feet[0]
    assert "a line of 150 mm" in foot.why
    assert foot.radius == pytest.approx(0.02)
    assert foot.size[0] == pytest.approx(0.15)
    assert foot.size[1] < 0.005


@pytest.mark.parametrize("shape", ["cylinder", "capsule"])
def test_a_shape_on_its_side_is_a_line(tmp_path: Path, shape: str) -> None:
    """Of a capsule, which URDF has only as MuJoCo's dialect, MJCF is asked."""
    if shape == "cylinder":
        text = (
            '<collision><origin xyz="0.03 0 -0.04" rpy="0 1.5707963267948966 0"/>'
            '<geometry><cylinder radius="0.02" length="0.14"/></geometry></collision>'
        )
        foot = read(write_biped(tmp_path, text)).feet[0]
    else:
        text = '<geom class="contact" type="capsule" fromto="-0.04 0 -0.04 0.1 0 -0.04" size="0.02"/>'
        foot = read(write_biped_mjcf(tmp_path, text)).feet[0]
    assert f"a line of 140 mm: under the {shape}" in foot.why
    assert foot.size[0] == pytest.approx(0.14, abs=1e-6)
    assert foot.centre == pytest.approx([0.03, 0.0, -0.04], abs=1e-6)


def test_a_cylinder_that_stands_is_eight_corners_of_its_disc(tmp_path: Path) -> None:
    disc = '<geometry><cylinder radius="0.06" length="0.02"/></geometry>'
    robot = read(write_biped(tmp_path, f'<collision><origin xyz="0 0 -0.04"/>{disc}</collision>'))
    foot = robot.feet[0]
    assert len(foot.corners) == 8
    out = np.linalg.norm(foot.corners + foot.centre[:2], axis=1)
    assert 0.056 < out.min() < out.max() < 0.06
    assert np.abs(foot.centre[:2]).max() < 2e-3
    assert "a sole of 8 corners, 120 x 120 mm" in foot.why


def test_a_mesh_is_what_is_flat_below_it(tmp_path: Path) -> None:
    stl(tmp_path / "shoe.stl", shoe())
    text = '<collision><geometry><mesh filename="package://any/shoe.stl"/></geometry></collision>'
    robot = read(write_biped(tmp_path, text))
    assert not robot.missing_meshes
    assert sole_size(robot) == pytest.approx([0.2, 0.09], abs=1e-6)
    assert robot.feet[0].centre[:2] == pytest.approx([0.04, 0.0], abs=1e-6)
    assert robot.feet[0].centre[2] - robot.feet[0].radius == pytest.approx(-0.06, abs=1e-6)
    assert "mesh left_foot_0" in robot.feet[0].why


def test_a_sole_whose_frame_lies_on_its_side_gets_one_that_stands(tmp_path: Path) -> None:
    turn = "1.5707963267948966 0 0"
    text = f'<collision><origin rpy="{turn}"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision>'
    straight = read(
        write_biped(tmp_path, '<collision><geometry><box size="0.2 0.1 0.04"/></geometry></collision>')
    )
    path = write_biped(tmp_path, text.replace("1.57", "-1.57"), ankle_rpy=turn)
    robot = read(path)
    assert sole_size(robot) == pytest.approx(sole_size(straight), abs=1e-9)
    assert robot.foot_names == FEET
    robot.sphere_bottoms(robot.nominal)
    np.testing.assert_allclose(robot.data.oMf[robot.feet[0].frame].rotation, np.eye(3), atol=1e-3)
    np.testing.assert_allclose(robot.sphere_bottoms(sf.place(robot)), 0.0, atol=1e-6)
    assert not [one for one in robot.lint().findings if one.rule == "foot-without-shape"]


def test_a_missing_mesh_costs_itself_alone(tmp_path: Path) -> None:
    gone = '<collision><geometry><mesh filename="package://any/arm.stl"/></geometry></collision>'
    whole = read(write_biped(tmp_path, BOX))
    robot = read(write_biped(tmp_path, BOX, body=gone))
    assert robot.missing_meshes == {"body": ["package://any/arm.stl"]}
    np.testing.assert_array_equal(robot.feet[0].centres, whole.feet[0].centres)
    assert len(robot.collision.geometryObjects) == len(whole.collision.geometryObjects)
    assert any("package://any/arm.stl" in note for note in robot.notes)
    beside = read(write_biped(tmp_path, BOX + gone))
    assert "without the mesh package://any/arm.stl, which is not there" in beside.feet[0].why


def test_a_foot_that_is_a_missing_mesh_is_refused(tmp_path: Path) -> None:
    gone = '<collision><geometry><mesh filename="package://any/sole.stl"/></geometry></collision>'
    with pytest.raises(
        ModelError, match=r"left_foot cannot be read: its shape is the mesh package://any/sole\.stl"
    ):
        read(write_biped(tmp_path, gone))


def test_a_mesh_that_is_none_costs_itself_alone(tmp_path: Path) -> None:
    (tmp_path / "junk.stl").write_text("no mesh")
    junk = '<collision><geometry><mesh filename="junk.stl"/></geometry></collision>'
    robot = read(write_biped(tmp_path, BOX, body=junk))
    assert list(robot.missing_meshes) == ["body"]
    assert robot.feet[0].flat


def test_an_mjcf_without_its_meshes_is_read(tmp_path: Path) -> None:
    asset = '<asset><mesh name="shell" file="shell.stl"/><mesh name="arm" file="arm.stl"/></asset>'
    shell = '<geom type="mesh" mesh="shell" density="0"/><geom type="mesh" mesh="arm" density="0"/>'
    robot = read(write_biped_mjcf(tmp_path, SPHERES, asset=asset, body=shell))
    assert robot.missing_meshes == {"body": ["shell.stl", "arm.stl"]}
    assert robot.feet[0].flat


def test_classes_and_defaults_are_heeded(tmp_path: Path) -> None:
    """What is drawn but touches nothing is no foot; size and kind come from the class."""
    drawn = '<geom class="drawn" type="box" size="0.3 0.3 0.1" pos="0 0 -0.1"/>'
    robot = read(write_biped_mjcf(tmp_path, f'{drawn}<geom class="pad" pos="0.02 0 -0.03"/>'))
    assert sole_size(robot) == pytest.approx([0.18, 0.08], abs=1e-9)


def test_a_rounded_foot_without_a_sole_is_a_guess(tmp_path: Path) -> None:
    """A hull that touches with a small part of what it is, and is no ball either."""
    turns = np.linspace(-1.0, 1.0, 21)
    points = np.array(
        [
            (0.2 * np.sin(a), y, 0.1 - 0.2 * np.cos(a) + 0.2 * abs(y))
            for a in turns
            for y in (-0.15, 0.0, 0.15)
        ]
    )
    stl(tmp_path / "rocker.stl", points)
    text = '<collision><geometry><mesh filename="rocker.stl"/></geometry></collision>'
    with pytest.raises(ModelError, match=r"left_foot would be a guess: .* less than 30 %"):
        read(write_biped(tmp_path, text))


def test_no_shape_at_all_is_told(tmp_path: Path) -> None:
    robot = read(write_biped(tmp_path, ""))
    assert not robot.feet[0].flat
    assert "is assumed, as nothing there has a shape" in robot.feet[0].why


def test_the_lowest_band_is_measured_in_the_nominal_pose(tmp_path: Path) -> None:
    """A second box that ends above the band does not touch; one in it does."""
    low = (
        '<collision><origin xyz="0.03 0 -0.04"/><geometry><box size="0.1 0.06 0.02"/></geometry></collision>'
    )
    high = '<collision><origin xyz="0.13 0 {}"/><geometry><box size="0.1 0.06 0.02"/></geometry></collision>'
    near = read(write_biped(tmp_path, low + high.format(-0.04 + 0.8 * BAND)))
    far = read(write_biped(tmp_path, low + high.format(-0.04 + 1.2 * BAND)))
    assert sole_size(near) == pytest.approx([0.2, 0.06], abs=1e-9)
    assert sole_size(far) == pytest.approx([0.1, 0.06], abs=1e-9)


def test_an_ankle_that_cannot_roll_stands_and_is_refused_to_walk(tmp_path: Path) -> None:
    from surefoot.motion.walking.walkers import walking_controller

    robot = read(write_biped(tmp_path, BOX, roll=False))
    q = sf.place(robot)
    np.testing.assert_allclose(robot.sphere_bottoms(q), 0.0, atol=1e-6)
    assert sf.can_stand(robot.stance(q), robot.com(q), robot.mass).feasible
    command = sf.VelocityCommand([0.0], [[0.2, 0.0, 0.0]])
    with pytest.raises(ModelError, match=r"leg of left_foot moves its sole in 5 of 6 directions"):
        walking_controller(robot, command)


def test_a_toe_across_a_joint_is_told_and_counted(tmp_path: Path) -> None:
    """A contact moves with one joint: the heel's sole is its own, and a toe alone is too little of a foot."""
    toe = '<collision><origin xyz="0.04 0 0"/><geometry><box size="0.08 0.1 0.03"/></geometry></collision>'
    path = write_biped(tmp_path, BOX, toe=toe)
    heel = read(path).feet[0]
    assert "across the joint left_toe_joint is not part of it" in heel.why
    assert "(71 % of its area)" in heel.why
    assert np.array(heel.size) + 2.0 * heel.radius == pytest.approx([0.2, 0.1])
    with pytest.raises(ModelError, match=r"left_toe would be a guess: .* across the joint left_toe_joint"):
        sf.load_robot(path, feet="left_toe, right_toe")
    lifted = read(write_biped(tmp_path, BOX, toe=toe.replace('0.04 0 0"', '0.04 0 0.02"')))
    assert "across" not in lifted.feet[0].why


def test_a_keyframe_that_lies_folded_is_none_to_stand_in(tmp_path: Path) -> None:
    """The feet are bodies, as of published MJCF: their frames are in the knees, the balls lie beyond."""
    text = models.mjcf()
    ball = 'type="sphere" size="0.02" pos="0 0 -0.2"'
    shin = '<geom type="box" size="0.012 0.02 0.08" pos="0 0 -0.1"/>'
    text = text.replace('range="-2.7 -0.3"/>', f'range="-2.7 -0.3"/>{shin}')
    assert ball in text
    assert shin in text
    standing, folded = " ".join(["0 0.7 -1.4"] * 4), " ".join(["0 1.13 -2.7"] * 4)
    feet = [name.replace("foot", "calf") for name in models.FEET.split(",")]
    (tmp_path / "dog.xml").write_text(text)
    (tmp_path / "folded.xml").write_text(text.replace(standing, folded))
    stands, lies = (sf.load_robot(tmp_path / name, feet=feet) for name in ("dog.xml", "folded.xml"))
    assert [foot.radius for foot in lies.feet] == [foot.radius for foot in stands.feet] == [0.02] * 4
    assert any("keyframe is no pose to stand in" in note for note in lies.notes)
    assert not any("keyframe" in note for note in stands.notes)
    assert lies.nominal[2] == pytest.approx(stands.nominal[2], abs=0.05)
