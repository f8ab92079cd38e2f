"""The shooting solver on a pendulum, a hopper and Go2, and what it says of goals that cannot be reached."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from surefoot.base.errors import ModelError, ProblemError
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import Robot, load_robot, place
from surefoot.motion.planning import rollout
from surefoot.motion.planning.shooting import (
    Costs,
    FootCost,
    Goal,
    Shooting,
    ShootingProblem,
    ShootingSettings,
    StateCost,
    TorqueCost,
)
from surefoot.motion.planning.shooting.horizon import Horizon
from surefoot.motion.planning.shooting.initial_torques import holding_torques
from tests.robots import go2

LINK = """<link name="{0}"><inertial><origin xyz="{1}"/><mass value="{2}"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="{1}"/><geometry><sphere radius="0.02"/></geometry></collision></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="{4}"/>
<limit effort="{5}" velocity="50" lower="-50" upper="50"/></joint>"""


def robot_of(folder: Path, *parts: str, feet: list[str], fixed: bool) -> Robot:
    path = folder / "robot.urdf"
    path.write_text('<robot name="small">' + "".join(parts) + "</robot>")
    return load_robot(path, feet=feet, fixed_base=fixed)


def pendulum(folder: Path, effort: float) -> Robot:
    """A pendulum of two links."""
    parts = [
        LINK.format("base", "0 0 0", 1),
        LINK.format("arm", "0 0 -0.5", 1),
        LINK.format("tip", "0 0 -0.1", 0.2),
    ]
    hinges = [
        JOINT.format("hinge", "revolute", "base", "arm", "0 1 0", effort),
        JOINT.format("wrist", "revolute", "arm", "tip", "0 1 0", effort),
    ]
    return robot_of(folder, *parts, *hinges, feet=[], fixed=True)


def test_near_its_rest_a_pendulum_gets_the_gains_of_the_discrete_riccati_equation(tmp_path: Path) -> None:
    """A and B by finite differences of exact steps, the gains from SciPy."""
    robot = pendulum(tmp_path, effort=100.0)
    weights, R, dt, h = np.array([3.0, 1.0, 0.2, 0.1]), 0.5, 0.05, 1e-5

    def step(x: np.ndarray) -> np.ndarray:
        end = rollout(robot, x[:2], x[2:4], x[None, 4:], dt=dt)
        return np.r_[end.q[1], end.v[1]]

    J = np.array([(step(h * e) - step(-h * e)) / (2.0 * h) for e in np.eye(6)]).T
    A, B = J[:, :4], J[:, 4:]
    P = scipy.linalg.solve_discrete_are(A, B, np.diag(weights), R * np.eye(2))
    K = -np.linalg.solve(R * np.eye(2) + B.T @ P @ B, B.T @ P @ A)
    costs = Costs(StateCost(weights, q=np.zeros(2)), TorqueCost(R))
    x = np.array([1e-4, -2e-4])
    solver, settings = (
        Shooting(ShootingProblem(robot, costs, knots=150, dt=dt)),
        ShootingSettings(damping=0.0),
    )
    found = solver.solve(x, np.zeros(2), settings=settings)
    np.testing.assert_allclose(found.gains[0], K, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(found.trajectory.torques[0], K[:, :2] @ x, rtol=1e-3)


@pytest.mark.long
def test_a_pendulum_swings_up_with_less_torque_than_holds_it(tmp_path: Path) -> None:
    robot = pendulum(tmp_path, effort=2.5)  # holding it level takes 6 N m
    top = np.array([np.pi, 0.0])
    costs = Costs(StateCost(0.01, terminal=[200.0, 100.0, 20.0, 10.0], q=top), TorqueCost(0.01))
    goal = Goal(
        lambda t: float(max(np.abs(t.q[-1] - top).max() / 0.1, np.abs(t.v[-1]).max() / 0.5)), tolerance=1.0
    )
    solver = Shooting(ShootingProblem(robot, costs, knots=120, dt=0.03, goal=goal))
    start = 0.1 * np.random.default_rng(0).normal(size=(120, 2))
    found = solver.solve(np.zeros(2), np.zeros(2), start, settings=ShootingSettings(max_iterations=300))
    assert found.status is Status.SOLVED
    assert found.distance <= 1.0
    assert np.abs(found.trajectory.torques).max() <= 2.5 + 1e-12
    assert np.abs(found.trajectory.torques).max() > 2.4
    again = rollout(robot, np.zeros(2), np.zeros(2), found.trajectory.torques, dt=0.03)
    assert (again.q == found.trajectory.q).all()


def hopper(folder: Path) -> Robot:
    parts = [
        LINK.format("base", "0 0 0", 0.001),
        LINK.format("body", "0 0 1.0", 3),
        LINK.format("leg", "0 0 0.5", 0.3),
    ]
    rail = JOINT.format("rail", "prismatic", "base", "body", "0 0 1", 0.001)
    leg = JOINT.format("leg_joint", "prismatic", "body", "leg", "0 0 1", 200)
    return robot_of(folder, *parts, rail, leg, feet=["leg"], fixed=True)


def test_a_hopper_leaves_the_ground_to_reach_a_height(tmp_path: Path) -> None:
    robot = hopper(tmp_path)
    dt, N = 0.02, 30
    start = np.array([-0.48, 0.0])  # the foot's sphere on the ground
    limits = np.array([1e-9, 200.0])
    costs = Costs(
        StateCost([0.0, 1.0, 0.0, 0.1], terminal=[500.0, 50.0, 0.0, 1.0], q=[-0.18, 0.0]), TorqueCost(1e-4)
    )
    goal = Goal(lambda t: abs(float(t.q[-1, 0]) + 0.18), 0.03)
    problem = ShootingProblem(robot, costs, knots=N, dt=dt, limits=limits, goal=goal)
    found = Shooting(problem).solve(start, np.zeros(2), np.tile([0.0, -29.4], (N, 1)))
    assert found.status is Status.SOLVED
    assert found.law_residual <= 1e-8
    forces = found.trajectory.impulses[:, 0, 2] / dt
    assert forces[:3].min() > 0.0
    assert forces[-1] == 0.0
    assert found.trajectory.gaps[-1, 0] > 0.05


def squat(**settings: object) -> ShootingProblem:
    robot = go2()
    q = place(robot)
    q[2] -= 0.05
    weights = np.r_[np.full(6, 100.0), np.full(12, 0.1), np.full(6, 1.0), np.full(12, 0.02)]
    costs = Costs(StateCost(weights, 10.0 * weights, q), TorqueCost(1e-3), FootCost(slip=1.0))
    goal = Goal(lambda t: float(np.abs(t.q[-1, :3] - q[:3]).max()), 0.02)
    return ShootingProblem(robot, costs, knots=16, dt=0.025, goal=goal, **settings)  # type: ignore[arg-type]


@pytest.mark.long
def test_go2_squats_on_its_feet() -> None:
    problem = squat()
    solver, q = Shooting(problem), place(go2())
    guess = np.tile(holding_torques(go2(), q), (16, 1))
    found = solver.solve(q, np.zeros(18), guess)
    assert found.status is Status.SOLVED
    assert found.law_residual <= 1e-8
    assert list(found.costs) == sorted(found.costs, reverse=True)
    assert np.abs(found.trajectory.torques).max() <= go2().effort_limits.max()
    assert found.trajectory.gaps[1:].min() > -1e-9
    again = solver.solve(q, np.zeros(18), guess)
    assert again.costs == found.costs  # nothing is left over from the first


def test_a_goal_that_cannot_be_reached_is_not_called_solved() -> None:
    robot, q = go2(), place(go2())
    high = q.copy()
    high[2] += 2.0
    costs = Costs(StateCost(np.r_[np.full(6, 10.0), np.full(30, 0.1)], q=high), TorqueCost(1e-3))
    problem = ShootingProblem(robot, costs, 8, goal=Goal(lambda t: float(high[2] - t.q[-1, 2]), 0.02))
    found = Shooting(problem).solve(q, np.zeros(18), settings=ShootingSettings(max_iterations=20))
    assert found.status in (Status.STALLED, Status.MAX_ITERATIONS)
    assert found.distance > 1.0
    assert found.trajectory.lawful


def test_torques_stay_within_limits_that_are_given() -> None:
    limits = 0.2 * go2().effort_limits
    weak = squat(limits=limits)
    found = Shooting(weak).solve(place(go2()), np.zeros(18), settings=ShootingSettings(max_iterations=5))
    assert (np.abs(found.trajectory.torques) <= limits + 1e-12).all()
    with pytest.raises(ProblemError, match="limits"):
        squat(limits=np.ones(3))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"q": np.zeros(3)}, "q"),
        ({"v": np.full(18, np.inf)}, "v"),
        ({"torques": np.zeros((3, 12))}, "torques"),
    ],
)
def test_bad_input_is_named(change: dict[str, object], word: str) -> None:
    given = {"q": place(go2()), "v": np.zeros(18), **change}
    with pytest.raises(ProblemError, match=word):
        Shooting(squat()).solve(**given)  # type: ignore[arg-type]


def test_robots_that_no_torque_can_steer_are_refused(tmp_path: Path) -> None:
    """A free body has no torques, and one hinge one velocity; a body with one leg is enough."""
    body, leg = LINK.format("body", "0 0 0", 3), LINK.format("leg", "0 0 -0.3", 0.3)
    knee = JOINT.format("knee", "prismatic", "body", "leg", "0 0 1", 200)
    for parts, fixed, enough in (
        ((body,), False, False), ((body, leg, knee), True, False), ((body, leg, knee), False, True),
    ):  # fmt: skip
        feet = ["leg"] if len(parts) > 1 else []
        robot = robot_of(tmp_path, *parts, feet=feet, fixed=fixed)
        told = contextlib.nullcontext() if enough else pytest.raises(ModelError, match="two velocities")
        with told:
            assert len(Horizon(robot, 2, 0.01, 0.5, None)) == 2


@pytest.mark.parametrize("change", [{"knots": 0}, {"dt": -1.0}, {"mu": np.nan}])
def test_bad_problems_are_named(change: dict[str, float]) -> None:
    given = {"knots": 5, "dt": 0.02, "mu": 0.5, **change}
    with pytest.raises(ProblemError, match=next(iter(change))):
        ShootingProblem(go2(), Costs(StateCost(1.0)), **given)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="smoothings"):
        ShootingSettings(smoothings=())
