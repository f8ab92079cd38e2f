"""Every legged robot of example-robot-data goes by name and stands on the ground."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError
from surefoot.mechanics.robot import robot_names
from surefoot.mechanics.robot.catalog import CATALOG, UNREADABLE, find, robots_folder
from tests.robots import robot_of as load

LEGGED = sorted(name for name, entry in CATALOG.items() if not entry.fixed_base)
FLAT = {
    "g1", "g1_with_hands", "talos", "talos_full", "romeo", "romeo_full", "icub", "icub_full", "alexander",
    "human",
}  # fmt: skip
TWO_POINTS = {"bolt", "simple_humanoid"}
LEGS = {  # folders of example-robot-data whose robots have legs
    "a1", "alexander", "anymal_b_simple", "anymal_c_simple", "b1", "bolt", "cassie", "centauro", "g1", "go1",
    "go2", "human", "hyq", "icub", "laikago", "quadruped", "romeo", "simple_humanoid", "solo", "talos_data",
}  # fmt: skip
NO_LEGS = {
    "alex", "allegro_hand", "asr_twodof", "baxter", "borinot", "double_pendulum", "finger_edu", "hector",
    "hextilt", "iris", "kinova", "panda", "pr2", "so_arm", "tiago", "tiago_pro", "ur", "xarm", "z1",
}  # fmt: skip
MASSES = {"talos": 90.27, "icub": 28.35, "bolt": 1.254, "romeo": 40.53, "solo8": 2.177, "human": 74.71}


def test_no_legged_robot_is_left_out() -> None:
    folders = {p.name.removesuffix("_description") for p in robots_folder().iterdir()}
    assert folders <= LEGS | NO_LEGS
    named = {CATALOG[name].urdf.split("/")[0].removesuffix("_description") for name in LEGGED}
    assert named | {"cassie"} == LEGS
    assert set(robot_names()) == set(CATALOG)


def test_motors_have_limits_that_are_some() -> None:
    """The strongest leg gives half its robot's weight on a metre; files without a figure say 40 times it."""
    for name in set(LEGGED) - {"quadruped"}:  # a model of no robot that was built
        robot = load(name)
        given = robot.effort_limits[np.isfinite(robot.effort_limits)]
        assert given.max() < robot.mass * 9.81, name
    assert load("solo12").effort_limits.tolist() == [2.5] * 12
    assert load("solo12").speed_limits.tolist() == [84.0] * 12


@pytest.mark.parametrize("name", LEGGED)
def test_legged_robot_is_placed_on_the_ground(name: str) -> None:
    robot = load(name)
    assert len(robot.feet) in (2, 4)
    assert all(foot.flat == (name in FLAT) for foot in robot.feet)
    if name in MASSES:
        assert robot.mass == pytest.approx(MASSES[name], rel=1e-3)
    q = sf.place(robot)
    np.testing.assert_allclose(robot.sphere_bottoms(q), 0.0, atol=1e-6)
    left, right = robot.foot_positions(q)[:2, :2]
    heading = left - right  # from right to left
    assert np.linalg.norm(heading) > 0.04
    stance = robot.stance(q)
    assert stance.dim == sum(6 if foot.flat else 3 for foot in robot.feet)
    verdict = sf.can_stand(stance, robot.com(q), robot.mass)
    if name not in TWO_POINTS:
        assert verdict.feasible
        assert verdict.margin > 0.0
    up = pin.XYZQUATToSE3(q[:7]).rotation @ pin.XYZQUATToSE3(robot.nominal[:7]).rotation.T
    np.testing.assert_allclose(up, np.eye(3), atol=1e-6)
    assert robot.com(q)[2] > 0.1


@pytest.mark.parametrize("name", sorted(n for n in FLAT if find(n).shapes))
@pytest.mark.sampled(2)
def test_soles_lie_on_the_meshes(name: str) -> None:
    """What the catalogue calls the sole is where the foot's mesh ends."""
    robot = load(name)
    for foot in robot.feet:
        joint = robot.model.frames[foot.frame].parentJoint
        joint_from_foot = robot.model.frames[foot.frame].placement
        points = []
        for shapes in (robot.collision, robot.visual):
            for item in shapes.geometryObjects:
                if item.parentJoint == joint and type(item.geometry).__name__.startswith("BVH"):
                    raw = np.array([item.geometry.vertex(k) for k in range(item.geometry.num_vertices)])
                    at = joint_from_foot.actInv(item.placement)
                    points.append(raw @ at.rotation.T + at.translation)
        mesh = np.vstack(points)
        under = foot.centres[:, 2].min() - foot.radius
        assert under == pytest.approx(mesh[:, 2].min(), abs=1.5e-3)
        if "icub" not in name:  # whose mesh is drawn a quarter turn off
            low = foot.centres[:, :2].min(axis=0) - foot.radius
            high = foot.centres[:, :2].max(axis=0) + foot.radius
            sole = mesh[mesh[:, 2] < under + 5e-3][:, :2]
            assert np.all(low > sole.min(axis=0) - 1e-9)
            assert np.all(high < sole.max(axis=0) + 1e-9)
            assert np.all(high - low > 0.5 * np.ptp(sole, axis=0))
        else:
            extent = np.sort(np.ptp(mesh[:, :2], axis=0))
            assert np.all(np.array(foot.size)[::-1] < extent)


def test_poses_come_from_the_files() -> None:
    for name, pose in {"talos": "half_sitting", "bolt": "standing", "alexander": "default"}.items():
        entry = find(name)
        assert entry.srdf is not None
        tree = ElementTree.parse(robots_folder() / entry.srdf)
        (state,) = [s for s in tree.iter("group_state") if s.get("name") == pose]
        wanted = {j.get("name"): j.get("value") for j in state.iter("joint")}
        robot = load(name)
        for joint in robot.joint_names:
            value = robot.nominal[robot.model.joints[robot.model.getJointId(joint)].idx_q]
            assert value == pytest.approx(float(wanted.get(joint) or 0.0)), joint


def test_nobody_walks_on_straight_knees() -> None:
    robot = load("icub")
    knee = robot.model.joints[robot.model.getJointId("l_knee")].idx_q
    assert robot.nominal[knee] == -0.9  # -0.2 in its SRDF
    feet = robot.foot_positions(sf.place(robot))
    assert feet[:, 2] == pytest.approx(0.005, abs=1e-6)  # the edge of a sole is a little round


def test_what_cannot_be_read_says_why() -> None:
    assert set(UNREADABLE).isdisjoint(CATALOG)
    with pytest.raises(ModelError, match=r"cassie cannot be loaded by name: .*SDF"):
        sf.load_robot("cassie")
