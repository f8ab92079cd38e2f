"""Mended motions: forces exist for them, feet are where they should be, and what is possible stays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from benchmarks.certificate_limits import motor_cases, rising_motion
from surefoot.base.errors import ProblemError
from surefoot.records.certificates.window_kernels import Window
from surefoot.records.motions.motion import Motion
from surefoot.records.repairs.com_shift import shift_com
from surefoot.records.repairs.leg_kinematics import follow_feet
from surefoot.records.repairs.repair_settings import RepairSettings
from surefoot.records.repairs.time_warp import pace_of, warp

RATE = 30.0
MOTIONS = Path(__file__).resolve().parents[4] / "shared" / "data" / "motions"


@pytest.fixture(scope="module")
def g1() -> sf.Robot:
    return sf.load_robot("g1")


def still(robot: sf.Robot, count: int = 60) -> Motion:
    q = np.tile(robot.nominal, (count, 1))
    q[:, 2] -= min(robot.sphere_bottoms(robot.nominal))
    return Motion(robot, q, RATE)


def leaning(robot: sf.Robot, degrees: float) -> Motion:
    """Return a robot that leans forward in the middle of a motion, its soles level."""
    motion, angles = still(robot), np.zeros(60)
    angles[15:45] = np.radians(degrees) * np.sin(np.linspace(0.0, np.pi, 30))
    q = motion.q.copy()
    q[:, 4], q[:, 6] = np.sin(angles / 2.0), np.cos(angles / 2.0)
    for foot in ("left", "right"):
        q[:, 7 + robot.joint_names.index(f"{foot}_ankle_pitch_joint")] -= angles
    q[:, 2] -= [min(robot.sphere_bottoms(one)) for one in q]
    return replace(motion, q=q)


def test_what_is_possible_stays_as_it_is(g1: sf.Robot) -> None:
    report = sf.certify_motion(g1, still(g1))
    mended = sf.repair_motion(report)
    assert mended.motion is report.motion
    assert mended.mended == 1.0
    assert mended.joint_change == 0.0


def test_a_motion_that_hangs_and_drifts_comes_down(g1: sf.Robot) -> None:
    motion = still(g1)
    q = motion.q.copy()
    q[:, 2] += np.linspace(0.05, 0.15, 60)
    mended = sf.repair_motion(sf.certify_motion(g1, replace(motion, q=q)))
    assert mended.before.impossible_share == 1.0
    assert mended.report.verdict == "possible"
    assert mended.joint_change < 1e-3
    lows = [min(g1.sphere_bottoms(one)) for one in mended.motion.q]
    assert np.abs(lows).max() < 5e-3
    assert "100.0 % of its frames were impossible, 0.0 % are" in str(mended)


def test_a_lean_is_taken_back_over_the_soles(g1: sf.Robot) -> None:
    report = sf.certify_motion(g1, leaning(g1, 25.0))
    assert report.verdict == "impossible"
    mended = sf.repair_motion(report)
    assert mended.mended >= 0.8
    assert 0.0 < mended.joint_change < 0.1
    k = 30
    foot = g1.feet[0].name
    places = [g1.foot_positions(one[k])[0] for one in (report.motion.q, mended.motion.q)]
    assert np.allclose(*places, atol=5e-3), foot


def test_legs_follow_and_stay_between_their_stops(g1: sf.Robot) -> None:
    motion = still(g1, 3)
    q = motion.q.copy()
    base, shifts = np.tile([0.02, 0.03, -0.04], (3, 1)), np.zeros((3, 2, 3))
    shifts[1, 0] = [0.05, 0.0, 0.03]
    found = follow_feet(g1, q, base, shifts)
    model, data = g1.model, g1.model.createData()
    for k in range(3):
        for n, foot in enumerate(g1.feet):
            pinocchio.framesForwardKinematics(model, data, q[k])
            was = data.oMf[foot.frame].copy()
            pinocchio.framesForwardKinematics(model, data, found[k])
            now = data.oMf[foot.frame]
            assert np.allclose(now.translation, was.translation + shifts[k, n], atol=1e-4)
            assert np.allclose(now.rotation, was.rotation, atol=1e-4)
    assert np.allclose(found[:, :3], q[:, :3] + base)
    far = follow_feet(g1, q, np.tile([0.0, 0.0, 1.0], (3, 1)), np.zeros((3, 2, 3)))
    assert (far[:, 7:] <= np.array(model.upperPositionLimit)[7:] + 1e-9).all()
    assert (far[:, 7:] >= np.array(model.lowerPositionLimit)[7:] - 1e-9).all()


def test_shifts_solve_the_normal_equations_of_their_sum() -> None:
    """The gradient of the written sum of squares, by differences, is zero at the answer."""
    rng, count = np.random.default_rng(0), 12
    residual, needed, before = rng.normal(size=(count, 6)), rng.normal(size=(count, 6)), np.zeros((count, 3))
    window, mass, arm, reach = Window(1, 1, 1, 0.1), 2.0, 0.3, 0.2
    weight = mass * 9.81

    def total(d: np.ndarray) -> float:
        bend = np.zeros_like(d)
        bend[1:-1] = (d[2:] - 2.0 * d[1:-1] + d[:-2]) / 0.1**2
        force = residual[:, :3] + mass * bend
        moment = residual[:, 3:] + np.cross(d, needed[:, :3] - residual[:, :3])
        parts = (force / weight, moment / (weight * arm), (before + d) / reach)
        return float(sum((part**2).sum() for part in parts))

    found = shift_com(residual, needed, before, mass, arm, window, reach)
    for _ in range(10):
        step = 1e-4 * rng.normal(size=found.shape)
        assert total(found + step) - total(found) > 0.0
        assert total(found + step) - total(found - step) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.long
def test_what_is_too_fast_for_a_motor_is_played_slower(g1: sf.Robot) -> None:
    """Legs straighten twice as fast as the motors of the knees turn; nothing but time mends that."""
    case = list(motor_cases(rising_motion(g1)))[-1]
    report = sf.certify_motion(case.motion.robot, case.motion)
    assert report.segments[0].cure == "slow to 0.5"
    in_place = sf.repair_motion(report, RepairSettings(paces=0))
    mended = sf.repair_motion(report)
    assert in_place.motion.duration == case.motion.duration
    assert not in_place.is_warped
    assert mended.mended > 0.8 > in_place.mended
    assert mended.motion.duration > 1.5 * case.motion.duration
    assert "it lasts" in str(mended)
    assert len(mended.times) == len(mended.motion)
    assert mended.times[[0, -1]] == pytest.approx([0.0, case.motion.duration])
    assert (np.diff(mended.times) > 0.0).all()


def test_paces_stretch_time_and_keep_places(g1: sf.Robot) -> None:
    motion = leaning(g1, 25.0)
    twice, at = warp(motion, np.full(60, 0.5))
    assert len(twice) == 119
    assert np.allclose(twice.q[::2], motion.q, atol=1e-9)
    assert np.allclose(at, np.arange(119) / 2.0)
    report = sf.certify_motion(g1, motion)
    assert (pace_of(report, RepairSettings(slowest=1.0)) == 1.0).all()
    assert (pace_of(sf.certify_motion(g1, still(g1)), RepairSettings()) == 1.0).all()


@pytest.mark.parametrize("name", ["go2", "talos"])
def test_other_robots_come_down(name: str) -> None:
    robot = sf.load_robot(name)
    motion = still(robot)
    q = motion.q.copy()
    q[:, 2] += 0.06
    mended = sf.repair_motion(sf.certify_motion(robot, replace(motion, q=q)))
    assert mended.report.verdict == "possible"


def test_wrong_input_is_named(g1: sf.Robot) -> None:
    with pytest.raises(ProblemError, match="report must be a MotionReport"):
        sf.repair_motion(still(g1))  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="shorter"):
        sf.repair_motion(sf.certify_motion(g1, still(g1, 3)))
    report = sf.certify_motion(g1, still(g1), terrain=sf.SlopeTerrain(5.0))
    with pytest.raises(ProblemError, match="level ground"):
        sf.repair_motion(report)


@pytest.mark.long
@pytest.mark.skipif(not MOTIONS.exists(), reason="no shared motions")
@pytest.mark.parametrize(
    "name",
    [
        "asap_jump_forward_level3", "asap_kick_level1", "asap_side_jump_level3",
        "asap_single_foot_balance_level2", "asap_squat_level1", "gmr_walk_008",
    ],
)  # fmt: skip
def test_four_of_five_impossible_frames_of_public_motions_are_mended(g1: sf.Robot, name: str) -> None:
    mended = sf.repair_motion(sf.certify_motion(g1, sf.read_motion(MOTIONS / f"{name}.pkl", g1)))
    print(f"\n{mended}")
    assert mended.mended >= 0.8
    assert mended.joint_change < 0.1
