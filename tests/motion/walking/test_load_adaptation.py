"""A load that the controllers were not told: their models with it, the wrench beside it, and whole walks."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import Robot, place
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.control.whole_body import ForceLimits, Tasks, WholeBodyController
from surefoot.motion.estimation.wrench_observer import Load
from surefoot.motion.walking import load_adaptation
from surefoot.motion.walking.body_settings import LoadSettings
from surefoot.motion.walking.load_adaptation import LoadAdaptation
from surefoot.motion.walking.walking_body import BodyPlan, VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from tests.robots import robot_of

DT = 1e-3
PLACE = np.array([0.1, 0.08, 0.08])


def adaptation(robot: Robot) -> LoadAdaptation:
    mpc = ConvexMpc(robot.mass, np.eye(3), len(robot.feet))
    return LoadAdaptation(robot, DT, mpc, WholeBodyController(robot))


def with_point_mass(robot: Robot, load: Load) -> pinocchio.Model:
    model = robot.model.copy()
    model.inertias[1] = model.inertias[1] + pinocchio.Inertia(load.mass, load.place, np.zeros((3, 3)))
    return model


def found(robot: Robot, mass: float, place: np.ndarray) -> LoadAdaptation:
    """Return an adaptation whose observer has found a payload, and whose models know it."""
    out = adaptation(robot)
    out.observer.values[:4] = [mass, *(mass * place)]
    out.update_models(None)
    return out


@pytest.mark.parametrize("name", ["go2", "anymal_c"])
def test_the_models_are_those_of_the_robot_with_a_point_mass(name: str) -> None:
    robot, random = robot_of(name), np.random.default_rng(0)
    load = Load(5.0, 5.0 * PLACE, PLACE)
    out, true = found(robot, 5.0, PLACE), with_point_mass(robot, load)
    data = true.createData()
    q = pinocchio.integrate(robot.model, robot.nominal, 0.2 * random.normal(size=robot.model.nv))
    v = random.normal(size=robot.model.nv)
    now = out.whole_body.update(q, v)
    M, bias, *_ = out.whole_body.instant()
    assert np.allclose(M, pinocchio.crba(true, data, q), rtol=0, atol=1e-10)
    assert np.allclose(bias, pinocchio.nonLinearEffects(true, data, q, v), rtol=0, atol=1e-8)
    assert np.allclose(now.com, pinocchio.centerOfMass(true, data, q), rtol=0, atol=1e-12)
    pinocchio.ccrba(true, data, robot.nominal, np.zeros(robot.model.nv))
    base = np.array(data.oMi[1].rotation)
    assert out.mpc.mass == pytest.approx(robot.mass + 5.0)
    assert np.allclose(out.mpc.inertia, base.T @ data.Ig.inertia @ base, rtol=0, atol=1e-9)
    out.reset()
    out.whole_body.update(q, v)
    M, bias, *_ = out.whole_body.instant()
    data = robot.model.createData()
    assert np.array_equal(M, pinocchio.crba(robot.model, data, q))
    assert np.array_equal(bias, pinocchio.nonLinearEffects(robot.model, data, q, v))
    assert out.mpc.mass == robot.mass


@pytest.mark.parametrize("mass", [-4.0, 0.0, 20.0])
def test_whatever_is_found_leaves_masses_that_can_be(mass: float) -> None:
    """A lighter robot, and a centre of mass that is elsewhere than the model's, have inertias too."""
    robot = robot_of("go2")
    out = found(robot, mass, PLACE)
    out.observer.values[1:4] = np.array([0.08, -0.08, 0.05]) * robot.mass * out.observer.height
    out.update_models(None)
    out.whole_body.update(robot.nominal, np.zeros(18))
    M = out.whole_body.instant().M
    assert np.linalg.eigvalsh(M)[0] > 0.0
    assert np.linalg.eigvalsh(out.mpc.inertia)[0] > 0.0
    assert np.isfinite(M).all()


def test_a_known_wrench_is_part_of_the_equations_of_motion() -> None:
    robot = robot_of("go2")
    control, q, v = WholeBodyController(robot), place(robot), np.zeros(18)
    outside = np.array([20.0, -10.0, -30.0, 2.0, 3.0, -1.0])
    now = control.update(q, v)
    frames, n = np.tile(np.eye(3), (4, 1, 1)), 4
    tasks = Tasks(
        np.ones(n, dtype=bool), np.zeros(3), np.zeros(3), np.zeros((n, 6)), np.zeros(12),
        np.tile([0.0, 0.0, 40.0], (n, 1)), frames, np.zeros(n),
    )  # fmt: skip
    command = control.solve(tasks, ForceLimits(outside=outside))
    M, bias, *_ = control.instant()
    points = now.centres - [[0.0, 0.0, foot.radius] for foot in robot.feet]
    data = robot.model.createData()
    J = pinocchio.computeJointJacobians(robot.model, data, q)
    push = sum(
        f @ (J[:3] - pinocchio.skew(p) @ J[3:]) * s
        for f, p, s in zip(command.forces, points, robot.contact_points.foot_support, strict=True)
    )
    rest = M @ command.accelerations + bias - push - np.r_[outside, command.torques]
    assert np.abs(rest).max() < 1e-6


