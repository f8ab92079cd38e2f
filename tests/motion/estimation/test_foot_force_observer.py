"""Forces from torques and kinematics, against those of the worlds that made the motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.foot_force_observer import FootForceObserver
from tests.pages import run_page
from tests.records.audit.logs import STAND, log_of
from tests.records.identification.hopper import write_hopper

UP = np.tile([0.0, 0.0, 1.0], (4, 1))


def test_standing_forces_are_the_worlds() -> None:
    log, robot = log_of(STAND), sf.load_robot("go2")
    observer = FootForceObserver(robot, log.fact("dt"), least=0.1 * robot.mass * GRAVITY)
    for q, v, tau in zip(log["q"], log["v"], log["torques"], strict=True):
        pushed = observer.observe(q, v, UP)
        observer.applied(tau)
    assert pushed.all()
    np.testing.assert_allclose(observer.forces, log["forces"][-1], atol=0.02 * robot.mass * GRAVITY)


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_known_forces_are_seen_whatever_the_motion(name: str) -> None:
    """A free motion under known wrenches at the feet, integrated finely with Pinocchio alone."""
    robot, dt, random = sf.load_robot(name), 1e-4, np.random.default_rng(1)
    model, data = robot.model, robot.model.createData()
    q, v = robot.nominal.copy(), 0.1 * random.normal(size=robot.model.nv)
    tau = 0.05 * robot.mass * random.normal(size=robot.joints)
    forces = robot.mass * random.normal(size=(len(robot.feet), 3))
    observer = FootForceObserver(robot, dt, 1000.0)
    up = np.array([0.0, 0.0, 1.0])
    for _ in range(150):
        observer.observe(q, v, np.tile(up, (len(robot.feet), 1)))
        observer.applied(tau)
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)
        pushed = np.r_[np.zeros(6), tau]
        for foot, force in zip(robot.feet, forces, strict=True):
            J = pinocchio.getFrameJacobian(model, data, foot.frame, pinocchio.LOCAL_WORLD_ALIGNED)
            arm = data.oMf[foot.frame].rotation @ foot.centre - foot.radius * up
            pushed += J.T @ np.r_[force, np.cross(arm, force)]
        v = v + dt * pinocchio.aba(model, data, q, v, pushed)
        q = pinocchio.integrate(model, q, dt * v)
    np.testing.assert_allclose(observer.forces, forces, atol=0.05 * np.abs(forces).max())


def test_wrong_input_is_named() -> None:
    with pytest.raises(ProblemError, match="tau"):
        FootForceObserver(sf.load_robot("go2"), 0.001).applied(np.full(12, np.nan))
    with pytest.raises(ProblemError, match="bandwidth"):
        FootForceObserver(sf.load_robot("go2"), 0.001, 0.0)
    with pytest.raises(ProblemError, match="floating base"):
        FootForceObserver(sf.load_robot("go2", fixed_base=True), 0.001)


@pytest.mark.long
def test_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(write_hopper(tmp_path))
    names = run_page("leg-forces.md")
    assert names["foot"].forces.shape == (len(names["foot"].time), 3)
    names = run_page("estimation.md")
    assert names["tracker"].believed(0.6).shape == (4,)
    assert names["used"].all()
    robot = names["robot"]
    np.testing.assert_allclose(names["q_estimated"], robot.nominal, atol=0.01)
    assert np.abs(names["v_estimated"]).max() < 0.01
    assert names["ekf"].filter.covariance.shape == (27, 27)
