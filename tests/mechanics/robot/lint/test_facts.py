"""Facts read from files that hold each kind of part once, and what the subject of a lint makes of them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from surefoot.mechanics.robot.lint.facts import ModelFacts, ShapeFacts, limb_twin, side_twin
from surefoot.mechanics.robot.lint.mjcf_facts import mjcf_facts
from surefoot.mechanics.robot.lint.subject import Subject, kin_of
from surefoot.mechanics.robot.lint.urdf_facts import urdf_facts
from tests.mechanics.robot.lint.facts_by_hand import joint, link, subject


@pytest.mark.parametrize(
    ("name", "side", "limb"),
    [
        ("left_hip", "*_hip", "*_hip"), ("RIGHT_HIP", "*_hip", "*_hip"), ("hip_l", "hip_*", "hip_*"),
        ("FL_calf", "f*_calf", "*_calf"), ("lf_calf", "f*_calf", "*_calf"), ("HR_calf", "h*_calf", "*_calf"),
        ("rl_calf", "r*_calf", "*_calf"), ("RR_calf", "r*_calf", "*_calf"), ("lb_calf", "b*_calf", "*_calf"),
        ("front_calf", None, "*_calf"), ("rearCalf", None, "*_calf"), ("trunk", None, None),
        ("LeftFoot2", "*_foot_2", "*_foot_2"), ("hind_leg", None, "*_leg"), ("back_leg", None, "*_leg"),
    ],
)  # fmt: skip
def test_twins_share_what_is_left_of_their_names(name: str, side: str | None, limb: str | None) -> None:
    assert (side_twin(name), limb_twin(name)) == (side, limb)


def test_groups_are_links_that_fixed_joints_weld() -> None:
    joints = [
        joint("a", "fixed", parent="trunk", child="box"), joint("b", "fixed", parent="box", child="lid"),
        joint("c", parent="trunk", child="leg"), joint("d", "fixed", parent="leg", child="foot"),
    ]  # fmt: skip
    about = subject(joints, [link(name) for name in ("lid", "foot", "trunk", "leg", "box")])
    names = [[one.name for one in group] for group in about.facts.groups()]
    assert names == [["trunk", "lid", "box"], ["leg", "foot"]]
    assert about.facts.root == "trunk"
    assert sorted(about.facts.below("trunk")) == ["box", "foot", "leg", "lid", "trunk"]
    assert sorted(about.facts.below("leg")) == ["foot", "leg"]


def test_loops_of_fixed_joints_end() -> None:
    loop = [joint("a", "fixed", parent="x", child="y"), joint("b", "fixed", parent="y", child="x")]
    facts = subject(loop, [link("x"), link("y")]).facts
    assert sorted(one.name for group in facts.groups() for one in group) == ["x", "y"]
    assert sorted(facts.below("x")) == ["x", "y"]
    assert facts.root == ""


def test_the_mass_is_that_of_links_with_a_finite_positive_one() -> None:
    links = [link("a", 2.0), link("b", -1.0), link("c", math.inf), link("d", math.nan), link("e", 3.0)]
    assert subject((), links).facts.mass == 5.0


def test_the_reach_is_the_longest_chain_with_slips_counted_as_the_usual() -> None:
    """0.1 + 0.2 + 0.3 and a centre of mass at 0.05; one offset of 31 times the median is taken for that."""
    joints = [
        joint("a", length=0.1, parent="trunk", child="x"), joint("b", length=0.2, parent="x", child="y"),
        joint("c", length=0.3, parent="y", child="z"), joint("d", length=0.2, parent="trunk", child="w"),
    ]  # fmt: skip
    links = [link(name) for name in ("trunk", "x", "y", "w")]
    far = link("z", com=np.array([0.0, 0.0, 0.05]))
    assert subject(joints, [*links, far]).reach == pytest.approx(0.65)
    joints[2].origin[2] = 6.3  # of a median of 0.2
    assert subject(joints, [*links, far]).reach == pytest.approx(0.55)
    joints[2].origin[2] = 5.9
    assert subject(joints, [*links, far]).reach == pytest.approx(6.25)
    lone = [link("a", com=np.array([0.0, 0.3, 0.4])), link("b", com=np.full(3, math.nan))]
    assert subject((), lone).reach == pytest.approx(0.5)
    assert subject().reach == 0.0
    loop = [joint("a", parent="x", child="y"), joint("b", parent="y", child="x")]
    assert subject(loop, [link("x"), link("y")]).reach == pytest.approx(0.2)


def test_an_extent_is_the_farthest_joint_or_the_largest_shape() -> None:
    shapes = [
        ShapeFacts("trunk", "box", (0.1, 0.4, 0.2), True), ShapeFacts("trunk", "sphere", (0.3,), True),
        ShapeFacts("trunk", "mesh", (9.0, 9.0, 9.0), True), ShapeFacts("calf", "box", (math.nan, 9.0), True),
    ]  # fmt: skip
    about = subject([joint("a", length=0.5), joint("b", length=0.2, parent="calf")], shapes=shapes)
    assert about.shape_reach == {"trunk": 0.4}
    assert about.extent("trunk") == pytest.approx(0.5)
    assert about.extent("calf") == pytest.approx(0.2)
    assert about.extent("foot") == 0.0


def test_leg_joints_are_those_of_one_degree_that_move_a_foot() -> None:
    joints = [SimpleNamespace(nv=nv, idx_v=at) for nv, at in ((0, 0), (6, 0), (1, 6), (1, 7), (3, 8))]
    model = SimpleNamespace(names=["universe", "root", "hip", "tail", "ball"], joints=joints)
    moved = np.array([[*6 * [True], True, False, *3 * [True]], [*6 * [True], False, False, *3 * [True]]])
    points = SimpleNamespace(foot_support=moved)
    facts = ModelFacts(Path("dog.urdf"), "urdf")
    robot = SimpleNamespace(feet=["a"], model=model, contact_points=points)
    assert Subject(facts, robot).leg_joints == {"hip"}
    robot.feet = []
    assert Subject(facts, robot).leg_joints == frozenset()
    assert Subject(facts).leg_joints == frozenset()


def test_kin_are_measured_by_the_median_of_the_others() -> None:
    links = [link("a", 1.0), link("b", 2.0), link("c", 4.0), link("d", 8.0), link("alone", 9.0), link("none")]
    keys = {"alone": "other", "none": None}
    found = list(kin_of(links, lambda name: keys.get(name, "kin"), lambda one: one.mass))
    assert [(one.name, usual) for one, usual, _ in found] == [("a", 4.0), ("b", 4.0), ("c", 2.0), ("d", 2.0)]
    assert [one.name for one in found[1][2]] == ["a", "c", "d"]


URDF = """<robot name="r"><link name="a"><inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
<mass value="4"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>
<collision><geometry><box size="1 2 3"/></geometry></collision>
<visual><geometry><cylinder radius="0.1" length="0.2"/></geometry></visual>
<collision><geometry><sphere radius="0.5"/></geometry></collision><collision/>
<visual><geometry><mesh filename="own.stl" scale="1 1 2"/></geometry></visual>
<visual><geometry><mesh/></geometry></visual></link><link name="b"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 5"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="+inf" effort="x" velocity="7"/><dynamics damping="0.5"/><mimic joint="k"/></joint>
<joint name="k" type="screw"/><transmission name="t"><joint name="j"/></transmission>
<transmission><joint/></transmission></robot>"""


def test_a_urdf_s_parts_are_read(tmp_path: Path) -> None:
    (tmp_path / "own.stl").write_text("solid")
    facts = urdf_facts(tmp_path / "r.urdf", ET.fromstring(URDF), ())
    a, b = facts.links
    assert (a.name, a.mass, a.inertial, b.name, b.mass, b.inertial) == ("a", 4.0, True, "b", 0.0, False)
    np.testing.assert_allclose(a.com, [1.0, 2.0, 3.0])
    np.testing.assert_allclose(a.inertia, np.diag([2.0, 1.0, 3.0]), atol=1e-12)  # turned a quarter about z
    assert [(s.link, s.kind, s.size, s.collides, s.text) for s in facts.shapes] == [
        ("a", "box", (1.0, 2.0, 3.0), True, ""), ("a", "sphere", (0.5,), True, ""),
        ("a", "cylinder", (0.1, 0.2), False, ""), ("a", "mesh", (1.0, 1.0, 2.0), False, "own.stl"),
        ("a", "mesh", (1.0, 1.0, 1.0), False, ""),
    ]  # fmt: skip
    assert [s.file for s in facts.shapes[3:]] == [tmp_path / "own.stl", None]
    j, k = facts.joints
    assert (j.name, j.kind, j.parent, j.child, j.lower, j.upper) == (
        "j",
        "revolute",
        "a",
        "b",
        -1.0,
        math.inf,
    )
    assert (j.speed, j.damping, j.mimics, j.limited, j.moves) == (7.0, 0.5, "k", True, True)
    assert math.isnan(j.effort)
    np.testing.assert_allclose([j.origin, j.axis], [[0.0, 0.0, 5.0], [0.0, 0.0, 1.0]])
    assert (k.parent, k.child, k.damping, k.mimics, k.limited, k.moves) == ("", "", 0.0, "", False, False)
    np.testing.assert_allclose([k.origin, k.axis], [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert all(math.isnan(x) for x in (k.lower, k.upper, k.effort, k.speed))
    assert [tuple(fault) for fault in facts.faults] == [
        ("not-a-number", "joint j, limit effort", "x", ""),
        ("tree-broken", "joint k", "screw", "no kind of joint"),
    ]  # fmt: skip
    assert [(m.name, m.joint) for m in facts.actuators] == [("t", "j"), ("transmission", "")]


@pytest.mark.parametrize(
    ("rpy", "inertia"),
    [
        ("0.3 0 0", [[1.0, 0, 0], [0, 2.0873321925, -0.2823212367], [0, -0.2823212367, 2.9126678075]]),
        ("0 0.3 0", [[1.1746643850, 0, 0.5646424734], [0, 2.0, 0], [0.5646424734, 0, 2.8253356150]]),
        ("0 0 0.3", [[1.0873321925, -0.2823212367, 0], [-0.2823212367, 1.9126678075, 0], [0, 0, 3.0]]),
    ],
)
def test_an_inertial_is_turned_by_its_own_angles(rpy: str, inertia: list[list[float]]) -> None:
    """By hand: of moments p and q, cos² 0.3 p + sin² 0.3 q and sin 0.3 cos 0.3 (p - q)."""
    text = URDF.replace("0 0 1.5707963267948966", rpy)
    facts = urdf_facts(Path("r.urdf"), ET.fromstring(text), ())
    np.testing.assert_allclose(facts.links[0].inertia, inertia, atol=1e-9)


def test_roll_comes_first_and_yaw_last() -> None:
    """A quarter about x takes z to -y, and a quarter about z that to x: x of the file is y of the link."""
    quarter = "1.5707963267948966"
    text = URDF.replace(f"0 0 {quarter}", f"{quarter} 0 {quarter}")
    facts = urdf_facts(Path("r.urdf"), ET.fromstring(text), ())
    np.testing.assert_allclose(facts.links[0].inertia, np.diag([3.0, 1.0, 2.0]), atol=1e-12)


@pytest.mark.parametrize("xyz", ["1 2", "1 2 3 4", "1 2 inf", "1 2 x", ""])
def test_numbers_that_are_none_are_faults_and_nan(xyz: str) -> None:
    facts = urdf_facts(Path("r.urdf"), ET.fromstring(URDF.replace('1 2 3" rpy', f'{xyz}" rpy')), ())
    assert np.isnan(facts.links[0].com).all()
    assert tuple(facts.faults[0]) == ("not-a-number", "link a, origin xyz", xyz or "nothing", "")


MJCF = """<mujoco><compiler angle="{unit}" meshdir="meshes" autolimits="true"/><asset>
<mesh name="m" file="m.obj" scale="1 2 3"/></asset><worldbody><body name="a" pos="0 0 1"><freejoint/>
<inertial pos="1 2 3" mass="4" fullinertia="3 2 1.5 0.1 0.2 0.3"/><geom type="capsule" size="0.1 0.2"/>
<geom type="capsule" size="0.1" fromto="0 0 0 0 0 1"/><geom type="mesh" mesh="m" contype="0" conaffinity="0"/>
<body name="b" pos="0 0 2"><joint name="j" range="-90 0" damping="0.5" armature="0.25" axis="0 1 0"
actuatorfrcrange="-3 2"/><inertial pos="0 0 0" mass="1" quat="2 0 0 2" diaginertia="1 2 2.5"/>
<geom type="sphere" size="0.1" contype="0" conaffinity="1"/></body>
<body name="c"><joint type="slide" range="0 2"/><joint type="hinge"/>
<geom type="box" size="1 1 1" mass="6"/></body>
<body><geom type="ellipsoid" size="0.1 0.2 0.3"/></body></body></worldbody>
<actuator><motor name="t" joint="j" gear="3" forcerange="-1 1"/><position joint="j" kp="5" kv="2" gear="2"
ctrlrange="-2 2"/></actuator></mujoco>"""
MESH = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def facts_of(folder: Path, unit: str) -> ModelFacts:
    """Return the facts of an MJCF file that has one of each part."""
    mujoco = pytest.importorskip("mujoco")
    path = folder / "r.xml"
    (folder / "meshes").mkdir()
    (folder / "meshes" / "m.obj").write_text(MESH)
    path.write_text(MJCF.format(unit=unit))
    spec = mujoco.MjSpec.from_file(str(path))
    return mjcf_facts(mujoco, path, spec, spec.compile())


@pytest.mark.parametrize(("unit", "low"), [("degree", -math.pi / 2.0), ("radian", -90.0)])
def test_an_mjcf_s_joints_and_actuators_are_read(unit: str, low: float, tmp_path: Path) -> None:
    facts = facts_of(tmp_path, unit)
    free, j, slide, hinge, weld = facts.joints
    assert (free.kind, free.parent, free.child, free.moves) == ("floating", "world", "a", False)
    assert (j.kind, j.parent, j.child, j.upper, j.limited) == ("revolute", "a", "b", 0.0, True)
    assert j.lower == pytest.approx(low)
    assert (j.effort, j.damping, j.armature) == (3.0, 0.5, 0.25)
    np.testing.assert_allclose([j.origin, j.axis], [[0.0, 0.0, 2.0], [0.0, 1.0, 0.0]])
    assert (slide.name, slide.kind, slide.lower, slide.upper) == ("joint 1 of c", "prismatic", 0.0, 2.0)
    assert (hinge.name, hinge.limited) == ("joint 2 of c", False)
    assert all(math.isnan(x) for x in (hinge.lower, hinge.upper, hinge.effort))
    assert (weld.kind, weld.parent, weld.child) == ("fixed", "a", "body_4")
    t, servo = facts.actuators
    assert (t.name, t.joint, t.gear, t.force, t.command) == ("t", "j", 3.0, (-1.0, 1.0), None)
    assert (t.on_joint, t.stiffness, t.damping) == (True, 0.0, 0.0)
    assert (servo.name, servo.force, servo.command) == ("actuator 2", None, (-2.0, 2.0))
    assert (servo.stiffness, servo.damping) == pytest.approx((20.0, 8.0))  # of the joint: gear squared


def test_an_mjcf_s_links_and_shapes_are_read(tmp_path: Path) -> None:
    facts = facts_of(tmp_path, "degree")
    a, b, c, d = facts.links
    assert (a.mass, a.inertial, b.inertial, d.name) == (4.0, True, True, "body_4")
    np.testing.assert_allclose(a.com, [1.0, 2.0, 3.0])
    np.testing.assert_allclose(a.inertia, [[3.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 1.5]])
    np.testing.assert_allclose(b.inertia, np.diag([2.0, 1.0, 2.5]), atol=1e-12)  # turned a quarter about z
    assert c.mass == pytest.approx(6.0)
    np.testing.assert_allclose(c.inertia, np.diag(3 * [4.0]))  # a cube of 2 m: m s² / 6
    assert [(s.kind, s.size, s.collides) for s in facts.shapes] == [
        ("capsule", (0.1, 0.2), True), ("capsule", (0.1,), True), ("mesh", (1.0, 2.0, 3.0), False),
        ("sphere", (0.1,), True), ("box", (1.0, 1.0, 1.0), True), ("ellipsoid", (0.1, 0.2, 0.3), True),
    ]  # fmt: skip
    assert facts.shapes[2].text == "m.obj"
    assert facts.shapes[2].file == tmp_path / "meshes" / "m.obj"
    assert not facts.faults
