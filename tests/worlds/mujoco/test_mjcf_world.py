"""Worlds that are MJCF files: what the file says is what happens, and torques are what was asked for."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

import surefoot as sf
from benchmarks.legged import write_legged
from surefoot.app.cli.run_output import walk_headline
from surefoot.base.errors import ModelError, ProblemError
from surefoot.mechanics.robot.rotors import joint_figures
from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.records.audit import summarise_walk
from surefoot.worlds.mujoco.mjcf_world import MjcfWorld
from surefoot.worlds.running.run import Scenario, run
from surefoot.worlds.running.sensors import SensorModel
from surefoot.worlds.running.walk_terrain import start_pose
from tests.moving import advance, lifted
from tests.standing_biped import write_biped_mjcf

MODELS = Path(__file__).parents[3] / "examples" / "models"
MOTORS, SERVOS = MODELS / "quadruped.xml", MODELS / "quadruped_servos.xml"
LIMITS = np.tile([25.0, 25.0, 40.0], 4)
FEET = ["FL", "FR", "RL", "RR"]


def load(path: Path) -> sf.Robot:
    return sf.load_robot(path, feet=FEET)


def changed(tmp_path: Path, *changes: tuple[str, str], source: Path = MOTORS) -> Path:
    """Return a copy of a file with parts replaced."""
    text = source.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "changed.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_figures_of_the_file_are_those_of_joints_and_world() -> None:
    robot = load(MOTORS)
    told = joint_figures(robot)
    np.testing.assert_array_equal(told.armature, np.full(12, 0.012))
    np.testing.assert_array_equal(told.damping, np.full(12, 0.3))
    np.testing.assert_array_equal(told.friction, np.full(12, 0.25))
    assert not np.any(robot.model.armature)  # ideal joints leave rotors out
    world = MjcfWorld(robot, MOTORS)
    np.testing.assert_array_equal(world.robot.model.armature[6:], told.armature)
    np.testing.assert_array_equal(world.model.dof_damping[6:], told.damping)


@pytest.mark.parametrize("path", [MOTORS, SERVOS], ids=["motors", "servos"])
def test_actuators_give_the_torques_that_are_asked_for(path: Path) -> None:
    """In the air, joints moving: MuJoCo's actuators at their controls are torques at the joints."""
    world = MjcfWorld(load(path), path)
    q = lifted(world.robot.nominal, 1.0)
    rng = np.random.default_rng(4)
    world.reset(q, np.concatenate([np.zeros(6), rng.normal(size=12)]))
    for _ in range(20):
        asked = 10.0 * rng.normal(size=12)
        world.step(asked)
        np.testing.assert_allclose(world.applied, np.clip(asked, -LIMITS, LIMITS), atol=1e-9)
        np.testing.assert_allclose(world.data.qfrc_actuator[6:], world.applied)
    world.step(np.full(12, 100.0))
    np.testing.assert_allclose(world.applied, LIMITS)


def test_one_step_is_that_of_mujoco_itself() -> None:
    """The file, its own loop, torques as controls: the same motion as the world's."""
    world = MjcfWorld(load(MOTORS), MOTORS, mu=0.7)
    model = mujoco.MjModel.from_xml_path(str(MOTORS))
    model.opt.timestep = world.dt
    data = mujoco.MjData(model)
    data.qpos[:] = world.data.qpos
    rng = np.random.default_rng(5)
    for _ in range(200):
        torques = 5.0 * rng.normal(size=12)
        data.ctrl[:] = torques
        mujoco.mj_step(model, data)
        world.step(torques)
    np.testing.assert_allclose(world.data.qpos, data.qpos, atol=1e-9)
    assert np.abs(data.qvel).max() > 0.1


@pytest.mark.parametrize(
    "path", [pytest.param(MOTORS, marks=pytest.mark.long), SERVOS], ids=["motors", "servos"]
)
@pytest.mark.long
def test_a_quadruped_walks_in_its_own_file(path: Path) -> None:
    robot = load(path)
    world = MjcfWorld(robot, path)
    command = VelocityCommand.constant(0.4, 0.0, 0.0)
    settings = WalkSettings(actuators=world.actuators)
    controller = WalkingController(robot, command, "trot", FlatTerrain(), settings)
    start = start_pose(robot, FlatTerrain())
    log = run(world, controller, Scenario(3.0, 0.6, start=start, sensors=SensorModel(), seed=1))
    summary = summarise_walk(log)
    assert summary.good, walk_headline(summary)
    assert summary.velocity.forward.measured == pytest.approx(0.4, abs=0.02)
    weight = log["forces"][..., 2].sum(axis=1)[-800:].mean()  # two cycles of the trot
    assert weight == pytest.approx(9.81 * robot.mass, rel=0.02)


