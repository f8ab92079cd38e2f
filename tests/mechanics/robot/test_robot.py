from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import surefoot as sf
from benchmarks.legged import write_legged
from surefoot.base.errors import ModelError, ProblemError
from surefoot.mechanics.robot.catalog import CATALOG, find, robots_folder
from surefoot.mechanics.robot.foot import DEFAULT_RADIUS, Foot


def test_go2_is_the_published_robot() -> None:
    robot = sf.load_robot("go2")
    assert robot.mass == pytest.approx(16.085, abs=1e-3)
    assert robot.foot_names == ("FL_foot", "FR_foot", "RL_foot", "RR_foot")
    assert robot.joints == 12
    assert len(robot.joint_names) == 12


def test_g1_has_flat_feet_with_soles_from_the_urdf() -> None:
    robot = sf.load_robot("g1")
    assert robot.mass == pytest.approx(33.341, abs=1e-3)
    for foot in robot.feet:
        assert foot.flat
        np.testing.assert_allclose(foot.size, [0.17, 0.05], atol=1e-9)
    stance = robot.stance()
    assert all(isinstance(contact, sf.SoleContact) for contact in stance)
    assert stance.dim == 12


@pytest.mark.parametrize("name", sorted(CATALOG))
@pytest.mark.sampled(10)
def test_every_known_robot_loads(name: str) -> None:
    robot = sf.load_robot(name)
    entry = CATALOG[name]
    assert robot.foot_names == entry.feet
    assert robot.floating is not entry.fixed_base
    assert robot.mass > 1.0
    low, high = robot.model.lowerPositionLimit, robot.model.upperPositionLimit
    joints = slice(7, None) if robot.floating else slice(None)
    assert np.all(robot.nominal[joints] >= low[joints] - 1e-9)
    assert np.all(robot.nominal[joints] <= high[joints] + 1e-9)


def test_urdf_file_without_srdf_gets_a_standing_pose() -> None:
    path = robots_folder() / find("go2").urdf
    robot = sf.load_robot(path, feet=find("go2").feet)
    places = robot.foot_positions()
    known = sf.load_robot("go2")
    assert robot.name == "go2"
    assert np.ptp(places[:, 2]) < 5e-3  # level
    np.testing.assert_allclose(places[:, :2], known.foot_positions()[:, :2], atol=0.04)
    assert 0.2 < robot.nominal[2] < 0.45
    bent = np.abs(robot.nominal[7:].reshape(4, 3)[:, 2])
    assert np.all(bent > 0.8)


def test_foot_order_is_kept_and_choice_allowed() -> None:
    robot = sf.load_robot("go2", feet=["RR_foot", "FL_foot"])
    assert robot.foot_names == ("RR_foot", "FL_foot")
    assert robot.foot("FL").name == "FL_foot"
    with pytest.raises(ModelError, match="valid names: FL_foot, RR_foot"):
        robot.foot("FR")


def test_unknown_robot_lists_the_known() -> None:
    with pytest.raises(ModelError, match="unknown robot 'dog'; valid names: a1, alexander, ") as caught:
        sf.load_robot("dog")
    assert all(name in str(caught.value) for name in sf.robot_names())


