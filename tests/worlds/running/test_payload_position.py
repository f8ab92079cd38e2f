"""Where a payload is: the same in every world, in the log, its audit and its replay."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import Robot, place
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld, import_mujoco
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import START_DEPTH, Scenario
from tests.robots import robot_of

MASS, PLACE = 4.0, (0.1, -0.08, 0.06)


def true_model(robot: Robot) -> pinocchio.Model:
    model = robot.model.copy()
    ball = pinocchio.Inertia(MASS, np.array(PLACE), 1e-3 * MASS * np.eye(3))
    model.inertias[1] = model.inertias[1] + ball
    return model


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_the_mass_matrix_is_that_of_the_loaded_robot(name: str) -> None:
    robot, mujoco = robot_of(name), import_mujoco()
    true = true_model(robot)
    wanted = np.array(pinocchio.crba(true, true.createData(), robot.nominal))
    rigid = RigidWorld(robot, payload=MASS, payload_position=PLACE)
    assert np.allclose(pinocchio.crba(rigid.model, rigid.model.createData(), robot.nominal), wanted)
    world = MujocoWorld(robot, payload=MASS, payload_position=PLACE)
    world.reset(robot.nominal)
    full = np.zeros((world.model.nv, world.model.nv))
    mujoco.mj_fullM(world.model, world.data, full)
    R = pinocchio.Quaternion(robot.nominal[3:7]).matrix()
    turn = np.eye(world.model.nv)
    turn[:3, :3] = R  # MuJoCo's base moves along world axes
    assert np.allclose(turn.T @ full @ turn, wanted, rtol=0, atol=1e-9)


def stand(world: MujocoWorld | RigidWorld, duration: float = 0.3) -> sf.Log:
    robot, ground = robot_of("go2"), FlatTerrain()
    q = place(robot, ground)
    controller = StandingController(robot, StandingPlan(robot, ground, q, []), ground, q)
    return run(world, controller, Scenario(duration, 0.6, start=q, depth=START_DEPTH))


@pytest.mark.parametrize("kind", [MujocoWorld, RigidWorld])
def test_the_log_tells_where_it_is_and_the_audit_believes_it(kind: type) -> None:
    log = stand(kind(robot_of("go2"), payload=MASS, payload_position=PLACE))
    assert log.fact("payload_position") == pytest.approx(PLACE)
    assert not [v for v in sf.audit_log(log).violations if v.law == "motion"]
    elsewhere = sf.Log(log.arrays, {**log.facts, "payload_position": [-0.3, 0.3, 0.0]}, channels=log.channels)
    assert [v for v in sf.audit_log(elsewhere).violations if v.law == "motion"]


def test_a_world_without_a_payload_tells_no_place() -> None:
    assert "payload_position" not in stand(MujocoWorld(robot_of("go2")), 0.05).facts


def test_it_is_replayed_where_it_was() -> None:
    log = stand(MujocoWorld(robot_of("go2"), payload=MASS, payload_position=PLACE))
    moved = sf.Log(log.arrays, {**log.facts, "payload_position": [-0.3, 0.3, 0.0]}, channels=log.channels)
    same, other = (max(w.drift for w in sf.replay_log(one, "mujoco").windows) for one in (log, moved))
    assert same < 1e-3
    assert other > 10.0 * same


@pytest.mark.parametrize("kind", [MujocoWorld, RigidWorld])
@pytest.mark.parametrize("wrong", [(0.0, 0.0), (np.nan, 0.0, 0.0), "here"])
def test_a_place_that_is_none_is_refused(kind: type, wrong: object) -> None:
    with pytest.raises(ProblemError, match="payload_position"):
        kind(robot_of("go2"), payload=MASS, payload_position=wrong)
