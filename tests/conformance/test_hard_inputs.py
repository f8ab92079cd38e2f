"""Every controller, distributor and world on input that is not finite, infeasible or extreme.

A controller and a distributor never raise on numbers: what they return is finite and within every limit, says
so when it is not what was asked for, and is forgotten by the next good input. A world refuses what is not
finite by its name, and ends with a `SurefootError` where its state would not stay finite: it never goes on
without a word. A new member of a family is one line in its table.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.contact import Status
from surefoot.control.allocation import ExactAllocation, SolverAllocation
from surefoot.control.body_motion import BodyReference, BodyState
from surefoot.control.controller import RobotState
from surefoot.control.force_distribution import ForceDistributor
from surefoot.control.mpc import ConvexMpc
from surefoot.control.standing import StandingController
from surefoot.control.standing_plan import Lift, StandingPlan
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.control.whole_body import Tasks, WholeBodyController
from surefoot.errors import SurefootError
from surefoot.robot import Robot, load_robot, place
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.rigid import RigidWorld
from surefoot.simulation.world import World
from surefoot.stance import PointContact, Stance
from surefoot.terrain import FlatTerrain

NOT_FINITE = [math.nan, math.inf, -math.inf]
EXTREME = [1e6, -1e12, 1e100, -1e200, 1e308, 1e-310]
MU, LOW, HIGH = 0.6, 5.0, 200.0
FEET = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]
WRENCH = np.array([10.0, -5.0, 160.0, 1.0, -2.0, 0.5])


@cache
def robot_of(name: str) -> Robot:
    return load_robot(name)


def grasp() -> np.ndarray:
    return np.ascontiguousarray(Stance([PointContact(p, mu=MU) for p in FEET]).grasp_map([0.01, 0.0, 0.3]))


def check_forces(forces: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    assert np.isfinite(forces).all()
    assert np.all(np.hypot(forces[:, 0], forces[:, 1]) <= MU * forces[:, 2] + 1e-7)
    assert np.all((forces[:, 2] >= low - 1e-9) & (forces[:, 2] <= high + 1e-9))


# ---- distributors: (grasp map, wrench, Jacobian) -> forces, status, a bound on their error


class Distribution:
    """One way to distribute forces, with the bounds that every member of the family has here."""

    low, high = np.full(4, LOW), np.full(4, HIGH)

    def __init__(self) -> None:
        self.distributor = ForceDistributor(MU, LOW, HIGH, 1.0, 1e-4)

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return self.distributor.solve(A, w)

    @property
    def status(self) -> Status:
        return self.distributor.status

    @property
    def errors(self) -> list[float]:
        return [self.distributor.force_error, self.distributor.wrench_error]


class WithTorques(Distribution):
    def __init__(self) -> None:
        self.distributor = ForceDistributor(MU, LOW, HIGH, 1.0, 1e-4, torque_limit=np.full(12, 15.0))
        self.jacobian = 0.3 * np.random.default_rng(3).normal(size=(12, 12))

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return self.distributor.solve(A, w, jacobian=self.jacobian)


class Exact(Distribution):
    def __init__(self) -> None:
        self.distributor: Any = ExactAllocation(np.full(4, MU), np.ones(6), 1e-4)

    def solve(self, A: np.ndarray, w: np.ndarray) -> np.ndarray:
        return np.asarray(self.distributor.share(A, w, self.low, self.high))

    @property
    def errors(self) -> list[float]:
        return []


class Linear(Exact):
    low = np.zeros(4)

    def __init__(self) -> None:
        self.distributor = SolverAllocation(np.full(4, MU), np.ones(6), 1e-4, "auto", 8)


class AnySolver(Exact):
    low = np.zeros(4)

    def __init__(self) -> None:
        self.distributor = SolverAllocation(np.full(4, MU), np.ones(6), 1e-4, "distribution")


DISTRIBUTORS: dict[str, Callable[[], Distribution]] = {
    "ForceDistributor": Distribution,
    "ForceDistributor with torque limits": WithTorques,
    "ExactAllocation": Exact,
    "SolverAllocation, pyramids": Linear,
    "SolverAllocation, exact": AnySolver,
}
over_distributors = pytest.mark.parametrize("name", DISTRIBUTORS)


@over_distributors
@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize("where", ["grasp map", "wrench"])
def test_distributors_hold_what_they_had_when_input_is_not_finite(name: str, where: str, bad: float) -> None:
    member = DISTRIBUTORS[name]()
    A, w = grasp(), WRENCH.copy()
    (A if where == "grasp map" else w).flat[2] = bad
    for before in (False, True):  # as the first input, and after a good one
        for _ in range(4 if before else 0):  # until shares of the step before have settled
            good = member.solve(grasp(), WRENCH)
        forces = member.solve(A, w)
        assert member.status is Status.INVALID
        assert all(error == math.inf for error in member.errors)
        check_forces(forces, member.low, member.high)
        if before:
            np.testing.assert_allclose(forces, good, atol=1e-6)
    again = member.solve(grasp(), WRENCH)
    assert member.status is Status.SOLVED
    np.testing.assert_allclose(again, good, atol=1e-4)


@over_distributors
@pytest.mark.parametrize("size", EXTREME)
def test_distributors_stay_finite_on_extreme_input(name: str, size: float) -> None:
    """Huge and tiny wrenches and grasp maps; SOLVED only with a finite bound on the error."""
    for which in ("wrench", "map", "both"):
        member = DISTRIBUTORS[name]()
        A, w = grasp(), WRENCH.copy()
        if which != "map":
            w[0] = size
        if which != "wrench":
            A[4, 5] = size
        check_forces(member.solve(A, w), member.low, member.high)
        if member.status is Status.SOLVED:
            assert all(math.isfinite(error) for error in member.errors)
        for _ in range(3):  # the warm start may take a call or two to forget, and says so
            check_forces(member.solve(grasp(), WRENCH), member.low, member.high)
        assert member.status is Status.SOLVED


@over_distributors
def test_distributors_say_what_they_miss(name: str) -> None:
    """A wrench beyond every cone: the nearest forces, and the error is told by the wrench that is left."""
    member = DISTRIBUTORS[name]()
    w = np.array([500.0, 0.0, 100.0, 0.0, 0.0, 0.0])
    forces = member.solve(grasp(), w)
    check_forces(forces, member.low, member.high)
    left = float(np.linalg.norm(grasp() @ forces.ravel() - w))
    assert left > 50.0
    if member.errors:
        assert member.errors[1] == pytest.approx(left, rel=1e-9)


def test_impossible_torque_limits_are_infeasible_with_no_bound_on_the_error() -> None:
    distributor = ForceDistributor(MU, 60.0, HIGH, 1.0, 1e-4, torque_limit=np.full(4, 1.0))
    J = np.zeros((12, 4))
    J[2::3] = 0.3 * np.eye(4)  # 60 N take 18 N m
    forces = distributor.solve(grasp(), WRENCH, jacobian=J)
    check_forces(forces, np.full(4, 60.0), np.full(4, HIGH))
    assert distributor.status is Status.INFEASIBLE
    assert distributor.force_error == math.inf
    assert distributor.torque_excess == pytest.approx(17.0, abs=0.01)
    J[0, 0] = math.nan
    distributor.solve(grasp(), WRENCH, jacobian=J)
    assert distributor.status is Status.INVALID
    assert distributor.torque_excess == math.inf


def test_nothing_is_known_before_the_first_solve() -> None:
    distributor = ForceDistributor(MU, LOW, HIGH)
    assert distributor.status is Status.INVALID
    assert distributor.force_error == distributor.wrench_error == distributor.torque_excess == math.inf


# ---- controllers: a state in, torques and forces out


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
    assert strong.step(place(robot), np.zeros(robot.model.nv))[2:] == (True, Status.SOLVED)


@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize(
    "what", ["com_acceleration", "turn_acceleration", "feet", "joints", "forces", "gaps"]
)
def test_whole_body_tasks_that_are_not_finite_are_invalid(what: str, bad: float) -> None:
    robot = robot_of("go2")
    member = WholeBody(robot)
    stance = np.array([False, True, True, True])
    values = {**vars(member.tasks), "stance": stance}
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


# ---- worlds


WORLDS: dict[str, Callable[..., World]] = {"rigid": RigidWorld, "mujoco": MujocoWorld}
over_worlds = pytest.mark.parametrize("name", WORLDS)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its warnings to a file in the present folder."""
    monkeypatch.chdir(tmp_path)


