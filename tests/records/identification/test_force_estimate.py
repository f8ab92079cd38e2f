"""Forces from a motion and its torques, against those of the world that made it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log
from tests.records.audit.logs import SLOPE, STAND, TROT, log_of
from tests.records.identification.hopper import URDF

GO2 = "go2"


def _at(log: Log, row: int) -> tuple[sf.Robot, list[np.ndarray], list[str]]:
    robot = sf.load_robot(GO2)
    a = (log["v"][row + 1] - log["v"][row]) / log.fact("dt")
    on = log["forces"][row, :, 2] > 0.01 * robot.mass * GRAVITY
    feet = [name for name, one in zip(robot.foot_names, on, strict=True) if one]
    return robot, [log["q"][row], log["v"][row], a, log["torques"][row]], feet


@pytest.mark.parametrize("row", [100, 450, 800, 1000])
@pytest.mark.parametrize("run", [TROT, SLOPE], ids=lambda run: run.world)
def test_the_forces_are_those_of_the_world(run: object, row: int) -> None:
    log = log_of(run)  # type: ignore[arg-type]
    robot, state, feet = _at(log, row)
    terrain = sf.SlopeTerrain(10.0) if run is SLOPE else None
    found = sf.estimate_forces(robot, *state, feet=feet, terrain=terrain)
    true = log["forces"][row][[robot.foot_names.index(name) for name in feet]]
    np.testing.assert_allclose(found.forces, true, atol=1e-3 * robot.mass * GRAVITY)
    assert (found.lawful, found.explainable) == (True, "yes")
    assert found.misfit < 0.1
    assert (found.std < 5.0).all()
    assert set(found.by_contact()) == set(feet)


def test_a_motion_that_no_friction_gives_is_disproved() -> None:
    robot, state, _ = _at(log_of(STAND), 300)
    state[2] = state[2] + np.r_[4.0, np.zeros(17)]  # 4 m/s² forward on mu 0.3
    found = sf.estimate_forces(robot, *state, mu=0.3)
    assert found.explainable == "no"
    assert found.verdict.verify()
    assert found.misfit > 5.0
    assert sf.estimate_forces(robot, *state, mu=0.6).explainable == "yes"
    state[2][0] += 6.0  # 10 m/s² tip it over its hind feet, whatever its torques are
    assert sf.estimate_forces(robot, *state, mu=5.0, torque_std=100.0).explainable == "no"


def test_what_lies_within_the_noise_is_not_disproved() -> None:
    robot, state, _ = _at(log_of(STAND), 300)
    state[2] = state[2] + np.r_[6.0, np.zeros(17)]  # 0.6 g would be 5.886
    assert sf.estimate_forces(robot, *state, acceleration_std=0.5).explainable != "no"


def test_pressure_beyond_the_soles_is_disproved() -> None:
    robot = sf.load_robot("g1")
    still = np.zeros(robot.model.nv)  # of 4 m/s² forward: 0.25 m ahead of the ankles, within the friction
    found = sf.estimate_forces(robot, None, still, np.r_[4.0, still[1:]], np.full(robot.joints, np.nan))
    assert (found.lawful, found.explainable) == (False, "no")


def test_uncertainty_follows_the_torques() -> None:
    robot, state, _ = _at(log_of(STAND), 300)
    rough = sf.estimate_forces(robot, *state, torque_std=2.0, acceleration_std=0.0)
    fine = sf.estimate_forces(robot, *state, torque_std=0.2, acceleration_std=0.0)
    assert rough.std == pytest.approx(10.0 * fine.std, rel=1e-3)
    rng, spread = np.random.default_rng(0), []
    for _ in range(200):
        noisy = [*state[:3], state[3] + rng.normal(scale=0.2, size=12)]
        spread.append(sf.estimate_forces(robot, *noisy, torque_std=0.2, acceleration_std=0.0).stacked)
    assert np.std(spread, axis=0) == pytest.approx(fine.std, rel=0.25)


def test_wrong_input_is_one_line() -> None:
    robot, state, _ = _at(log_of(STAND), 300)
    for tau in (np.zeros(3), ["a"] * 12):
        with pytest.raises(ProblemError, match="tau"):
            sf.estimate_forces(robot, *state[:3], tau)
    with pytest.raises(ProblemError, match="torque_std"):
        sf.estimate_forces(robot, *state, torque_std=0.0)
    with pytest.raises(ProblemError, match="bolted"):
        sf.estimate_forces(sf.load_robot("panda"), np.zeros(9), np.zeros(9), np.zeros(9), np.zeros(9))


def test_a_base_on_a_rail_that_a_hand_holds(tmp_path: Path) -> None:
    (tmp_path / "leg.urdf").write_text(URDF, "utf-8")
    robot = sf.load_robot(tmp_path / "leg.urdf", feet="foot", fixed_base=True)
    q, still = np.array([0.25, 0.6, -1.2]), np.zeros(3)
    found = sf.estimate_forces(
        robot, q, still, still, [np.nan, 0.1, 0.9], torque_std=0.05, acceleration_std=0.0
    )
    lever = 0.16 * np.sin([0.6, -0.6])  # statics by hand: knee and hip, the foot below
    drop = 0.16 * np.cos([0.6, -0.6])
    weights = 9.81 * np.array(
        [0.15 * 0.5 * lever[0] + 0.03 * (lever[0] + 0.5625 * lever[1]), 0.03 * 0.5625 * lever[1]]
    )
    drop[1] += robot.feet[0].radius
    A = np.array([[drop.sum(), -lever.sum()], [drop[1], -lever[1]]])
    sideways, up = np.linalg.solve(A, np.array([0.1, 0.9]) - weights)
    assert found.stacked[[0, 2]] == pytest.approx([sideways, up], abs=1e-6)
    assert found.std[2] > 0.3  # 0.05 N m over a lever of 0.09 m
    assert found.verdict is None
    held = sf.estimate_forces(robot, q, still, still, [0.0, 0.1, 0.9], torque_std=0.05)
    assert held.misfit > 3.0  # a rail without a hand: the weight does not fit
