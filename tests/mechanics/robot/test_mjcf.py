"""Robots from MJCF files are MuJoCo's, and those of URDF files of the same robot."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import MissingExtra, ModelError

mujoco = pytest.importorskip("mujoco")
pin = pytest.importorskip("pinocchio")

URDF = """<robot name="dog">
  <link name="trunk"><inertial><origin xyz="0.01 0 0.02"/><mass value="5"/>
    <inertia ixx="0.05" iyy="0.1" izz="0.12" ixy="0.003" ixz="0" iyz="0"/></inertial></link>
  {legs}
</robot>"""
LEG = """
  <link name="{n}_hip"><inertial><origin xyz="0 0.02 0" rpy="0.1 0 0.2"/><mass value="0.5"/>
    <inertia ixx="0.001" iyy="0.002" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{n}_abduct" type="revolute"><parent link="trunk"/><child link="{n}_hip"/>
    <origin xyz="{x} {y} 0" rpy="0.1 0 0.3"/><axis xyz="1 0 0"/>
    <limit lower="-0.8" upper="0.9" effort="20" velocity="10"/></joint>
  <link name="{n}_leg"><inertial><origin xyz="0 0 -0.1"/><mass value="0.3"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{n}_slide" type="prismatic"><parent link="{n}_hip"/><child link="{n}_leg"/>
    <origin xyz="0 0.05 -0.05" rpy="0 0.2 0"/><axis xyz="0 0 1"/>
    <limit lower="-0.1" upper="0.1" effort="100" velocity="10"/></joint>
  <link name="{n}_shin"><inertial><origin xyz="0 0 -0.05"/><mass value="0.2"/>
    <inertia ixx="0.0005" iyy="0.0005" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{n}_knee" type="revolute"><parent link="{n}_leg"/><child link="{n}_shin"/>
    <origin xyz="0 0 -0.2"/><axis xyz="0 0.6 0.8"/>
    <limit lower="-2" upper="0.1" effort="30" velocity="10"/></joint>
  <link name="{n}"><inertial><mass value="0.05"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.025"/></geometry></collision></link>
  <joint name="{n}_fixed" type="fixed"><parent link="{n}_shin"/><child link="{n}"/>
    <origin xyz="0.01 0 -0.2"/></joint>"""
FEET = {"FL": (0.2, 0.1), "FR": (0.2, -0.1), "RL": (-0.2, 0.1), "RR": (-0.2, -0.1)}


def urdf(folder: Path) -> Path:
    """Write our own URDF, and return it."""
    path = folder / "dog.urdf"
    path.write_text(URDF.format(legs="".join(LEG.format(n=n, x=x, y=y) for n, (x, y) in FEET.items())))
    return path


MJCF_LEG = """
  <body name="{n}_hip" pos="{x} {y} 0" quat="{quat}">
    <inertial pos="0 0.02 0" quat="{iquat}" mass="0.5" diaginertia="0.001 0.002 0.0025"/>
    <joint name="{n}_abduct" axis="1 0 0" range="-0.8 0.9" actuatorfrcrange="-20 20"/>
    <body name="{n}_leg" pos="0 0.05 -0.05" quat="{lquat}">
      <inertial pos="0 0 -0.1" mass="0.3" diaginertia="0.001 0.001 0.0001"/>
      <joint name="{n}_slide" type="slide" axis="0 0 1" range="-0.1 0.1"/>
      <body name="{n}_shin" pos="0 0 -0.2">
        <inertial pos="0 0 -0.05" mass="0.2" diaginertia="0.0005 0.0005 0.0001"/>
        <joint name="{n}_knee" axis="0 3 4" range="-2 0.1" armature="0.01" damping="1"/>
        <body name="{n}_toe" pos="0.01 0 -0.2">
          <inertial pos="0 0 0" mass="0.05" diaginertia="1e-5 1e-5 1e-5"/>
          <geom {foot} type="sphere" size="0.025" class="foot"/>{site}
        </body>
      </body>
    </body>
  </body>"""


def words(xyzw: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in (xyzw[3], *xyzw[:3]))


def turned(roll: float, pitch: float, yaw: float) -> str:
    return words(np.array(pin.Quaternion(pin.rpy.rpyToMatrix(roll, pitch, yaw)).coeffs()))


def mjcf(folder: Path, feet: str = "geoms", base: str = "<freejoint/>", more: str = "") -> Path:
    """Write the same robot as MJCF, with what that language has of its own, and return it."""
    legs = "".join(
        MJCF_LEG.format(
            n=n, x=x, y=y, quat=turned(0.1, 0.0, 0.3), iquat=turned(0.1, 0.0, 0.2),
            lquat=turned(0.0, 0.2, 0.0), foot=f'name="{n}"' if feet == "geoms" else "",
            site=f'<site name="{n}"/>' if feet == "sites" else "",
        )
        for n, (x, y) in FEET.items()
    )  # fmt: skip
    path = folder / f"dog-{feet}.xml"
    path.write_text(f"""<mujoco model="dog">
      <compiler angle="radian" autolimits="true"/>
      <default><default class="foot"><geom friction="0.8 0 0"/></default></default>
      <worldbody><geom name="floor" type="plane" size="1 1 1"/><light pos="0 0 2"/>
        <body name="trunk" pos="0 0 0.6">{base}
          <inertial pos="0.01 0 0.02" mass="5" fullinertia="0.05 0.1 0.12 0.003 0 0"/>
          <geom type="box" size="0.2 0.1 0.05"/>{legs}
        </body></worldbody>
      <actuator>{"".join(f'<motor joint="{n}_knee" gear="2" ctrlrange="-15 15"/>' for n in FEET)}
        {"".join(f'<general joint="{n}_slide" forcerange="-100 100"/>' for n in FEET)}</actuator>
      {more}</mujoco>""")
    return path


@pytest.mark.parametrize("feet", ["geoms", "sites"])
def test_urdf_and_mjcf_of_one_robot_agree(tmp_path: Path, feet: str) -> None:
    one = sf.load_robot(urdf(tmp_path), feet=list(FEET))
    two = sf.load_robot(mjcf(tmp_path, feet), feet=list(FEET))
    assert two.joint_names == one.joint_names
    assert two.mass == pytest.approx(one.mass, rel=1e-14)
    assert two.effort_limits == pytest.approx(one.effort_limits)
    assert np.allclose(two.model.lowerPositionLimit[7:], one.model.lowerPositionLimit[7:])
    assert np.allclose(two.model.upperPositionLimit[7:], one.model.upperPositionLimit[7:])
    rng = np.random.default_rng(1)
    for _ in range(5):
        q = pin.integrate(one.model, one.nominal, rng.normal(size=18))
        for a, b in zip(one.feet, two.feet, strict=True):
            assert (a.name, a.radius) == (b.name, pytest.approx(b.radius))
            assert b.centres == pytest.approx(a.centres, abs=1e-14)
        assert two.foot_positions(q) == pytest.approx(one.foot_positions(q), abs=1e-12)
        assert two.com(q) == pytest.approx(one.com(q), abs=1e-12)
        M = [pin.crba(r.model, r.model.createData(), q) for r in (one, two)]
        assert np.triu(M[1]) == pytest.approx(np.triu(M[0]), abs=1e-12)
        for name in FEET:
            J = [
                pin.computeFrameJacobian(
                    r.model, r.model.createData(), q, r.model.getFrameId(name), pin.LOCAL_WORLD_ALIGNED
                )
                for r in (one, two)
            ]
            assert J[1] == pytest.approx(J[0], abs=1e-12)
    assert two.nominal == pytest.approx(one.nominal, abs=1e-6)


def test_the_model_is_mujocos(tmp_path: Path) -> None:
    """Mass matrix, feet and centre of mass, with joints that have anchors and references of their own."""
    text = mjcf(tmp_path).read_text()
    text = text.replace('axis="0 3 4"', 'axis="0 3 4" pos="0.01 -0.02 0.03" ref="-0.4"')
    text = text.replace('name="FL_slide"', 'name="FL_slide" ref="0.05" pos="0.1 0 0"')
    text = text.replace(
        '<joint name="RR_abduct"', '<joint name="RR_yaw" axis="0 0 1"/><joint name="RR_abduct"'
    )
    path = tmp_path / "odd.xml"
    path.write_text(text)
    robot, model = sf.load_robot(path, feet=list(FEET)), mujoco.MjModel.from_xml_path(str(path))
    data, rng = mujoco.MjData(model), np.random.default_rng(2)
    assert robot.joint_names == tuple(model.joint(k).name for k in range(1, model.njnt))
    for _ in range(5):
        q = pin.integrate(robot.model, robot.nominal, rng.normal(size=robot.model.nv))
        data.qpos[:] = q
        data.qpos[3:7] = [q[6], *q[3:6]]
        mujoco.mj_forward(model, data)
        assert np.array([data.geom(n).xpos for n in FEET]) == pytest.approx(
            robot.foot_positions(q), abs=1e-12
        )
        assert data.subtree_com[1] == pytest.approx(robot.com(q), abs=1e-12)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        turn = np.eye(model.nv)  # MuJoCo's base velocity is in world axes
        turn[:3, :3] = pin.XYZQUATToSE3(q[:7]).rotation
        M = turn.T @ (M - np.diag(model.dof_armature)) @ turn
        ours = pin.crba(robot.model, robot.model.createData(), q)
        assert np.triu(ours) == pytest.approx(np.triu(M), abs=1e-12)


def test_the_base_is_as_the_file_says(tmp_path: Path) -> None:
    free = mjcf(tmp_path)
    assert sf.load_robot(free).floating
    assert not sf.load_robot(free, fixed_base=True).floating
    bolted = mjcf(tmp_path, base="")
    robot = sf.load_robot(bolted)
    assert not robot.floating
    assert robot.model.nq == 12
    assert sf.load_robot(bolted, fixed_base=False).model.nq == 19


def test_a_keyframe_is_the_nominal_pose(tmp_path: Path) -> None:
    joints = np.tile([0.1, -0.05, -0.7], 4)
    key = f'<keyframe><key name="home" qpos="0 0 0.5 1 0 0 0 {" ".join(map(str, joints))}"/></keyframe>'
    robot = sf.load_robot(mjcf(tmp_path, more=key), feet=list(FEET))
    assert robot.nominal[7:] == pytest.approx(joints)
    assert robot.foot_positions()[:, 2].min() == pytest.approx(0.025, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "<mujoco><worldbody><body><bad/></body></worldbody></mujoco>",
            "is not an MJCF that MuJoCo can read",
        ),
        ("<mujoco><worldbody/></mujoco>", "must hold one robot, it has 0"),
        (
            '<mujoco><worldbody><body name="a"><freejoint/><geom size="1"/></body><body name="b"><freejoint/>'
            '<geom size="1"/></body></worldbody></mujoco>',
            "it has 2 that move: a, b",
        ),
        (
            '<mujoco><worldbody><body><freejoint/><geom size="1"/><body><joint name="j" type="ball"/>'
            '<geom size="1"/></body></body></worldbody></mujoco>',
            "joint j is neither a hinge nor a slide",
        ),
    ],
)
def test_what_is_no_robot(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "bad.xml"
    path.write_text(text)
    with pytest.raises(ModelError, match=told):
        sf.load_robot(path)


CRANK = """<mujoco><worldbody><body name="trunk"><freejoint/><geom size="0.1"/><site name="s"/>
  <body name="crank" pos="0.1 0 0"><joint name="j1"{crank}/><geom size="0.05"/>
    <body name="rod" pos="0.1 0 0"><joint name="j2"/><geom size="0.05"/></body></body>
  <body name="foot" pos="0 0.1 0"><joint name="j3"/><geom size="0.05"/></body></body></worldbody>
  {more}</mujoco>"""
TENDON = (
    '<tendon><fixed name="t"{0}><joint joint="j1" coef="1"/><joint joint="j3" coef="-1"/></fixed></tendon>'
)


@pytest.mark.parametrize(
    ("crank", "more", "told"),
    [
        (
            "",
            '<equality><connect body1="rod" body2="foot" anchor="0 0 0"/></equality>',
            "connect of rod and foot",
        ),
        ("", '<equality><joint joint1="j1" joint2="j3"/></equality>', "joint of j1 and j3"),
        (' stiffness="5"', "", "joint with a spring: j1"),
        ("", TENDON.format(' stiffness="3"'), "tendon that pulls: t"),
        ("", TENDON.format("") + '<actuator><motor name="m" tendon="t"/></actuator>', "not on a joint: m"),
        ("", '<actuator><motor name="m" site="s"/></actuator>', "not on a joint: m"),
    ],
)
def test_what_a_tree_cannot_do_is_told(tmp_path: Path, crank: str, more: str, told: str) -> None:
    path = tmp_path / "linkage.xml"
    path.write_text(CRANK.format(crank=crank, more=more))
    with pytest.raises(ModelError, match=told) as raised:
        sf.load_robot(path)
    assert len(str(raised.value).splitlines()) == 1
    assert "is more than a tree of hinges and slides" in str(raised.value)


@pytest.mark.parametrize(
    ("crank", "more"),
    [
        (' damping="5" frictionloss="1" armature="0.1"', ""),
        ("", TENDON.format("")),
        ("", '<equality><weld body1="rod" body2="foot" active="false"/></equality>'),
        ("", '<actuator><motor joint="j1"/><motor jointinparent="j2"/></actuator>'),
    ],
)
def test_what_takes_nothing_from_a_tree_is_loaded(tmp_path: Path, crank: str, more: str) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(CRANK.format(crank=crank, more=more))
    assert sf.load_robot(path).joint_names == ("j1", "j2", "j3")


def test_a_motor_in_the_parents_axes_has_a_limit(tmp_path: Path) -> None:
    path = tmp_path / "parent.xml"
    motor = '<actuator><motor jointinparent="j2" gear="3" ctrlrange="-2 2" ctrllimited="true"/></actuator>'
    path.write_text(CRANK.format(crank="", more=motor))
    assert sf.load_robot(path).effort_limits.tolist() == [np.inf, 6.0, np.inf]


def test_placeholders_out_of_sight_are_left_aside(tmp_path: Path) -> None:
    """Files of robots with fewer motors keep the others' joints on bodies without shapes."""
    alone = sf.load_robot(mjcf(tmp_path), feet=list(FEET))
    spare = '<body name="unused" pos="0 0 20"><joint name="unused"/><inertial pos="0 0 0" mass="0.1" diaginertia="1 1 1"/></body>'  # noqa: E501
    text = mjcf(tmp_path).read_text()
    joints = np.tile([0.1, -0.05, -0.7], 4)
    pose = f"0 0 0.5 1 0 0 0 {' '.join(map(str, joints))}"
    for k, (body, key) in enumerate(
        ((f'{spare}<body name="trunk"', f"0.3 {pose}"), ('<body name="trunk"', f"{pose} 0.3"))
    ):
        changed = text.replace('<body name="trunk"', body)
        if k:
            changed = changed.replace("</body></worldbody>", f"</body>{spare}</worldbody>")
        changed = changed.replace(
            "</mujoco>", f'<keyframe><key name="home" qpos="{key}"/></keyframe></mujoco>'
        )
        path = tmp_path / f"spare{k}.xml"
        path.write_text(changed)
        robot = sf.load_robot(path, feet=list(FEET))
        assert robot.floating
        assert robot.joint_names == alone.joint_names
        assert robot.mass == pytest.approx(alone.mass, rel=1e-14)
        assert robot.nominal[7:] == pytest.approx(joints)