def world_of(name: str, robot: str = "go2", dt: float = 1e-3) -> World:
    world = WORLDS[name](robot_of(robot), dt=dt)
    world.reset(place(robot_of(robot)))
    return world


def check_state(world: World) -> None:
    reading = world.contacts()
    q, v = world.state()
    for array in (q, v, reading.forces, reading.gaps, reading.velocities, reading.positions):
        assert np.isfinite(array).all()
    assert math.isfinite(world.time)


def steps_to_the_end(world: World, steps: int, torques: np.ndarray, push: np.ndarray | None) -> int:
    """Return how many steps a world took before it said that it could not go on."""
    for k in range(steps):
        try:
            world.step(torques, push)
        except SurefootError:
            return k
    return steps


@over_worlds
@pytest.mark.parametrize("bad", NOT_FINITE)
@pytest.mark.parametrize("what", ["torques", "push"])
def test_worlds_refuse_by_name_what_is_not_finite(name: str, what: str, bad: float) -> None:
    world = world_of(name)
    torques, push = np.zeros(12), np.zeros(3)
    (torques if what == "torques" else push)[1] = bad
    before = world.state()
    with pytest.raises(SurefootError, match=what):
        world.step(torques, push)
    np.testing.assert_array_equal(world.state()[0], before[0])  # nothing has moved
    world.step(np.zeros(12))
    check_state(world)