def test_a_file_without_ground_gets_the_terrains(tmp_path: Path) -> None:
    floor = '<geom name="floor" type="plane" size="0 0 0.1" friction="0.7"/>'
    path = changed(tmp_path, (floor, ""))
    robot, slope = load(path), SlopeTerrain(5.0)
    world = MjcfWorld(robot, path, slope)
    world.reset(start_pose(robot, slope))
    hold = robot.nominal[7:]
    for _ in range(400):
        q, v = world.q_v()
        world.step(120.0 * (hold - q[7:]) - 2.0 * v[6:])
    assert world.contacts().forces[:, 2].sum() == pytest.approx(
        robot.mass * 9.81 * np.cos(np.radians(5.0)), rel=0.1
    )


def test_payload_and_links(tmp_path: Path) -> None:
    """Limp, with a load: it falls on its links, and the load is part of the weight."""
    robot = load(MOTORS)
    world = MjcfWorld(robot, MOTORS, payload=3.0)
    assert float(world.model.body_mass.sum()) == pytest.approx(robot.mass + 3.0)
    advance(world, 1500, np.zeros(12))
    named = {name for pair in world.touching() for name in pair}
    assert "floor" in named
    assert named & {"trunk", "FL_shin", "FL_thigh", "FL_hip"}
    others = world.contacts().others
    assert others is not None
    held = others[2] + world.contacts().forces[:, 2].sum()
    assert held == pytest.approx(9.81 * (robot.mass + 3.0), rel=0.05)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([('<geom name="floor" type="plane"', '<geom name="ramp" type="plane" euler="0 0.2 0"')], "ramp"),
        ([('<motor class="knee" name="FL_knee" joint="FL_knee"/>',
           '<muscle class="knee" name="FL_knee" joint="FL_knee"/>')], "FL_knee"),
        ([('<motor class="knee" name="FL_knee" joint="FL_knee"/>',
           '<motor name="a" joint="FL_knee"/><motor name="b" joint="FL_knee"/>')], "FL_knee has several"),
    ],
)  # fmt: skip
def test_what_cannot_be_walked_in_is_refused(
    tmp_path: Path, changes: list[tuple[str, str]], said: str
) -> None:
    path = changed(tmp_path, *changes)
    with pytest.raises((ModelError, ProblemError), match=said):
        MjcfWorld(load(path), path)


def test_another_robot_and_another_ground_are_refused() -> None:
    with pytest.raises(ModelError, match="not one robot"):
        MjcfWorld(sf.load_robot("go2"), MOTORS)
    with pytest.raises(ProblemError, match="floor of its own"):
        MjcfWorld(load(MOTORS), MOTORS, SlopeTerrain(5.0))


def test_feet_alone_touch_where_that_is_asked_for_and_without_a_margin(tmp_path: Path) -> None:
    """Shapes that reach into each other and a margin of 10 mm: it stands on its feet, on the ground."""
    path, feet = write_legged(tmp_path, 4, "xml")
    path.write_text(
        path.read_text().replace("<worldbody>", '<default><geom margin="0.01"/></default><worldbody>')
    )
    robot = sf.load_robot(path, feet=feet)
    loads = {}
    for collision in ("feet", "full"):
        world = MjcfWorld(robot, path, collision=collision)
        for _ in range(300):
            q, v = world.q_v()
            world.step(200.0 * (robot.nominal[7:] - q[7:]) - 4.0 * v[6:])
        loads[collision] = world.contacts().forces[:, 2].sum() / (9.81 * robot.mass)
        assert bool(world.touching()) == (collision == "full")
        if collision == "feet":
            assert np.abs(world.contacts().gaps).max() < 5e-4
    assert loads["feet"] == pytest.approx(1.0, abs=0.02)
    with pytest.raises(ProblemError, match="unknown collision 'all'; valid names: feet, full"):
        MjcfWorld(robot, path, collision="all")