def test_a_foot_of_a_mesh_reaches_to_its_lowest_point(tmp_path: Path) -> None:
    """As for URDF files: MuJoCo moves and turns a mesh into its own axes, and it is put back where it was."""
    turns = 2.0 * np.pi * np.arange(5) / 5
    base = np.column_stack([0.04 + 0.03 * np.cos(turns), 0.03 * np.sin(turns), np.full(5, -0.02)])
    points = np.vstack([base, [0.06, 0.01, -0.1]])
    vertices = " ".join(map(repr, points.ravel().tolist()))
    mesh = f'<asset><mesh name="sole" vertex="{vertices}"/></asset>'
    text = CRANK.format(crank="", more=mesh)
    path = tmp_path / "mesh.xml"
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    sphere = '<joint name="j2"/><geom size="0.05"/>'
    assert sphere in text
    path.write_text(text.replace(sphere, f'<joint name="j2"/>{inertial}<geom type="mesh" mesh="sole"/>'))
    robot = sf.load_robot(path, feet=["rod"])
    foot = robot.feet[0]
    robot.sphere_bottoms(robot.nominal)  # moves the frames there
    rod = robot.data.oMf[foot.frame]
    placed = points @ rod.rotation.T + rod.translation
    touching = rod.act(foot.centre) - [0.0, 0.0, foot.radius]
    lowest = placed[placed[:, 2].argmin()]
    assert touching == pytest.approx(lowest, abs=1e-6)  # MuJoCo keeps vertices in single precision
    assert "a point" in foot.why


def test_wrong_feet_are_answered_with_frames(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"unknown foot frame of dog-geoms\.xml 'FK'.*FL"):
        sf.load_robot(mjcf(tmp_path), feet=["FK"])
    with pytest.raises(ModelError, match="no file at "):
        sf.load_robot(tmp_path / "none.xml")


def test_without_mujoco_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = mjcf(tmp_path)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtra, match=r"mujoco is not installed; run: pip install -e '\.\[sim\]'"):
        sf.load_robot(path)