@over_worlds
@pytest.mark.parametrize("bad", NOT_FINITE)
def test_worlds_refuse_a_start_that_is_not_finite(name: str, bad: float) -> None:
    world = world_of(name)
    q, v = place(robot_of("go2")), np.zeros(18)
    q[8] = bad
    with pytest.raises(SurefootError):
        world.reset(q)
    v[8] = bad
    with pytest.raises(SurefootError):
        world.reset(place(robot_of("go2")), v)
    with pytest.raises(SurefootError, match="mu"):
        world.set_friction(bad if not bad > 0.0 else math.nan)


@over_worlds
@pytest.mark.parametrize("size", [1e3, 1e6, 1e12, 1e100, 1e300])
def test_worlds_end_with_an_error_where_a_state_is_lost(name: str, size: float) -> None:
    """Torques and pushes from strong to absurd: a finite state to the end, or up to a `SurefootError`."""
    for push in (np.zeros(3), np.array([size, 0.0, 0.0])):
        world = world_of(name)
        torques = np.zeros(12) if push.any() else size * np.tile([1.0, -1.0, 1.0], 4)
        ended = steps_to_the_end(world, 50, torques, push)
        assert ended < 50 or size < 1e100
        check_state(world)


@over_worlds
@pytest.mark.parametrize("seed", range(3))
def test_worlds_do_not_lose_fast_limp_robots_in_silence(name: str, seed: int) -> None:
    """G1 with joint speeds of 15 rad/s at 5 ms, which a coarse step cannot follow."""
    robot, rng = robot_of("g1"), np.random.default_rng(seed)
    world = world_of(name, "g1", dt=5e-3)
    v = np.zeros(robot.model.nv)
    v[6:] = 15.0 * rng.normal(size=robot.joints)
    q = robot.nominal.copy()
    q[2] += 0.5
    world.reset(q, v)
    steps_to_the_end(world, 100, np.zeros(robot.joints), None)
    check_state(world)