def test_ground_that_is_ours_is_as_soft_as_the_files_feet(tmp_path: Path) -> None:
    """Rest depth r of MuJoCo's law, k d r = (1 - d) / d A f; where the file says nothing, close to rigid."""
    path, feet = write_legged(tmp_path, 4, "xml")
    plain, depths = path.read_text(), {}
    for softness in ("", 'solref="0.04 1"', 'solimp="0.9 0.9 0.001"'):
        path.write_text(plain.replace("<worldbody>", f"<default><geom {softness}/></default><worldbody>"))
        robot = sf.load_robot(path, feet=feet)
        world = MjcfWorld(robot, path, collision="feet")
        for _ in range(500):
            q, v = world.q_v()
            world.step(400.0 * (robot.nominal[7:] - q[7:]) - 8.0 * v[6:])
        depths[softness] = -world.contacts().gaps.mean()
    assert depths[""] < 1e-4
    d, tc, foot = 0.9, 0.02, world.model.geom_bodyid[world._reader.feet.geoms[0]]  # k = 1 / (d tc)²
    inverse, load = world.model.body_invweight0[foot, 0], robot.mass * 9.81 / 4
    assert depths['solimp="0.9 0.9 0.001"'] == pytest.approx((1 - d) * inverse * load * tc**2, rel=0.05)
    assert depths['solref="0.04 1"'] > 1e-3


def test_a_missing_mesh_costs_itself_alone(tmp_path: Path) -> None:
    """What only draws is left out: the robot is simulated as before."""
    asset = '<asset><mesh name="shell" file="gone.stl"/></asset>\n  <worldbody>'
    shell = '<geom type="mesh" mesh="shell" density="0" contype="0" conaffinity="0"/>\n'
    path = changed(tmp_path, ("<worldbody>", asset), ("<freejoint", shell + "<freejoint"))
    with pytest.raises(ValueError, match=r"gone\.stl"):
        mujoco.MjModel.from_xml_path(str(path))
    world, plain = MjcfWorld(load(path), path), MjcfWorld(load(MOTORS), MOTORS)
    for one in (world, plain):
        one.step(np.ones(12))
    np.testing.assert_array_equal(world.data.qpos, plain.data.qpos)


@pytest.mark.parametrize("kind", ["box", "two boxes"])
@pytest.mark.long
def test_soles_that_are_no_spheres_stand_on_their_corners(tmp_path: Path, kind: str) -> None:
    """The file's boxes touch nothing any more; its robot stands, and its weight is on eight corners."""
    sole = '<geom class="contact" type="box" size="{} 0.04 0.01" pos="{} 0 -0.03" solref="0.01 1"/>'
    shapes = (
        sole.format(0.09, 0.02) if kind == "box" else sole.format(0.045, -0.025) + sole.format(0.045, 0.065)
    )
    path = write_biped_mjcf(tmp_path, shapes)
    robot = sf.load_robot(path, feet=["left_foot", "right_foot"])
    motors = "".join(f'<motor joint="{name}" ctrlrange="-200 200"/>' for name in robot.joint_names)
    whole = path.read_text(encoding="utf-8").replace("</mujoco>", f"<actuator>{motors}</actuator></mujoco>")
    path.write_text(whole, encoding="utf-8")
    world = MjcfWorld(robot, path)
    assert len(world.contact_foot) == 8
    model = world.model
    touching = (model.geom_contype | model.geom_conaffinity) > 0
    assert not (touching & (model.geom_type == mujoco.mjtGeom.mjGEOM_BOX)).any()
    corners = [g for g in range(model.ngeom) if model.geom(g).name.startswith("foot:")]
    np.testing.assert_allclose(model.geom_solref[corners], np.tile([0.01, 1.0], (8, 1)))
    world.reset(sf.place(robot, FlatTerrain()))
    log = run(world, walking_controller(robot, VelocityCommand.constant(0.0, 0.0, 0.0)), Scenario(0.5))
    assert log["forces"][-1, :, 2].sum() == pytest.approx(robot.mass * 9.81, rel=0.02)


def test_joints_beside_the_robot_are_named(tmp_path: Path) -> None:
    loose = '<body name="spare"><joint name="spare_joint" type="hinge"/><inertial pos="0 0 0" mass="1" '
    loose += 'diaginertia="1 1 1"/></body></worldbody>'
    path = changed(tmp_path, ("</worldbody>", loose))
    with pytest.raises(ModelError, match="on bodies of their own: spare_joint; a copy of the file"):
        MjcfWorld(load(path), path)