def test_the_body_keeps_its_place_when_its_centre_of_mass_moves() -> None:
    robot = robot_of("go2")
    out = found(robot, 0.0, PLACE)
    now = out.whole_body.update(robot.nominal, np.zeros(18))
    out.pull(now, robot.nominal[:3])
    body = BodyPlan(0.3, now.com.copy(), 0.0)
    before = now.com - body.position, now.com[2] - body.height
    out.observer.values[:4] = [5.0, *(5.0 * PLACE)]
    out.update_models(body)
    now = out.whole_body.update(robot.nominal, np.zeros(18))
    assert np.allclose(now.com - body.position, before[0], atol=1e-9)
    assert now.com[2] - body.height == pytest.approx(before[1], abs=1e-9)


def test_of_a_wrench_no_more_is_handed_on_than_the_bound() -> None:
    robot = robot_of("go2")
    out = adaptation(robot)
    now = out.whole_body.update(robot.nominal, np.zeros(18))
    out.observer.values[4:] = out.observer.wrench_unit * [0.2, -0.2, 0.03, 0.0, 0.0, -0.2]
    on_base = out.pull(now, robot.nominal[:3])
    weight, height = robot.mass * 9.81, out.observer.height
    wanted = np.array([0.1, -0.1, 0.03, 0.0, 0.0, -0.1 * height]) * weight
    base = pinocchio.Quaternion(robot.nominal[3:7]).matrix()
    assert np.allclose(on_base, np.r_[base.T @ wanted[:3], base.T @ wanted[3:]])
    arm = robot.nominal[:3] - now.com
    assert np.allclose(out.mpc.outside, np.r_[wanted[:3], wanted[3:] + np.cross(arm, wanted[:3])])


def steps_seen(lean: float, gap: float = DT) -> bool:
    """Return whether an observer learns from steps at a lean [rad], `gap` [s] apart."""
    robot = robot_of("go2")
    out = adaptation(robot)
    q, v, on = place(robot), np.zeros(18), np.ones(4, dtype=bool)
    q[3:7] = [np.sin(lean / 2), 0.0, 0.0, np.cos(lean / 2)]
    tasks = Tasks(
        on, np.zeros(3), np.zeros(3), np.zeros((4, 6)), np.zeros(12), np.zeros((4, 3)),
        np.tile(np.eye(3), (4, 1, 1)), np.zeros(4),
    )  # fmt: skip
    for k in range(15):
        out.observe(RobotState(q, v, k * gap, on))
        out.whole_body.update(q, v)
        out.whole_body.solve(tasks)
        out.acted(k * gap, np.zeros(12), on)
    return bool(out.observer.state.any())


def test_the_observer_stands_still_while_the_robot_falls_or_steps_are_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert steps_seen(0.1)
    assert not steps_seen(1.0)
    assert not steps_seen(0.1, gap=3.0 * DT)
    monkeypatch.setattr(load_adaptation, "LOAD", LoadSettings(lean=1.2))
    assert steps_seen(1.0)


def test_without_settings_nothing_is_observed() -> None:
    robot = robot_of("go2")
    state = RobotState(place(robot), np.zeros(18), 0.0, np.ones(4, dtype=bool))
    for settings, names in (
        (WalkSettings(watch_load=False), set()),
        (WalkSettings(), {"load_estimated", "wrench_estimated"}),
    ):
        controller = WalkingController(robot, VelocityCommand.constant(0.0), settings=settings)
        rows = set(controller.step(state).rows())
        assert (
            rows
            == {channel.name for channel in controller.channels}
            == {"planned", "command", "asked_by"} | names
        )


def leaning(settings: WalkSettings, mass: float, duration: float = 1.6) -> tuple[float, np.ndarray]:
    """Return the largest lean [deg] of a trot with an unknown payload, and what was estimated at its end."""
    robot = robot_of("go2")
    world = MujocoWorld(robot, payload=mass, payload_position=PLACE)
    log = run(
        world, WalkingController(robot, VelocityCommand.constant(0.5), settings=settings),
        Scenario(duration, 0.6, seed=3),
    )  # fmt: skip
    assert log.facts["outcome"] == "done"
    up = rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2]
    estimate = log["load_estimated"][-1] if "load_estimated" in log else np.zeros(4)
    return float(np.degrees(np.arccos(up.min()))), estimate


def test_a_payload_off_the_centre_hardly_tilts_a_trot() -> None:
    lean, estimate = leaning(WalkSettings(), 5.0)
    assert lean < 4.0
    assert estimate[0] == pytest.approx(5.0, rel=0.05)
    assert estimate[1:3] / estimate[0] == pytest.approx(PLACE[:2], abs=0.01)
    assert leaning(WalkSettings(watch_load=False), 5.0, 1.0)[0] > 8.0


def test_a_robot_that_carries_nothing_finds_nothing() -> None:
    lean, estimate = leaning(WalkSettings(), 0.0)
    assert abs(estimate[0]) < 0.02 * robot_of("go2").mass
    assert np.abs(estimate[1:3]).max() < 0.02
    assert lean < 0.5