def test_missing_urdf_and_foreign_feet(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no URDF file at"):
        sf.load_robot(tmp_path / "none.urdf", feet=["a"])
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot")
    with pytest.raises(ModelError, match="not a URDF that Pinocchio can read"):
        sf.load_robot(broken, feet=["a"])


def test_legs_of_no_length_have_a_pose(tmp_path: Path) -> None:
    path, feet = write_legged(tmp_path, 4)
    path.write_text(path.read_text().replace('"0 0 -0.2"', '"0 0 0"'))
    assert np.isfinite(sf.load_robot(path, feet=feet).nominal).all()


def test_aliases() -> None:
    assert sf.load_robot("anymal").mass == sf.load_robot("anymal_b").mass


def test_stance_lies_below_the_feet_in_terrain_frames() -> None:
    robot = sf.load_robot("go2")
    terrain = sf.SlopeTerrain(20.0)
    q = sf.place(robot, terrain)
    stance = robot.stance(q, mu=[0.1, 0.2, 0.3, 0.4], terrain=terrain, feet=["FL_foot", "RR_foot"] * 2)
    np.testing.assert_allclose(terrain.gap(stance.positions), 0.0, atol=1e-9)
    np.testing.assert_allclose(stance.mu, [0.1, 0.2, 0.3, 0.4])
    for contact in stance:
        np.testing.assert_allclose(contact.normal, terrain.normal([0.0, 0.0]), atol=1e-12)
    assert robot.stance(feet="FL_foot, RR_foot").names == ("FL_foot", "RR_foot")
    with pytest.raises(ProblemError, match="feet must be names of frames, got 3"):
        robot.stance(feet=3)  # type: ignore[arg-type]


def test_configuration_is_checked() -> None:
    robot = sf.load_robot("go2")
    with pytest.raises(ProblemError, match=r"q must have shape \(19,\)"):
        robot.configuration(np.zeros(3))
    with pytest.raises(ProblemError, match="unit quaternion"):
        robot.configuration(np.zeros(19))
    q = robot.nominal.copy()
    q[4] = np.nan
    with pytest.raises(ProblemError, match=r"q\[4\] is NaN"):
        robot.configuration(q)


def test_grasp_map_is_the_transpose_of_pinocchios_contact_jacobian() -> None:
    """Power is the same through joints and through the wrench: base rows of Jᵀ equal the grasp map."""
    robot = sf.load_robot("go2")
    rng = np.random.default_rng(7)
    model, data = robot.model, robot.data
    for _ in range(10):
        q = pin.integrate(model, robot.nominal, 0.3 * rng.normal(size=model.nv))
        terrain = sf.SlopeTerrain(float(rng.uniform(-30, 30)))
        stance = robot.stance(q, terrain=terrain)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        base = data.oMi[1]
        grasp = stance.grasp_map(about=base.translation)
        for foot, contact, columns in zip(robot.feet, stance, stance.slices, strict=True):
            J = pin.getFrameJacobian(model, data, foot.frame, pin.LOCAL_WORLD_ALIGNED)
            arm = contact.position - data.oMf[foot.frame].translation
            point = J[:3] - pin.skew(arm) @ J[3:]
            # Pinocchio's base velocity is in base axes; turn its six columns to world axes
            world = np.hstack([point[:, :3] @ base.rotation.T, point[:, 3:6] @ base.rotation.T])
            np.testing.assert_allclose(
                grasp[:, columns], world.T @ contact.rotation_world_contact, atol=1e-12
            )


def test_foot_shapes() -> None:
    point = Foot("p", 0, np.array([[0.0, 0.0, 0.1]]), DEFAULT_RADIUS)
    assert not point.flat
    assert point.size == (0.0, 0.0)
    np.testing.assert_allclose(point.centre, [0.0, 0.0, 0.1])
    corners = np.array(
        [[0.12, 0.03, -0.03], [0.12, -0.03, -0.03], [-0.05, 0.025, -0.03], [-0.05, -0.025, -0.03]]
    )
    sole = Foot("s", 0, corners, 0.005)
    np.testing.assert_allclose(sole.size, [0.17, 0.05])
    np.testing.assert_allclose(sole.centre, [0.035, 0.0, -0.03])


def test_joints_without_a_range_are_no_obstacle() -> None:
    path = robots_folder() / "quadruped_description/urdf/quadruped.urdf"
    robot = sf.load_robot(path, feet=["FL_contact", "FR_contact", "BL_contact", "BR_contact"])
    assert any("without a range in the file" in note for note in robot.notes)
    assert np.ptp(robot.foot_positions()[:, 2]) < 1e-2


def test_a_text_of_feet_is_no_list_of_letters() -> None:
    assert sf.load_robot("go2", feet="FL_foot, RR_foot").foot_names == ("FL_foot", "RR_foot")
    with pytest.raises(ModelError, match=r"unknown foot frame of go2.urdf 'toe'"):
        sf.load_robot("go2", feet="toe")
