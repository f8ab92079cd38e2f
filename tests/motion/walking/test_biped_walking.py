"""Walking on two flat feet in MuJoCo, judged by the audit."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ModelError, ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import load_robot, place
from surefoot.mechanics.robot.actuators import actuators_of
from surefoot.mechanics.terrain import FlatTerrain, rough_ground
from surefoot.motion.control.controller import RobotState
from surefoot.motion.walking.behaviours.arbiter import LOGGED
from surefoot.motion.walking.biped.settings import BipedSettings
from surefoot.motion.walking.biped.soles import sole_damping
from surefoot.motion.walking.biped.walking import BipedController
from surefoot.motion.walking.walkers import default_gait, walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.records.audit import audit_log, summarise_walk
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Push, Scenario
from tests.motion.walking.behaviours.views import Wanting

pytest.importorskip("mujoco")
SLOW = [("g1", 0.3, 3.0), ("icub", 0.2, 0.0), ("talos", 0.0, 0.0)]


@pytest.mark.parametrize(
    ("name", "speed", "load"),
    [("g1", 0.3, 0.0), *(pytest.param(*v, marks=pytest.mark.long) for v in SLOW)],
)
def test_humanoids_walk_lawfully(name: str, speed: float, load: float) -> None:

    robot = load_robot(name)
    controller = walking_controller(robot, VelocityCommand.constant(speed))
    world = MujocoWorld(robot, FlatTerrain(), 0.6, payload=load, payload_position=(0.08, 0.0, 0.15))
    log = run(world, controller, Scenario(4.0, 0.6, seed=1))
    summary = summarise_walk(log)
    assert summary.outcome == "walked"
    assert summary.velocity.within
    assert summary.tilt_max_deg < (6.0 if load else 2.0)  # it leans until it knows
    assert summary.commanded_cone_excess < 1e-6
    assert audit_log(log).lawful
    assert (~log["planned"]).any(axis=0).all()
    assert log["load_estimated"][-1, :3] == pytest.approx([load, 0.08 * load, 0.0], abs=0.3)


@pytest.mark.long
def test_a_pushed_humanoid_steps_where_it_is_caught() -> None:
    robot = load_robot("g1")
    controller = walking_controller(robot, VelocityCommand.constant(0.3))
    shoved = Scenario(5.0, 0.6, (Push(2.4, (0.0, 200.0, 0.0), 0.1),), seed=1)
    log = run(MujocoWorld(robot, FlatTerrain(), 0.6), controller, shoved)
    assert log.fact("outcome") == "done"
    assert audit_log(log).lawful


@pytest.mark.long
def test_soles_come_down_gently_on_rough_ground() -> None:
    """Soles tip over the corners that touch: let down gently, no corner strikes the ground.

    With no more damping than the contact constraint has, and no press, force times depth of a corner reaches
    0.54 mm times m g here.
    """

    robot, ground = load_robot("g1"), rough_ground(1, 0.03)
    motors = actuators_of(robot, "real")
    controller = walking_controller(robot, VelocityCommand.constant(0.3), terrain=ground, actuators=motors)
    log = run(MujocoWorld(robot, ground, 0.6, actuators=motors), controller, Scenario(4.0, 0.6, seed=1))
    assert summarise_walk(log).outcome == "walked"
    assert float(np.abs(log["forces"][..., 2] * log["gaps"]).max()) < 0.25e-3 * robot.mass * GRAVITY


@pytest.mark.parametrize("dt", [1e-3, 4e-3])
def test_soles_settle_within_what_a_step_can_take(dt: float) -> None:
    rates = sole_damping((16.0, 40.0), 3.8, dt)
    assert rates == pytest.approx((50.0, 50.0) if dt > 1e-3 else (60.8, 152.0))


def test_the_controller_follows_from_the_feet() -> None:
    still = VelocityCommand.constant(0.0)
    assert isinstance(walking_controller(load_robot("talos"), still), BipedController)
    with pytest.raises(ModelError, match="three or more point feet, it has 2"):
        walking_controller(load_robot("bolt"), still)
    assert isinstance(walking_controller(load_robot("solo12"), still), WalkingController)
    assert default_gait(load_robot("go2")) == "trot"
    with pytest.raises(ModelError, match="two flat feet"):
        BipedController(load_robot("bolt"), still)
    with pytest.raises(ModelError, match="legs have 80% of its mass"):
        walking_controller(load_robot("alexander"), still)
    with pytest.raises(ProblemError, match="valid names: stand, walk"):
        walking_controller(load_robot("talos"), still, "trot")


@pytest.mark.long
def test_the_audit_knows_rotors_and_friction() -> None:

    robot = load_robot("g1")
    controller = walking_controller(
        robot, VelocityCommand.constant(0.0), actuators=actuators_of(robot, "real")
    )
    world = MujocoWorld(robot, FlatTerrain(), 0.6, actuators="real")
    log = run(world, controller, Scenario(1.2, 0.6, seed=2))
    assert audit_log(log).lawful
    for name in ("armature", "viscous_friction", "dry_friction"):
        del log.facts[name]
    assert {v.law for v in audit_log(log).violations} == {"motion"}


@pytest.mark.parametrize("share", [1.0, -1.0])
def test_a_humanoid_is_slowed_to_what_its_soles_can_walk(share: float) -> None:
    robot = load_robot("g1")
    fast = walking_controller(robot, VelocityCommand.constant(share * 0.8))
    assert abs(fast.command.at(0.0)[0]) == pytest.approx(0.6, abs=0.005)  # at 0.62 m/s it falls
    assert "slowed to 75 %" in fast.notes[0]
    usual = walking_controller(robot, VelocityCommand.constant(share * 0.6))
    assert usual.command.at(0.0)[0] == share * 0.6
    assert not usual.notes


@pytest.fixture(scope="module")
def wanting() -> tuple[BipedController, dict[str, int]]:
    """A walk of G1 whose only behaviour asks for everything, and who has got its way by quantity."""
    robot = load_robot("g1")
    settings = BipedSettings(behaviours=(Wanting,))
    walker = BipedController(robot, VelocityCommand.constant(0.3), settings=settings)
    still, both = np.zeros(robot.model.nv), np.ones(2, dtype=bool)
    command = walker.step(RobotState(place(robot), still, 0.0, both))
    for time in np.arange(0.005, walker.start + 0.4, 0.005):
        command = walker.step(RobotState(place(robot), still, float(time), both))
    return walker, dict(zip(LOGGED, command.asked_by.tolist(), strict=True))


@pytest.mark.long
def test_a_biped_does_what_a_behaviour_gets(wanting: tuple[BipedController, dict[str, int]]) -> None:
    walker, got = wanting
    assert got["mu"] == got["clearance"] == got["acceleration"] == 0
    assert walker.whole_body.mu == 0.3
    usual = walker.settings.clearance * walker.height
    swing = walker.state.swing
    assert swing.clearance == pytest.approx(usual + 0.01)
    assert walker.body.acceleration == 0.5
    forces = walker.state.plan.forces
    assert (np.hypot(forces[:, 0], forces[:, 1]) <= 0.3 * forces[:, 2] + 1e-9).all()


def test_a_biped_refuses_what_it_cannot_do(wanting: tuple[BipedController, dict[str, int]]) -> None:
    _, got = wanting
    refused = {"step_times", "hold", "foot_goals", "search", "recovery"}
    assert {name for name, rank in got.items() if rank < 0} == refused
