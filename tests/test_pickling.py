"""Robots, worlds, controllers, loops and solvers in other processes: copies go on to the last bit."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError
from surefoot.contact import Status
from surefoot.laws import SpringDamper
from surefoot.motion.control.controller import RobotState
from surefoot.motion.drive.readings import RobotReadings
from surefoot.motion.drive.watchdog import Watchdog
from surefoot.motion.standing.standing_plan import StandingPlan
from surefoot.motion.walking.walkers import walking_controller
from surefoot.worlds.rigid.bodies import ball
from tests.pickled_values import policy, scene, stepper
from tests.robots import robot_of

BEFORE, AFTER = 40, 30
"""Steps before a copy is made, and after."""


def of_robot(robot: Any, k: int) -> list[Any]:
    """Return what a robot says of itself."""
    q = robot.nominal
    shapes = len(robot.collision.geometryObjects), len(robot.visual.geometryObjects)
    return [
        robot.mass,
        robot.com(q),
        robot.foot_positions(q),
        robot.effort_limits,
        robot.joint_names,
        *shapes,
    ]


def of_controller(controller: Any, k: int) -> list[Any]:
    """Return a command for a robot that shakes a little."""
    robot = getattr(controller, "robot", None) or controller.controller.robot
    q, v = sf.place(robot), np.zeros(robot.model.nv)
    q[2] -= 0.001 * (k % 7)
    v[3] = 0.1 * np.sin(k)
    contact = np.ones(len(robot.feet), dtype=bool)
    command = controller.step(RobotState(q, v, 0.001 * k, contact, v[6:]))
    return [command.torques, command.forces, command.attained]


def of_whole_body(controller: Any, k: int) -> list[Any]:
    """Return a command, and what became of its tasks."""
    robot = controller.robot
    n, points = len(robot.feet), len(robot.contact_points)
    tasks = sf.Tasks(
        np.ones(n, dtype=bool), np.array([0.1 * (k % 5), 0.0, 0.0]), np.zeros(3), np.zeros((n, 6)),
        np.zeros(robot.joints), np.zeros((points, 3)), np.tile(np.eye(3), (n, 1, 1)), np.zeros(n),
    )  # fmt: skip
    command = controller.step(robot.nominal, np.zeros(robot.model.nv), tasks)
    return [command.torques, command.forces, command.attained["forces"].got, command.status is Status.SOLVED]


def of_world(world: Any, k: int) -> list[Any]:
    """Return where a world has come to."""
    world.step(0.5 * np.sin(np.arange(world.robot.joints) + 0.1 * k))
    return [*world.q_v(), world.contacts().forces, world.time]


def of_solver(solver: Any, k: int) -> list[Any]:
    """Return a solver's answer to a problem like the last one."""
    A = np.random.default_rng(k // 5).normal(size=(6, 6))
    answer = solver.solve(A @ A.T + np.eye(6), np.sin(np.arange(6.0) + 0.01 * k) - 1.0)
    return [answer.forces, answer.iterations, answer.status.value]


def of_stepper(pair: Any, k: int) -> list[Any]:
    """Return how a ball that is kicked goes on, of a stepper and its data."""
    stepper, data = pair
    data.qvel[0] += 0.01 * np.sin(k)
    stepper.step(data)
    return [data.qpos, data.qvel, stepper.steps, stepper.certificate.iterations]


def kicked() -> Any:
    """Return a stepper, and the data that it steps."""
    import mujoco

    made = stepper()
    return made, mujoco.MjData(made.model)


def of_scene(world: Any, k: int) -> list[Any]:
    """Return where a cube that is pushed has come to."""
    world.step(None, np.array([2.0 * np.sin(k), 0.0, 0.0]))
    return [*world.q_v(), world.time]


def of_filter(ekf: Any, k: int) -> list[Any]:
    """Return an estimate of a robot that shakes a little."""
    robot, sway = robot_of("go2"), 1e-3 * np.sin(0.1 * k)
    if k == 0:
        ekf.reset(sf.place(robot))
    ekf.predict(np.array([sway, 0.0, 0.0]), np.array([0.0, sway, 9.81]))
    used = ekf.update(robot.nominal[7:] + sway, np.full(12, sway), np.ones(4, dtype=bool))
    return [used, *ekf.q_v()]


def of_loop(loop: Any, k: int) -> list[Any]:
    """Return a loop's targets while it stands up."""
    if k == 20:
        loop.go("stand")
    still, up = np.full(12, 1e-3), np.array([0.0, 0.0, 9.81])
    positions = loop.robot.nominal[7:] + 1e-5 * k
    level = np.array([0.0, 0.0, 0.0, 1.0])
    targets = loop.step(RobotReadings(k * loop.dt, level, np.zeros(3), up, positions, still, still * k))
    return [*targets, loop.mode.value, loop.time]


def divided() -> Any:
    """Return a MuJoCo world in which much is chosen."""
    world = sf.MujocoWorld(robot_of("go2"), sf.SlopeTerrain(5.0), 0.5, payload=2.0, actuators="real")
    world.divide(3)
    world.count_centripetal()
    world.set_friction(0.4)
    return world


def standing() -> Any:
    """Return a standing controller of Go2."""
    robot, ground = robot_of("go2"), sf.FlatTerrain()
    q = sf.place(robot)
    return sf.StandingController(robot, StandingPlan(robot, ground, q), ground, q)


def walking(name: str) -> Any:
    """Return a controller that walks a robot."""
    return walking_controller(robot_of(name), sf.VelocityCommand.constant(0.3))


Step = Callable[[Any, int], list[Any]]
CASES: dict[str, tuple[Callable[[], Any], Step]] = {
    "Robot": (lambda: sf.load_robot("go2"), of_robot),
    "WholeBodyController": (lambda: sf.WholeBodyController(robot_of("go2")), of_whole_body),
    "WalkingController": (lambda: walking("go2"), of_controller),
    "BipedController": (lambda: walking("g1"), of_controller),
    "StandingController": (standing, of_controller),
    "Watchdog": (lambda: Watchdog(walking("go2"), robot_of("go2"), 1e-3), of_controller),
    "MujocoWorld": (divided, of_world),
    "RigidWorld": (lambda: sf.RigidWorld(robot_of("go2")), of_world),
    "RigidWorld of a ball": (
        lambda: sf.RigidWorld(ball(4.0, 0.1), law=SpringDamper(2e4, 400.0)), of_world
    ),
    "ContactSolver": (lambda: sf.ContactSolver(2, [0.5, 0.6]), of_solver),
    "InvariantEkf": (lambda: sf.InvariantEkf(robot_of("go2"), 0.002), of_filter),
    "MujocoStepper": (kicked, of_stepper),
    "Policy": (policy, of_controller),
    "Guard": (lambda: sf.Guard(policy(), 0.3), of_controller),
    "SceneWorld": (lambda: sf.SceneWorld(scene()), of_scene),
    "RobotLoop": (lambda: sf.RobotLoop(robot_of("go2"), 0.002), of_loop),
}  # fmt: skip


def moved(name: str) -> Any:
    """Return a case after some steps."""
    make, step = CASES[name]
    thing = make()
    for k in range(BEFORE):
        step(thing, k)
    return thing


def went_on(name: str, thing: Any) -> bytes:
    """Return what a case does from now on, every bit of it."""
    said = [CASES[name][1](thing, k) for k in range(BEFORE, BEFORE + AFTER)]
    return b"".join(np.asarray(value).tobytes() for row in said for value in row)


def by_cloudpickle(thing: Any) -> Any:
    """Return a copy by cloudpickle, as joblib, Ray and Dask make it."""
    cloudpickle = pytest.importorskip("cloudpickle")
    return pickle.loads(cloudpickle.dumps(thing))


COPIES = {
    "pickle": lambda x: pickle.loads(pickle.dumps(x)),
    "cloudpickle": by_cloudpickle,
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("how", COPIES)
@pytest.mark.parametrize("name", CASES)
@pytest.mark.sampled(12)
def test_a_copy_goes_on_to_the_last_bit_and_leaves_the_first_alone(name: str, how: str) -> None:
    thing = moved(name)
    again = COPIES[how](thing)
    there = went_on(name, again)
    assert went_on(name, thing) == there


@pytest.mark.parametrize(
    "names",
    [("Robot", "MujocoWorld", "ContactSolver"), (*CASES,)],
    ids=["some", "all"],
)
@pytest.mark.long
def test_another_process_goes_on_to_the_last_bit(names: tuple[str, ...]) -> None:
    things = {name: moved(name) for name in names}
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = dict(zip(things, pool.starmap(went_on, things.items()), strict=True))
    for name, thing in things.items():
        assert went_on(name, thing) == there[name], name


def test_a_robot_is_small_in_a_pickle_and_loads_its_shapes_when_asked() -> None:
    robot = sf.load_robot("go2")
    data = pickle.dumps(robot)
    assert len(data) < 200_000  # its meshes are 160 MB
    again = pickle.loads(data)
    assert "collision" not in vars(again)
    assert pickle.dumps(again) == pickle.dumps(pickle.loads(pickle.dumps(again)))
    assert len(again.collision.geometryObjects) == len(robot.collision.geometryObjects)
    with pytest.raises(AttributeError, match="colision"):
        _ = again.colision


def test_a_robot_whose_file_is_gone_says_so(tmp_path: Any) -> None:
    urdf = tmp_path / "pole.urdf"
    urdf.write_text(
        '<robot name="pole"><link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link></robot>'
    )
    data = pickle.dumps(sf.load_robot(urdf))
    urdf.unlink()
    again = pickle.loads(data)
    assert again.mass == 1.0
    with pytest.raises(ModelError, match=r"pole\.urdf, which is not here"):
        _ = again.collision


def test_what_a_caller_writes_later_does_not_reach_what_was_kept() -> None:
    place = np.array([0.1, 0.0, 0.0])
    world = sf.MujocoWorld(robot_of("go2"), payload=1.0, payload_position=place)
    place[:] = 5.0
    assert np.array_equal(pickle.loads(pickle.dumps(world)).payload_position, [0.1, 0.0, 0.0])
