"""Standing up from the back: found, lawful, and carried out by feedback."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.contact.solution import Status
from surefoot.motion.planning import Plan
from surefoot.motion.planning.stand_up.lying import upright
from surefoot.motion.planning.stand_up.stand_up_task import STAND_UP, StandUp
from surefoot.motion.planning.tasks.task import Iteration, PlanRequest
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.plan_execution import execute

ROBOT = sf.load_robot("go2")


@pytest.fixture(scope="module")
def told() -> list[Iteration]:
    return []


@pytest.fixture(scope="module")
def plan(told: list[Iteration]) -> Plan:
    task = StandUp(model=MujocoWorld(ROBOT, dt=2e-3, collision="full"))
    return task.plan(PlanRequest(ROBOT, 180.0, dt=2e-3), told.append)


@pytest.mark.long
def test_the_plan_gets_up_lawfully(plan: Plan, told: list[Iteration]) -> None:
    assert plan.status is Status.SOLVED
    assert plan.law_residual < 1e-8
    assert upright(plan["q"][0]) < -0.9
    assert upright(np.asarray(plan.facts["end_q"])) > 0.98
    assert told
    assert told[-1].cost == pytest.approx(plan.cost)
    limits = ROBOT.effort_limits
    assert (np.abs(plan["torques"]) <= limits + 1e-9).all()
    low, high = ROBOT.model.lowerPositionLimit[7:], ROBOT.model.upperPositionLimit[7:]
    assert (plan["q"][:, 7:] > low - 0.02).all()
    assert (plan["q"][:, 7:] < high + 0.02).all()


@pytest.mark.long
def test_it_stands_up_where_it_is_not_expected(plan: Plan) -> None:
    done = execute(plan, "mujoco", "curve", seed=3, settle=1.0, dt=1e-3)
    assert done.landed, done.why
    assert done.torque_use_max <= 1.0
    assert done.speed_use_max <= 1.0
    assert any("base_0" in pair for pair in done.links)


def test_who_cannot() -> None:
    with pytest.raises(sf.ProblemError, match="four legs"):
        STAND_UP.plan(PlanRequest(sf.load_robot("g1")), lambda iteration: None)


@pytest.mark.long
def test_a_search_that_was_interrupted_says_so() -> None:
    def stop(iteration: Iteration) -> None:
        raise KeyboardInterrupt

    task = StandUp(model=MujocoWorld(ROBOT, dt=2e-3, collision="full"))
    found = task.plan(PlanRequest(ROBOT, 180.0, dt=2e-3, max_iterations=2), stop)
    assert found.facts["interrupted"] is True
