"""Verdicts of motions against proofs that are checked with NumPy alone, and attempts to make them lie."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.records.certificates.frame_certificate import FrameCertificate
from surefoot.records.certificates.motion_report import MotionReport
from surefoot.records.motions.motion import Motion

RATE = 30.0


@pytest.fixture(scope="module")
def g1() -> sf.Robot:
    return sf.load_robot("g1")


def still(robot: sf.Robot, count: int = 40, rate: float = RATE) -> Motion:
    q = np.tile(robot.nominal, (count, 1))
    return Motion(robot, q, rate, "still")


def moved(motion: Motion, path: np.ndarray) -> Motion:
    q = motion.q.copy()
    q[:, :3] += path
    return replace(motion, q=q)


def proves(proof: FrameCertificate, impossible: float) -> bool:
    """Return whether a residual proves that no forces leave less, by arithmetic of its own."""
    needed, maps, r = proof.needed, proof.maps, proof.residual
    size = np.linalg.norm(r)
    onto = np.einsum("dci,d->ci", maps, r)
    polar = (onto[:, 2] + proof.mu * np.hypot(onto[:, 0], onto[:, 1]) <= 1e-8 * size).all()
    return bool(polar and (r[6:] >= -1e-8 * size).all() and needed @ r > impossible * size)


def attains(proof: FrameCertificate) -> bool:
    """Return whether forces in their cones and torques in their limits leave what a proof says."""
    f = proof.forces
    inside = (np.hypot(f[:, 0], f[:, 1]) <= proof.mu * f[:, 2] + 1e-9).all() and (f[:, 2] >= 0.0).all()
    left = proof.needed - np.einsum("dci,ci->d", proof.maps, f)
    unit = proof.mass * 9.81 * proof.arm
    over = np.maximum(proof.torques - proof.torque_high, proof.torque_low - proof.torques) / unit
    over = np.linalg.norm(np.maximum(over, 0.0))
    return bool(inside and np.hypot(np.linalg.norm(left[:6]), over) <= proof.share + 1e-6)


def check_report(report: MotionReport) -> None:
    verdict = report.frames.verdict
    for k in np.flatnonzero(verdict != "no window"):
        proof = report.certificate(int(k))
        assert proof.share == pytest.approx(report.frames.share[k], abs=1e-9)
        assert attains(proof), k
        if verdict[k] == "impossible":
            assert proves(proof, report.impossible), k
        if verdict[k] == "possible":
            assert proof.share <= report.possible


def test_standing_still_is_possible(g1: sf.Robot) -> None:
    report = sf.certify_motion(g1, still(g1))
    assert report.verdict == "possible"
    assert report.frames.share[report.frames.verdict == "possible"].max() < 1e-6
    assert report.segments == ()
    assert report.good() == ((0.0, 39 / RATE),)
    assert "possible" in str(report)
    check_report(report)


def test_a_robot_may_be_named(g1: sf.Robot) -> None:
    named, given = (sf.certify_motion(robot, still(g1)) for robot in ("g1", g1))
    np.testing.assert_array_equal(named.frames.share, given.frames.share)
    with pytest.raises(sf.SurefootError, match="nobody"):
        sf.certify_motion("nobody", still(g1))


def test_a_floating_robot_hangs_and_is_told_by_how_much(g1: sf.Robot) -> None:
    report = sf.certify_motion(g1, moved(still(g1), np.array([0.0, 0.0, 0.05])))
    assert report.verdict == "impossible"
    assert report.impossible_share == 1.0
    (segment,) = report.segments
    assert (segment.cause, segment.cure) == ("hangs", "lower the root by 5 cm")
    assert np.allclose(report.frames.gap, 0.05, atol=1e-3)
    assert np.allclose(report.frames.force[5], [0.0, 0.0, g1.mass * 9.81], atol=1e-6)
    check_report(report)


def test_gliding_feet_slide(g1: sf.Robot) -> None:
    path = np.outer(np.arange(40) / RATE, [0.5, 0.0, 0.0])
    report = sf.certify_motion(g1, moved(still(g1), path))
    assert report.verdict == "impossible"
    assert {s.cause for s in report.segments} == {"slides"}
    assert report.frames.slide_speed[10] == pytest.approx(0.5, abs=1e-6)
    check_report(report)


def test_leaning_tips_over_the_sole_and_no_pace_helps(g1: sf.Robot) -> None:
    motion = still(g1)
    q = motion.q.copy()
    angle = np.radians(20.0)
    q[:, 3:7] = [0.0, np.sin(angle / 2.0), 0.0, np.cos(angle / 2.0)]
    for foot in ("left", "right"):  # the soles stay level
        q[:, 7 + g1.joint_names.index(f"{foot}_ankle_pitch_joint")] -= angle
    q[:, 2] -= min(g1.sphere_bottoms(q[0]))
    report = sf.certify_motion(g1, replace(motion, q=q))
    assert report.verdict == "impossible"
    (segment,) = report.segments
    assert segment.cause == "tips over the sole"
    assert "no pace helps" in segment.cure
    check_report(report)


@pytest.mark.parametrize(("gravity", "verdict"), [(9.81, "possible"), (4.0, "impossible")])
def test_only_gravity_acts_in_flight(g1: sf.Robot, gravity: float, verdict: str) -> None:
    t = np.arange(30) / RATE
    path = np.stack([0.3 * t, 0.0 * t, 3.0 + 2.0 * t - 0.5 * gravity * t**2], axis=1)
    report = sf.certify_motion(g1, moved(still(g1, 30), path))
    assert report.verdict == verdict
    if verdict == "impossible":
        (segment,) = report.segments
        assert segment.cause == "dynamics in flight"
        assert "falls at 4.0 m/s²" in segment.cure
        assert "1.57 of its speed" in segment.cure
    check_report(report)


def weak(robot: sf.Robot, joint: str, limit: float) -> sf.Robot:
    out = copy.copy(robot)
    out.effort_limits = robot.effort_limits.copy()
    for k, name in enumerate(robot.joint_names):
        if joint in name:
            out.effort_limits[k] = limit
    return out


def test_weak_knees_are_named_and_a_stop_carries_them(g1: sf.Robot) -> None:
    robot = weak(g1, "knee", 1.0)
    report = sf.certify_motion(robot, still(robot))
    assert report.verdict == "impossible"
    (segment,) = report.segments
    assert segment.cause == "torque of a joint"
    assert "knee" in segment.where
    check_report(report)
    stopped = copy.copy(robot)
    stopped.model = robot.model.copy()
    stopped.model.upperPositionLimit = np.where(
        ["knee" in n for n in ["base"] * 7 + list(robot.joint_names)],
        np.maximum(robot.nominal, -9.0),
        robot.model.upperPositionLimit,
    )
    assert sf.certify_motion(stopped, still(stopped)).verdict == "possible"


def test_without_friction_nothing_is_pushed_sideways(g1: sf.Robot) -> None:
    t = np.arange(60) / RATE
    sway = np.stack([0.0 * t, 0.03 * np.sin(2.0 * np.pi * 1.5 * t), 0.0 * t], axis=1)
    q = still(g1, 60).q
    q[:, :3] += sway
    reports = {mu: sf.certify_motion(g1, Motion(g1, q, RATE), mu=mu) for mu in (0.0, 0.8)}
    assert reports[0.0].score > reports[0.8].score
    for report in reports.values():
        check_report(report)
    assert sf.certify_motion(g1, still(g1), mu=0.0).verdict == "possible"
    assert sf.certify_motion(g1, still(g1), mu=[0.8, 0.0]).verdict == "possible"


@pytest.mark.parametrize("scale", [1e-3 / 33.34, 1e4 / 33.34])
def test_verdicts_do_not_depend_on_the_mass(g1: sf.Robot, scale: float) -> None:
    robot = copy.copy(g1)
    robot.model = g1.model.copy()
    for body in robot.model.inertias:
        body.mass *= scale
        body.inertia *= scale
    robot.__dict__.pop("mass", None)
    robot.effort_limits = g1.effort_limits * scale
    rng = np.random.default_rng(3)
    wild = random_motion(g1, rng)
    one, other = sf.certify_motion(g1, wild), sf.certify_motion(robot, wild)
    assert np.allclose(one.frames.share, other.frames.share, atol=1e-6, equal_nan=True)
    assert (one.frames.verdict == other.frames.verdict).all()
    check_report(other)


def random_motion(robot: sf.Robot, rng: np.random.Generator, count: int = 30) -> Motion:
    """Return a smooth wild motion about the ground."""
    import pinocchio

    nv = robot.model.nv
    t = np.arange(count) / RATE
    waves = [rng.normal(0.0, 0.3, nv) for _ in range(3)]
    q = []
    for s in t:
        step = sum(w * np.sin(2.0 * np.pi * (k + 0.5) * s + k) / (k + 1) for k, w in enumerate(waves))
        q.append(pinocchio.integrate(robot.model, robot.nominal, np.asarray(step)))
    out = np.array(q)
    out[:, 2] += 0.02 - np.array([min(robot.sphere_bottoms(x)) for x in out])
    return Motion(robot, out, RATE, "wild")


@pytest.mark.parametrize("name", ["g1", "go2"])
@pytest.mark.parametrize("seed", range(4))
def test_proofs_hold_on_wild_motions(name: str, seed: int) -> None:
    robot, rng = sf.load_robot(name), np.random.default_rng(seed)
    report = sf.certify_motion(robot, random_motion(robot, rng), mu=float(rng.choice([0.0, 0.3, 0.8, 5.0])))
    check_report(report)


def test_wild_motions_on_a_slope_and_on_stairs(g1: sf.Robot) -> None:
    for terrain in (sf.SlopeTerrain(20.0), sf.StairsTerrain(0.1, 0.3)):
        report = sf.certify_motion(g1, random_motion(g1, np.random.default_rng(1)), terrain=terrain)
        check_report(report)


def test_noise_of_sensors_is_no_impossible_motion(g1: sf.Robot) -> None:
    import pinocchio

    rng, motion = np.random.default_rng(0), still(g1, 300)
    q = motion.q.copy()
    q[:, :3] += rng.normal(0.0, 1e-3, (300, 3))
    turns = np.hstack([np.zeros((300, 3)), rng.normal(0.0, np.radians(0.3), (300, g1.model.nv - 3))])
    q = np.array([pinocchio.integrate(g1.model, a, b) for a, b in zip(q, turns, strict=True)])
    report = sf.certify_motion(g1, replace(motion, q=q))
    assert report.window == pytest.approx(0.1)  # and its means as long
    assert report.noise > 0.02
    assert report.impossible_share <= 0.01


def test_a_motion_shorter_than_a_window_has_no_verdict(g1: sf.Robot) -> None:
    for count in (1, 2, 4):
        report = sf.certify_motion(g1, still(g1, count))
        assert report.verdict == "cannot tell"
        assert (report.frames.verdict == "no window").all()
        assert np.isnan(report.score)
        assert "cannot tell" in str(report)


def test_files_say_what_the_report_says(g1: sf.Robot, tmp_path) -> None:
    import csv
    import json

    report = sf.certify_motion(g1, moved(still(g1), np.array([0.0, 0.0, 0.05])))
    facts = json.loads(report.to_json(tmp_path / "a.json").read_text())
    assert facts["verdict"] == "impossible"
    assert len(facts["columns"]["share"]) == 40
    assert facts["columns"]["share"][0] is None
    with report.to_csv(tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert rows[10]["cause"] == "hangs"
    assert float(rows[10]["needed_force_z"]) == pytest.approx(report.needed[10, 2])
    assert not any(name.startswith("contact_") for name in rows[0])


def test_wrenches_of_links_are_what_is_needed_less_what_is_left(g1: sf.Robot) -> None:
    sway = np.zeros((40, 3))
    sway[:, 1] = 0.04 * np.sin(np.linspace(0.0, 4.0 * np.pi, 40))
    report = sf.certify_motion(g1, moved(still(g1), sway))
    wrenches = report.contact_wrenches()
    assert {"left_ankle_roll_link", "right_ankle_roll_link"} <= set(wrenches)
    k, sums = report.data.frames, sum(wrenches.values())
    left = np.hstack([report.frames.force, report.frames.moment])
    assert np.allclose(sums[k], (report.needed - left)[k], atol=1e-5 * 33.34 * 9.81)
    assert np.isnan(sums[0]).all()
    proof = report.certificate(20)
    own = [n.startswith("left_ankle") for n in proof.names]
    force = proof.forces_world[own].sum(axis=0)
    assert np.allclose(wrenches["left_ankle_roll_link"][20, :3], force)


@pytest.mark.parametrize("write", [MotionReport.to_json, MotionReport.to_csv])
def test_a_file_that_exists_is_kept(g1: sf.Robot, tmp_path, write) -> None:
    path = tmp_path / "mine"
    path.write_text("mine")
    with pytest.raises(ProblemError, match="exists already"):
        write(sf.certify_motion(g1, still(g1)), path)
    assert path.read_text() == "mine"


def test_a_log_is_certified_as_the_motion_in_it(g1: sf.Robot) -> None:
    motion = still(g1)
    log = sf.Log({"time": motion.times, "q": motion.q, "v": np.zeros((len(motion), g1.model.nv))})
    report = sf.certify_motion(g1, log)
    assert report.verdict == "possible"
    assert np.array_equal(report.frames.share, sf.certify_motion(g1, motion).frames.share, equal_nan=True)


def test_wrong_input_is_named(g1: sf.Robot) -> None:
    motion = still(g1)
    spoilt = motion.q.copy()
    spoilt[7, 3] = np.nan
    zero = motion.q.copy()
    zero[3, 3:7] = 0.0
    for wrong, words in (
        ({"motion": replace(motion, q=spoilt)}, "q"),
        ({"motion": replace(motion, q=zero)}, "unit quaternion"),
        ({"motion": replace(motion, q=motion.q[:, :-1])}, "shape"),
        ({"motion": replace(motion, rate=0.0)}, "rate"),
        ({"mu": -1.0}, "mu"),
        ({"mu": np.nan}, "mu"),
        ({"mu": [0.8, 0.8, 0.8]}, "mu"),
        ({"sliding_mu": (0.8, 0.3)}, "sliding_mu"),
        ({"window": -0.1}, "window"),
        ({"terrain": "flat"}, "terrain"),
    ):
        given = {"motion": motion, **wrong}
        with pytest.raises(ProblemError, match=words):
            sf.certify_motion(g1, **given)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="window"):
        sf.certify_motion(g1, motion).certificate(0)


@pytest.mark.parametrize("kind", ["line", "point", "dot", "none"])
def test_proofs_hold_on_degenerate_soles(g1: sf.Robot, kind: str) -> None:
    robot, feet = copy.copy(g1), []
    robot.__dict__.pop("contact_points", None)
    for foot in g1.feet:
        centres = foot.centres[:1] if kind == "point" else foot.centres.copy()
        if kind == "line":
            centres[:, 1] *= 1e-9
        if kind == "dot":
            centres = centres.mean(axis=0) + 1e-9 * (centres - centres.mean(axis=0))
        feet.append(replace(foot, centres=centres))
    robot.feet = () if kind == "none" else tuple(feet)
    motion = random_motion(g1, np.random.default_rng(2))
    for mu in (0.0, 50.0):
        check_report(sf.certify_motion(robot, motion, mu=mu, sliding_mu=(0.0, 0.0)))


def test_a_pose_lifted_for_a_while_hangs(g1: sf.Robot) -> None:
    """Steps up and down at its ends are no fall: most of its frames need all of the weight."""
    q = still(g1, 60).q
    q[20:40, 2] += 0.05
    report = sf.certify_motion(g1, Motion(g1, q, RATE))
    (segment,) = report.segments
    assert segment.cause == "hangs"
    assert segment.cure == "lower the root by 5 cm"
