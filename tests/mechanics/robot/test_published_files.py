"""What published files do: links and joints of one name, infinite limits, parts of scenes, loose bases."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.legged import write_legged
from surefoot.app.cli.lint import lint_of
from surefoot.base.errors import ModelError
from surefoot.mechanics import contact_jacobian
from surefoot.motion.walking.walkable import check_point_feet
from tests.mechanics.robot.lint import models
from tests.standing_biped import BOX, write_biped


def test_a_link_may_have_the_name_of_its_joint(tmp_path: Path) -> None:
    path, feet = write_legged(tmp_path, 4)
    plain = sf.load_robot(path, feet=feet)
    text = path.read_text(encoding="utf-8")
    joint = re.search(rf'<joint name="(\w+)"[^>]*>(?:(?!</joint>).)*<child link="{feet[0]}"', text, re.DOTALL)
    assert joint is not None
    path.write_text(text.replace(f'<joint name="{joint[1]}"', f'<joint name="{feet[0]}"'), encoding="utf-8")
    robot = sf.load_robot(path, feet=feet)
    assert [foot.why for foot in robot.feet] == [foot.why for foot in plain.feet]
    np.testing.assert_allclose(robot.foot_positions(), plain.foot_positions())
    assert contact_jacobian(robot, robot.nominal, robot.stance()).shape == (12, robot.model.nv)


@pytest.mark.parametrize("word", ["inf", "INF", "infinity"])
def test_infinite_limits_are_none(word: str, tmp_path: Path) -> None:
    path, feet = write_legged(tmp_path, 4)
    text = re.sub(r'effort="[^"]*" velocity="[^"]*"', f'effort="{word}" velocity="{word}"', path.read_text())
    path.write_text(re.sub(r'lower="[^"]*" upper="[^"]*"', f'lower="-{word}" upper="{word}"', text))
    robot = sf.load_robot(path, feet=feet)
    assert np.isinf(robot.effort_limits).all()
    assert np.isinf(robot.speed_limits).all()
    assert len(robot.collision.geometryObjects) > 0
    assert any("without a range" in note for note in robot.notes)
    assert lint_of(str(path), ",".join(feet)).ok


def test_a_last_joint_that_is_continuous_is_a_leg_s(tmp_path: Path) -> None:
    path, feet = write_legged(tmp_path, 4)
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r'type="revolute"', 'type="continuous"', text), encoding="utf-8")
    robot = sf.load_robot(path, feet=feet)
    assert robot.model.nq == robot.model.nv + 1
    assert max(robot.sphere_bottoms(robot.nominal)) - min(robot.sphere_bottoms(robot.nominal)) < 1e-3


def test_a_wheel_that_is_no_foot_is_refused_in_words(tmp_path: Path) -> None:
    path, feet = write_legged(tmp_path, 4)
    wheel = '<link name="lidar"><inertial><mass value="0.3"/>'
    wheel += '<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    wheel += '<joint name="turning" type="continuous"><parent link="body"/>'
    wheel += '<child link="lidar"/><axis xyz="0 0 1"/></joint></robot>'
    path.write_text(path.read_text().replace("</robot>", wheel))
    robot = sf.load_robot(path, feet=feet)
    with pytest.raises(ModelError, match=r"joint turning turns without end, .* weld it"):
        sf.MujocoWorld(robot)


def test_a_sole_beside_a_foot_without_a_shape_is_refused(tmp_path: Path) -> None:
    path = write_biped(tmp_path, BOX)
    head, foot, tail = path.read_text().partition('<link name="right_foot">')
    path.write_text(head + foot + tail.replace(BOX, "", 1))
    with pytest.raises(
        ModelError, match=r"right_foot has no shape, while left_foot is a sole of 200 x 100 mm"
    ):
        sf.load_robot(path, feet="left_foot,right_foot")
    (error,) = lint_of(str(path), "left_foot,right_foot").errors
    assert error.rule == "load-refused"


def test_a_bare_frame_on_a_link_without_its_mesh_is_refused(tmp_path: Path) -> None:
    """Other shapes of the body, as sensors under a foot, say nothing of the sole that is not there."""
    mesh = '<collision><geometry><mesh filename="foot.stl"/></geometry></collision>'
    path = write_biped(tmp_path, mesh)
    extra = "".join(
        f'<link name="{s}_sole"/><joint name="{s}_sole_joint" type="fixed"><parent link="{s}_foot"/>'
        f'<child link="{s}_sole"/></joint><link name="{s}_sensor">{BOX}</link>'
        f'<joint name="{s}_at" type="fixed"><parent link="{s}_foot"/><child link="{s}_sensor"/></joint>'
        for s in ("left", "right")
    )
    path.write_text(path.read_text().replace("</robot>", f"{extra}</robot>"))
    with pytest.raises(ModelError, match=r"left_sole cannot be read: its shape is the mesh foot.stl"):
        sf.load_robot(path, feet="left_sole,right_sole")
    assert {e.rule for e in lint_of(str(path), "left_sole,right_sole").errors} == {"load-refused"}


def test_a_mesh_that_the_loader_finds_is_there_to_the_lint(tmp_path: Path) -> None:
    """A copy of a package without its own folder around it."""
    from tests.mechanics.robot.test_foot_reading import shoe, stl

    mesh = (
        '<collision><geometry><mesh filename="package://biped_description/meshes/{}"/></geometry></collision>'
    )
    (tmp_path / "meshes").mkdir()
    (tmp_path / "urdf").mkdir()
    stl(tmp_path / "meshes" / "shoe.stl", shoe())
    path = write_biped(tmp_path / "urdf", mesh.format("shoe.stl"))
    found = lint_of(str(path), "left_foot,right_foot")
    assert "mesh-missing" not in {one.rule for one in found.findings}
    path = write_biped(tmp_path / "urdf", mesh.format("shoe.stl") + mesh.format("toe.stl"))
    found = lint_of(str(path), "left_foot,right_foot")
    assert [one.place for one in found.findings if one.rule == "mesh-missing"] == [
        "link left_foot", "link right_foot",
    ]  # fmt: skip


def test_spheres_without_a_radius_are_points_of_a_urdf(tmp_path: Path) -> None:
    places = [(x, y) for x in (-0.05, 0.15) for y in (-0.04, 0.04)]
    points = "".join(
        f'<collision><origin xyz="{x} {y} -0.05"/><geometry><sphere radius="0"/></geometry></collision>'
        for x, y in places
    )
    path = write_biped(tmp_path, points)
    robot = sf.load_robot(path, feet="left_foot,right_foot")
    assert robot.feet[0].flat
    found = lint_of(str(path), "left_foot,right_foot")
    assert found.ok, str(found)
    assert "shape-empty" in {one.rule for one in found.warnings}


def test_a_base_on_joints_without_motors_is_refused(tmp_path: Path) -> None:
    loose = "".join(
        f'<joint name="base_{kind}_{axis.replace(" ", "")}" type="{kind}" axis="{axis}"/>'
        for kind in ("slide", "hinge")
        for axis in ("1 0 0", "0 1 0", "0 0 1")
    )
    text = models.mjcf().replace("<freejoint/>", loose)
    text = re.sub(r"<keyframe>.*</keyframe>", "", text, flags=re.DOTALL)
    path, feet = tmp_path / "dog.xml", models.FEET.replace("_foot", "_calf")
    path.write_text(text)
    with pytest.raises(ModelError, match=r"the base hangs on 6 joints without motors, .* <freejoint/>"):
        sf.load_robot(path, feet=feet)
    assert not sf.load_robot(path).floating
    errors = {error.rule: error.place for error in lint_of(str(path)).errors}
    assert errors == {} or set(errors) <= {"joint-without-actuator"}
    robot = sf.load_robot(path, feet=feet, fixed_base=True)
    with pytest.raises(ModelError, match="its base is bolted to the world"):
        check_point_feet(robot)


def test_a_part_of_a_scene_names_the_scene(tmp_path: Path) -> None:
    part = models.mjcf().replace('<geom name="floor" type="plane"', '<geom name="stone" type="plane"')
    pair = '<contact><pair geom1="stone" geom2="floor"/></contact></mujoco>'
    (tmp_path / "dog.xml").write_text(part.replace("</mujoco>", pair))
    (tmp_path / "scene.xml").write_text(
        '<mujoco><include file="dog.xml"/><worldbody><geom name="floor" type="plane" size="1 1 1"/>'
        "</worldbody></mujoco>"
    )
    words = r"dog.xml is not a whole model: it names the geom floor, .* the one that includes it, scene.xml$"
    with pytest.raises(ModelError, match=words):
        sf.load_robot(tmp_path / "dog.xml")


def test_joints_at_the_ends_of_their_ranges_are_held(tmp_path: Path) -> None:
    """An ankle that reaches its end where the legs are bent, and a hand that cannot help, stop no one."""
    path = write_biped(tmp_path, BOX)
    text = path.read_text()
    ankle = re.compile(r'(<joint name="\w+_ankle_joint".*?<limit )lower="[^"]*"', re.DOTALL)
    arm = (
        '<link name="arm"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="shoulder" type="revolute"><parent link="body"/><child link="arm"/><axis xyz="0 0 1"/>'
        '<limit lower="0" upper="0.001" effort="1" velocity="1"/></joint></robot>'
    )
    text, count = ankle.subn(r'\g<1>lower="-0.55"', text)
    assert count == 2
    path.write_text(text.replace("</robot>", arm))
    robot = sf.load_robot(path, feet="left_foot,right_foot")
    q = sf.place(robot)
    np.testing.assert_allclose(robot.sphere_bottoms(q), 0.0, atol=1e-6)
    low, high = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    assert ((q[7:] > low - 1e-5) & (q[7:] < high + 1e-5)).all()
