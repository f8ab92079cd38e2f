"""Every controller on hard input: a state in, torques and forces out."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from surefoot.contact.solution import Status
from surefoot.mechanics.robot import Robot, place
from surefoot.mechanics.robot.actuators import real_actuators
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.body_motion import BodyReference, BodyState
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.control.whole_body import Tasks, WholeBodyController
from surefoot.motion.drive.joint_targets import JointTargetController
from surefoot.motion.drive.latency_compensation import LatencyCompensation
from surefoot.motion.drive.watchdog import Watchdog
from surefoot.motion.planning.mpc.contact_implicit_controller import ContactImplicitMpc, MpcSettings
from surefoot.motion.standing.standing_controller import StandingController
from surefoot.motion.standing.standing_plan import Lift, StandingPlan
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from tests.conformance.hard_inputs import (
    EXTREME,
    FEET,
    HIGH,
    MU,
    NOT_FINITE,
    check_forces,
)
from tests.robots import robot_of


class Standing:
    """Torques, forces, whether all is well and the status, of one controller at one state."""

    def __init__(self, robot: Robot, mu: float = MU, lifted: bool = False) -> None:
        q, terrain = place(robot), FlatTerrain()
        lifts = [Lift(robot.foot_names[0], 1.0, 2.0)] if lifted else []
        plan = StandingPlan(robot, terrain, q, lifts)
        self.controller = StandingController(robot, plan, terrain, q, mu)
        self.time = 1.5 if lifted else 0.0

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, Status]:
        c = self.controller.step(RobotState(q, v, self.time))
        for array in (c.wrench_desired, c.wrench_error, c.grasp_map):
            assert np.isfinite(array).all()
        return c.torques, c.forces, c.attained, c.status


class Lifting(Standing):
    def __init__(self, robot: Robot, mu: float = MU) -> None:
        super().__init__(robot, mu, lifted=True)


class Walking:
    def __init__(self, robot: Robot, mu: float = MU) -> None:
        self.controller = WalkingController(robot, VelocityCommand.constant(0.3))
        self.time = 0.0

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, Status]:
        self.time += 1e-3
        c = self.controller.step(RobotState(q, v, self.time, np.ones(4, dtype=bool)))
        return c.torques, c.forces, c.attained, c.status


class Wired(Walking):
    """The walking controller with motors, a delay that it makes up for, joint targets and a watchdog."""

    def __init__(self, robot: Robot, mu: float = MU) -> None:
        settings = WalkSettings(mu=mu, actuators=real_actuators(robot))
        walking = WalkingController(robot, VelocityCommand.constant(0.3), settings=settings)
        targets = JointTargetController(walking, robot, 1e-3)
        self.controller = Watchdog(LatencyCompensation(targets, robot, 1e-3, 0.003), robot, 1e-3)
        self.time = 0.0

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, Status]:
        self.time += 1e-3
        c = self.controller.step(RobotState(q, v, self.time, np.ones(4, dtype=bool), np.full(12, np.nan)))
        if c.joint_targets is not None:
            assert all(np.isfinite(part).all() for part in c.joint_targets)
        return c.torques, c.forces, c.attained, c.status


class ContactImplicit:
    """Plans anew at every step."""

    def __init__(self, robot: Robot, mu: float = MU) -> None:
        settings = MpcSettings(knots=4, first_iterations=2, mu=mu)
        self.controller = ContactImplicitMpc(robot, VelocityCommand.constant(0.3), settings=settings)
        self.time = 0.0

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, Status]:
        self.time += 0.02
        c = self.controller.step(RobotState(q, v, self.time))
        return c.torques, c.forces, c.attained, c.status


class WholeBody:
    def __init__(self, robot: Robot, mu: float = MU, effort: float = 1.0, normal_min: float = 0.0) -> None:
        self.controller = WholeBodyController(
            robot, mu, normal_min, 500.0, effort_limits=effort * robot.effort_limits
        )
        n, p = len(robot.feet), sum(len(f.centres) for f in robot.feet)
        share = robot.mass * 9.81 / p
        self.tasks = Tasks(
            np.ones(n, dtype=bool), np.zeros(3), np.zeros(3), np.zeros((n, 6)), np.zeros(robot.joints),
            np.tile([0.0, 0.0, share], (p, 1)), np.tile(np.eye(3), (n, 1, 1)), np.zeros(n),
        )  # fmt: skip

    def step(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool, Status]:
        c = self.controller.step(q, v, self.tasks)
        assert np.isfinite(c.accelerations).all()
        return c.torques, c.forces, c.feasible, c.status


CONTROLLERS: dict[str, tuple[Callable[[Robot], Any], str]] = {
    "StandingController": (Standing, "go2"),
    "StandingController, a foot lifted": (Lifting, "go2"),
    "StandingController, flat feet": (Standing, "g1"),
    "WalkingController": (Walking, "go2"),
    "WalkingController, motors and drives": (Wired, "go2"),
    "ContactImplicitMpc": (ContactImplicit, "go2"),
    "WholeBodyController": (WholeBody, "go2"),
    "WholeBodyController, flat feet": (WholeBody, "g1"),
}
over_controllers = pytest.mark.parametrize("name", CONTROLLERS)


def controller_of(name: str) -> tuple[Any, Robot, np.ndarray, np.ndarray]:
    make, robot = CONTROLLERS[name][0], robot_of(CONTROLLERS[name][1])
    return make(robot), robot, place(robot), np.zeros(robot.model.nv)


def check_command(torques: np.ndarray, forces: np.ndarray, robot: Robot) -> None:
    assert np.isfinite(torques).all()
    assert np.all(np.abs(torques) <= robot.effort_limits + 1e-9)
    check_forces(forces, np.zeros(len(forces)), np.full(len(forces), np.inf))


@over_controllers
@pytest.mark.parametrize("bad", NOT_FINITE)
def test_controllers_slow_the_joints_when_the_state_is_not_finite(name: str, bad: float) -> None:
    """Any entry of q or v; also as the very first state; the next good one gets the command it would get."""
    controller, robot, q, v = controller_of(name)
    fresh, *_ = controller_of(name)
    if name == "WalkingController":  # whose time goes on
        fresh.time += 1e-3 * (2 * (robot.model.nq + robot.model.nv))
    for part in ("q", "v"):
        for k in range(len(q if part == "q" else v)):
            state, speed = q.copy(), v.copy()
            speed[-1] = 2.0
            (state if part == "q" else speed)[k] = bad
            torques, forces, well, status = controller.step(state, speed)
            check_command(torques, forces, robot)
            assert not well, (part, k)
            assert status is Status.INVALID, (part, k)
            assert (forces == 0.0).all()
            assert torques[-1] < 0.0 or (part, k) == ("v", len(v) - 1)
            if name == "WalkingController":
                controller.time += 1e-3
    torques, forces, well, status = controller.step(q, v)
    assert status in (Status.SOLVED, Status.ALMOST)
    want = fresh.step(q, v)
    assert well == want[2]
    np.testing.assert_allclose(torques, want[0], atol=1e-3 * robot.effort_limits.max())
    np.testing.assert_allclose(forces, want[1], atol=1e-3 * robot.mass * 9.81)


@over_controllers
@pytest.mark.parametrize("size", EXTREME)
def test_controllers_stay_finite_and_in_their_limits_on_extreme_states(name: str, size: float) -> None:
    controller, robot, q, v = controller_of(name)
    for part, k in (("q", 0), ("q", 2), ("q", 3), ("q", 9), ("v", 0), ("v", 4), ("v", 8)):
        state, speed = q.copy(), v.copy()
        (state if part == "q" else speed)[k] = size
        torques, forces, well, status = controller.step(state, speed)
        check_command(torques, forces, robot)
        assert status is not Status.INVALID or not well
    for zero in (np.zeros_like(q), np.full_like(q, size)):  # no orientation at all, and no robot
        torques, forces, *_ = controller.step(zero, v)
        check_command(torques, forces, robot)


def test_standing_on_no_friction_tells_that_a_slope_cannot_be_held() -> None:
    robot = robot_of("go2")
    controller = Standing(robot, mu=0.0).controller
    q, v = place(robot), np.zeros(robot.model.nv)
    q[0] += 0.05
    command = controller.step(RobotState(q, v, 0.0))
    assert not command.attained
    assert (command.forces[:, :2] == 0.0).all()


@pytest.mark.parametrize("effort", [0.12, 0.08, 0.04, 0.0])
def test_whole_body_says_infeasible_when_the_limited_solve_did(effort: float) -> None:
    """Go2 with next to no torque, told to press 60 N with every foot."""
    robot = robot_of("go2")
    member = WholeBody(robot, effort=effort, normal_min=60.0)
    torques, forces, well, status = member.step(place(robot), np.zeros(robot.model.nv))
    assert np.all(np.abs(torques) <= effort * robot.effort_limits + 1e-12)
    check_forces(forces, np.full(4, 60.0), np.full(4, 500.0))
    assert not well
    assert status is Status.INFEASIBLE
    strong = WholeBody(robot, effort=0.5, normal_min=60.0)
    # it can press so, but four times 60 N are more than its weight and throw the body up
    assert strong.step(place(robot), np.zeros(robot.model.nv))[2:] == (True, Status.COMPROMISED)


@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize(
    "what", ["com_acceleration", "turn_acceleration", "feet", "joints", "forces", "gaps"]
)
def test_whole_body_tasks_that_are_not_finite_are_invalid(what: str, bad: float) -> None:
    robot = robot_of("go2")
    member = WholeBody(robot)
    stance = np.array([False, True, True, True])
    values = {**member.tasks._asdict(), "stance": stance}
    values[what] = values[what].copy()
    values[what].flat[-1 if what != "feet" else 0] = bad
    member.tasks = Tasks(**values)
    v = np.full(robot.model.nv, 0.1)
    torques, forces, well, status = member.step(place(robot), v)
    check_command(torques, forces, robot)
    assert not well
    assert status is Status.INVALID


@pytest.mark.parametrize("bad", [*NOT_FINITE, 1e200])
@pytest.mark.parametrize("what", ["position", "linear_velocity", "rotation", "foot"])
def test_plans_that_cannot_be_made_share_the_weight_and_say_so(what: str, bad: float) -> None:
    mpc = ConvexMpc(mass=15.0, inertia=np.diag([0.1, 0.25, 0.3]), horizon=4, mu=MU, normal_max=HIGH)
    values = {
        "rotation": np.eye(3),
        "position": np.array([0.0, 0.0, 0.3]),
        "linear_velocity": np.zeros(3),
        "angular_velocity": np.zeros(3),
    }
    fine, feet, contacts = dict(values), np.array(FEET), np.ones((4, 4), dtype=bool)
    reference = BodyReference.cruise([0, 0, 0.3], yaw=0.0, horizon=4)
    good = mpc.solve(BodyState(**values), reference, feet, contacts)
    if what != "foot":
        values[what] = values[what].copy()
    (feet if what == "foot" else values[what]).flat[1] = bad
    plan = mpc.solve(BodyState(**values), reference, feet, contacts)
    for forces in plan.forces:
        check_forces(forces, np.zeros(4), np.full(4, HIGH))
    assert not plan.solved or math.isfinite(plan.error)
    if not math.isfinite(bad):
        assert plan.status is Status.INVALID
        assert plan.error == math.inf
    mpc.reset()
    again = mpc.solve(BodyState(**fine), reference, np.array(FEET), contacts)
    np.testing.assert_allclose(again.forces, good.forces, atol=0.05)
