"""A robot on its trunk: its log has the trunk's forces, and the audit accounts for the motion."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.audit.rows import Rows
from surefoot.audit.setting import setting_of
from surefoot.simulation.rigid import RigidWorld
from surefoot.simulation.scenario import Fall
from surefoot.spatial import GRAVITY, rotation_from_quaternion
from surefoot.terrain.terrain import Terrain
from tests.audit.logs import changed

ROBOT = sf.load_robot("go2")
WEIGHT = ROBOT.mass * GRAVITY


class Hold(sf.Controller):
    """Springs at the joints."""

    channels = ()

    def step(self, state: sf.RobotState) -> sf.Command:
        torques = np.clip(60.0 * (ROBOT.nominal[7:] - state.q[7:]) - 2.0 * state.v[6:], -23.0, 23.0)
        return sf.Command(torques, np.zeros((4, 3)), np.ones(4, dtype=bool), True, sf.Status.SOLVED)


class Lying(Fall):
    """Whatever the robot does, the run goes on."""

    def happened(self, q: np.ndarray, height: float, terrain: Terrain) -> None:
        return None


def fallen(q: np.ndarray, collision: str = "full", seconds: float = 0.8) -> sf.Log:
    world = RigidWorld(ROBOT, collision=collision)
    scenario = sf.Scenario(seconds, 0.6, start=q, fall=Lying())
    return sf.run(world, Hold(), scenario)


@pytest.fixture(scope="module")
def on_its_back() -> sf.Log:
    q = ROBOT.nominal.copy()
    q[2], q[3:7] = 0.2, [1.0, 0.0, 0.0, 0.0]
    return fallen(q)


def unexplained(log: sf.Log) -> np.ndarray:
    """Return the force that the log leaves unexplained, over the weight: (T, 3)."""
    rest = Rows(log, setting_of(log, None), 0, len(log)).unexplained
    assert rest is not None
    return rest.force / WEIGHT


def test_the_trunk_carries_the_weight(on_its_back: sf.Log) -> None:
    log = on_its_back
    assert log.channels["other_forces"].shape == (18,)
    assert not np.asarray(log["forces"])[-200:].any()
    R = rotation_from_quaternion(np.asarray(log["q"])[-200:, 3:7])
    force = np.einsum("tij,tj->ti", R, np.asarray(log["other_forces"])[-200:, :3])
    assert np.abs(force.mean(axis=0) - [0.0, 0.0, WEIGHT]).max() < 0.02 * WEIGHT


def test_the_motion_is_explained_through_the_impact_and_after(on_its_back: sf.Log) -> None:
    """Newton-Euler of the audit, which knows nothing of the world's contact problem."""
    rest = unexplained(on_its_back)
    assert np.nanmax(np.linalg.norm(rest[-200:], axis=1)) < 1e-3
    # through impacts too momentum is accounted for, over rows
    assert np.linalg.norm(np.nansum(rest, axis=0)) < 1e-2 * np.linalg.norm(
        np.nansum(unexplained(without(on_its_back)), axis=0)
    )
    report = sf.audit_log(on_its_back)
    assert report.verdict == "lawful", report.violations
    assert report.symptoms == ()


def without(log: sf.Log) -> sf.Log:
    """Return a log that has the feet's forces alone."""
    kept = tuple(name for name in log.arrays if name != "other_forces")
    return changed(log, keep=kept)


def test_without_the_channel_the_audit_misses_the_weight(on_its_back: sf.Log) -> None:
    rest = unexplained(without(on_its_back))
    assert np.nanmean(rest[-200:, 2]) == pytest.approx(1.0, abs=0.02)
    assert sf.audit_log(without(on_its_back)).verdict != "lawful"


def test_a_wrong_force_of_the_trunk_is_told(on_its_back: sf.Log) -> None:
    wrong = changed(on_its_back, other_forces=0.7 * np.asarray(on_its_back["other_forces"]))
    assert sf.audit_log(wrong).verdict != "lawful"
    lost = np.array(on_its_back["other_forces"])
    lost[300:320] = np.nan
    assert sf.audit_log(changed(on_its_back, other_forces=lost)).verdict != "broken"


def test_forces_within_the_robot_leave_its_base_alone() -> None:
    """Legs that press each other in the air: opposite forces, nothing on the whole."""
    world = RigidWorld(ROBOT, collision="full")
    q, goal = ROBOT.nominal.copy(), ROBOT.nominal[7:].copy()
    q[2] = 2.0
    goal[[0, 3]] = [-0.9, 0.9]  # the front legs inwards
    world.reset(q)
    pressed = 0.0
    for _ in range(400):
        q, v = world.state()
        world.step(np.clip(60.0 * (goal - q[7:]) - 2.0 * v[6:], -23.0, 23.0))
        others = world.contacts().others
        assert others is not None
        pressed = max(pressed, np.abs(others[6:]).max())
        assert np.abs(others[:6]).max() < 1e-9 * max(1.0, np.abs(others).max())
    assert pressed > 1.0


def test_a_world_of_feet_alone_has_no_such_channel() -> None:
    assert RigidWorld(ROBOT).contacts().others is None
    log = fallen(ROBOT.nominal.copy(), "feet", 0.01)
    assert "other_forces" not in log
