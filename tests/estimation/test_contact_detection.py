"""Contacts from torques and kinematics, against the forces of the worlds that made the motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from benchmarks.detection_errors import detection_errors
from surefoot.audit.motion import touching
from surefoot.errors import ProblemError
from surefoot.estimation.contact_detection import DetectionSettings
from surefoot.spatial import GRAVITY
from tests.audit.logs import SLOPE, STAND, TROT, changed, log_of
from tests.estimation.hopper import write_hopper
from tests.pages import run_page


@pytest.mark.parametrize("run", [TROT, SLOPE], ids=lambda run: run.world)
def test_a_trots_contacts_are_found_within_milliseconds(run: object) -> None:
    log = log_of(run)  # type: ignore[arg-type]
    told = sf.detect_contacts(sf.load_robot("go2"), log)
    errors = detection_errors(told, touching(log), log.fact("dt"))
    assert errors.contacts >= 8
    assert errors.missed == 0
    assert errors.false <= 1  # a foot brushes the ground for 4 ms, which is found and counts as no contact
    delays = np.abs(errors.touchdown_delays)  # a foot lands gently, and is loaded along a ramp
    assert np.median(delays) <= 0.006
    assert delays.max() <= 0.020
    assert np.abs(errors.lift_off_delays).max() <= 0.020
    assert errors.wrong_share < 0.05


def test_noise_invents_no_contact() -> None:
    log, random = log_of(TROT), np.random.default_rng(0)
    v = log["v"] + np.r_[np.full(6, 0.02), np.full(12, 0.05)] * random.normal(size=log["v"].shape)
    tau = log["torques"] + 0.3 * random.normal(size=log["torques"].shape)
    told = sf.detect_contacts(sf.load_robot("go2"), changed(log, v=v, torques=tau))
    errors = detection_errors(told, touching(log), log.fact("dt"))
    quiet = detection_errors(sf.detect_contacts(sf.load_robot("go2"), log), touching(log), log.fact("dt"))
    assert (errors.missed, errors.false) == (0, quiet.false)


def test_standing_forces_are_the_worlds() -> None:
    log, robot = log_of(STAND), sf.load_robot("go2")
    detector = sf.ContactDetector(robot, log.fact("dt"))
    for row in zip(log["q"], log["v"], log["torques"], strict=True):
        found = detector.update(*row)
    assert found.contact.all()
    np.testing.assert_allclose(found.forces, log["forces"][-1], atol=0.02 * robot.mass * GRAVITY)


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_known_forces_are_seen_whatever_the_motion(name: str) -> None:
    """A free motion under known wrenches at the feet, integrated finely with Pinocchio alone."""
    robot, dt, random = sf.load_robot(name), 1e-4, np.random.default_rng(1)
    model, data = robot.model, robot.model.createData()
    q, v = robot.nominal.copy(), 0.1 * random.normal(size=robot.model.nv)
    tau = 0.05 * robot.mass * random.normal(size=robot.joints)
    forces = robot.mass * random.normal(size=(len(robot.feet), 3))
    detector = sf.ContactDetector(robot, dt, DetectionSettings(bandwidth=1000.0))
    up = np.array([0.0, 0.0, 1.0])
    for _ in range(150):
        found = detector.update(q, v, tau)
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        pushed = np.r_[np.zeros(6), tau]
        for foot, force in zip(robot.feet, forces, strict=True):
            J = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
            arm = data.oMf[foot.frame].rotation @ foot.centre - foot.radius * up
            pushed += J.T @ np.r_[force, np.cross(arm, force)]
        v = v + dt * pinocchio.aba(model, data, q, v, pushed)
        q = pinocchio.integrate(model, q, dt * v)
    np.testing.assert_allclose(found.forces, forces, atol=0.05 * np.abs(forces).max())


def test_events_are_counted() -> None:
    truth, told = np.zeros((100, 2), dtype=bool), np.zeros((100, 2), dtype=bool)
    truth[20:50, 0] = truth[70:, 0] = truth[30:60, 1] = True
    told[23:58, 0] = told[5:8, 1] = True  # late, one missed; one missed, one false
    errors = detection_errors(told, truth, 0.01)
    np.testing.assert_allclose(errors.touchdown_delays, [0.03])
    np.testing.assert_allclose(errors.lift_off_delays, [0.08])
    assert (errors.missed, errors.false, errors.contacts) == (2, 1, 3)
    assert errors.wrong_share == pytest.approx((3 + 8 + 30 + 30 + 3) / 200)


def test_wrong_input_is_named() -> None:
    robot = sf.load_robot("go2")
    detector = sf.ContactDetector(robot, 0.001)
    with pytest.raises(ProblemError, match="v must have shape"):
        detector.update(robot.nominal, np.zeros(17), np.zeros(12))
    with pytest.raises(ProblemError, match="tau"):
        detector.update(robot.nominal, np.zeros(18), np.full(12, np.nan))
    with pytest.raises(ProblemError, match="normals must have length 1"):
        detector.update(robot.nominal, np.zeros(18), np.zeros(12), np.zeros((4, 3)))
    with pytest.raises(ProblemError, match="lift_off must not exceed touchdown"):
        DetectionSettings(touchdown=0.1, lift_off=0.2)
    with pytest.raises(ProblemError, match="floating base"):
        sf.ContactDetector(sf.load_robot("go2", fixed_base=True), 0.001)
    with pytest.raises(ProblemError, match="no torques"):
        sf.detect_contacts(robot, changed(log_of(STAND), keep=("q", "v")))
    with pytest.raises(ProblemError, match="of one shape"):
        detection_errors(np.zeros((3, 2), dtype=bool), np.zeros((4, 2), dtype=bool), 0.1)


def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(write_hopper(tmp_path))
    names = run_page("estimation.md")
    assert not names["found"].contact.any()  # limp and free: it falls
    np.testing.assert_allclose(names["found"].forces, 0.0, atol=200.0)
    assert names["tracker"].believed(0.6).shape == (4,)
    assert names["used"].all()
    assert names["foot"].forces.shape == (len(names["foot"].time), 3)
    robot = names["robot"]
    np.testing.assert_allclose(names["q_estimated"], robot.nominal, atol=0.01)
    assert np.abs(names["v_estimated"]).max() < 0.01
    assert names["ekf"].filter.covariance.shape == (27, 27)
