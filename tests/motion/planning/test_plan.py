"""A plan is a log, and SOLVED is a promise."""

from dataclasses import replace

import numpy as np
import pytest

from surefoot import audit_log
from surefoot.base.errors import NoSolution, ProblemError
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import place
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.planning import Plan, PlanSearch, plan_from, rollout
from surefoot.motion.planning import planner as planners
from surefoot.motion.planning.plan import plan_channels
from surefoot.motion.planning.tasks import task_names
from surefoot.records.log import Log

FOUND = PlanSearch("stand", "by hand", cost=1.5, reached=True, iterations=3, seconds=0.25, goal="stands")


@pytest.fixture(scope="module")
def standing(go2):
    q = place(go2)
    return rollout(
        go2, q, np.zeros(18), lambda k, a, v: 60.0 * (q[7:] - a[7:]) - 2.0 * v[6:], dt=0.002, steps=100
    )


def test_a_lawful_motion_that_reaches_its_goal_is_solved(go2, standing):
    plan = plan_from(standing, go2, FOUND)
    assert plan.status is Status.SOLVED
    assert plan.raise_if_failed() is plan
    assert (plan.task, plan.method, plan.cost, plan.iterations, plan.time) == (
        "stand",
        "by hand",
        1.5,
        3,
        0.25,
    )
    assert {phase.foot for phase in plan.contacts} == set(go2.foot_names)


def test_the_audit_finds_a_plan_lawful(go2, standing):
    report = audit_log(plan_from(standing, go2, FOUND), go2)
    assert report.lawful, report.lines()


def test_the_audit_finds_a_landing_in_knots_of_10_ms_lawful(go2):
    """Fast joints change Coriolis forces and velocities in a step: it has one of them, or a mean."""
    q, v = place(go2), np.zeros(18)
    v[7::3], v[8::3] = 3.0, -6.0
    hang = lambda k, a, w: 20.0 * (q[7:] - a[7:]) - 0.5 * w[6:]  # noqa: E731
    landing = rollout(go2, q + 0.15 * np.eye(19)[2], v, hang, dt=0.01, steps=40)
    report = audit_log(plan_from(landing, go2, FOUND), go2)
    assert report.lawful, report.lines()


@pytest.mark.parametrize(
    ("spoil", "status"),
    [
        (lambda t: replace(t, solved=np.r_[t.solved[:-1], False]), Status.STALLED),
        (lambda t: replace(t, residuals=np.r_[t.residuals[:-1], 1e-3]), Status.STALLED),
        (lambda t: replace(t, residuals=np.r_[t.residuals[:-1], np.nan]), Status.STALLED),
        (lambda t: replace(t, q=np.vstack([t.q[:-1], np.full((1, 19), np.nan)])), Status.INVALID),
    ],
)
def test_a_motion_that_is_not_lawful_is_never_solved(go2, standing, spoil, status):
    plan = plan_from(spoil(standing), go2, FOUND)
    assert plan.status is status
    with pytest.raises(NoSolution, match=status.value):
        plan.raise_if_failed()


def test_a_goal_that_is_missed_is_not_solved(go2, standing):
    assert plan_from(standing, go2, replace(FOUND, reached=False)).status is Status.STALLED
    timed = replace(FOUND, reached=False, stopped=Status.MAX_ITERATIONS)
    assert plan_from(standing, go2, timed).status is Status.MAX_ITERATIONS
    claimed = replace(FOUND, reached=False, stopped=Status.SOLVED)
    assert plan_from(standing, go2, claimed).status is Status.STALLED


def test_a_plan_from_a_file_can_be_run_again(go2, standing, tmp_path):
    made = plan_from(standing, go2, FOUND)
    plan = Plan.read(made.save(tmp_path / "plan.npz"))
    assert (plan.status, plan.contacts) == (Status.SOLVED, made.contacts)
    assert plan.fact("goal").startswith("stands; forecast: a replay at a tenth of the step ends ")
    with pytest.raises(ProblemError, match="robot"):
        plan.again()
    motion = plan.again(go2)
    assert motion.law_residual == plan.law_residual
    assert np.array_equal(motion.q[:-1], plan["q"])
    assert np.array_equal(motion.q[-1], plan.fact("end_q"))
    plan.arrays["torques"] = plan["torques"] + 0.5  # a file that was changed
    assert np.abs(plan.again(go2).q[-1] - plan.fact("end_q")).max() > 1e-6


def test_a_log_that_is_no_plan_is_refused(go2, standing, tmp_path):
    plan = plan_from(standing, go2, FOUND)
    del plan.facts["status"]
    with pytest.raises(ProblemError, match="status"):
        Plan.of(plan)


@pytest.mark.usefixtures("wait")
def test_plans_that_call_their_method_road_are_read(go2):
    plan = planners.plan(go2, "wait")
    facts = {"road" if name == "method" else name: fact for name, fact in plan.facts.items()}
    old = Plan.of(Log(plan.arrays, facts, channels=plan.channels))
    assert (old.method, "road" in old.facts) == ("pd", False)


class Wait:
    """Stands still."""

    name, meaning, amount, default, robots, takes = "wait", "stands", "seconds", 0.04, True, ("payload",)

    def plan(self, request, tell):
        q = place(request.robot)
        steps = round(request.amount / (request.dt or 0.002))
        policy = lambda k, a, v: 60.0 * (q[7:] - a[7:]) - 2.0 * v[6:]  # noqa: E731
        motion = rollout(request.robot, q, np.zeros(18), policy, dt=request.dt or 0.002, steps=steps)
        return plan_from(motion, request.robot, replace(FOUND, task="wait", method="pd"))


@pytest.fixture
def wait(monkeypatch):
    monkeypatch.setitem(task_names.TASKS, "wait", "tasks_of_tests:WAIT")
    monkeypatch.setitem(__import__("sys").modules, "tasks_of_tests", type("M", (), {"WAIT": Wait()}))


@pytest.mark.usefixtures("wait")
def test_a_task_from_outside_is_planned(go2):
    plan = planners.plan(go2, "wait")
    assert (len(plan), plan.method) == (20, "pd")
    assert len(planners.plan(go2, "wait", 0.02, dt=0.004, payload=1.0)) == 5


def test_a_row_is_saturated_where_a_torque_meets_its_limit_either_way() -> None:
    torques = np.array([[0.0, 0.0], [9.9, -4.9], [10.0, 0.0], [0.0, -5.0]])
    at_rest = np.zeros((4, 1, 3))
    motion = {"torques": torques, "forces": at_rest, "contact_positions": at_rest}
    found = plan_channels(motion, (0.01, 0.6), FlatTerrain(), np.array([10.0, 5.0]))
    assert found["saturated"].tolist() == [False, False, True, True]
