"""The world in Bullet: the same robot, the same conventions, judged by closed forms and by the audit."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import MissingExtra, ModelError, ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.terrain import rough_ground
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.worlds.bullet.bullet_world import BulletWorld
from surefoot.worlds.rigid.bodies import ball
from surefoot.worlds.running.walk_terrain import start_pose
from tests.records.audit.broken_controllers import broken_runs
from tests.worlds.running.engine_worlds import contacts_after, flight_errors

HERE = importlib.util.find_spec("pybullet") is not None
bullet = pytest.mark.skipif(not HERE, reason="PyBullet is not here: pip install -e '.[bullet]'")


@pytest.mark.skipif(HERE, reason="PyBullet is here")
def test_without_pybullet_the_extra_is_named() -> None:
    with pytest.raises(MissingExtra, match="bullet"):
        BulletWorld(ball(1.0, 0.1))


@bullet
def test_flight_is_pinocchios() -> None:
    """In the air, with motors and a push, its error is that of semi-implicit Euler: first order."""
    errors = flight_errors(BulletWorld, (1e-3, 5e-4), 2e-5)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] < 0.05


@bullet
def test_a_state_comes_back_as_it_was_put() -> None:
    robot = sf.load_robot("a1")
    rng = np.random.default_rng(5)
    q, v = robot.nominal.copy(), rng.normal(size=18)
    q[2] += 1.0
    q[3:7] = np.array([0.1, 0.5, -0.3, 0.8]) / np.linalg.norm([0.1, 0.5, -0.3, 0.8])
    world = BulletWorld(robot, dt=1e-6)
    world.reset(q, v)
    world.step(np.zeros(12))
    assert np.allclose(world.q_v()[0], q, rtol=0.0, atol=1e-5)
    assert np.allclose(world.q_v()[1], v, rtol=0.0, atol=1e-3)


@bullet
def test_a_payload_weighs_and_rests() -> None:
    world = BulletWorld(ball(2.0, 0.1), payload=1.0)
    reading = contacts_after(world, 500)
    assert reading.forces[0, 2] == pytest.approx(3.0 * GRAVITY, rel=1e-3)
    assert abs(reading.gaps[0]) < 1e-3


@bullet
@pytest.mark.parametrize("name", ["go2", "a1", "solo12"])
def test_a_stand_on_a_slope_is_lawful(name: str) -> None:
    robot, slope = sf.load_robot(name), sf.SlopeTerrain(12.0)
    q = sf.place(robot, slope)
    controller = sf.StandingController(robot, sf.StandingPlan(robot, slope, q), slope, q, mu=0.6)
    report = sf.audit_log(sf.run(BulletWorld(robot, slope), controller, sf.Scenario(0.6, mu=0.6, start=q)))
    assert report.passed, report.sentence


@bullet
@pytest.mark.long
def test_a_trot_is_lawful_and_gets_there() -> None:
    robot, ground = sf.load_robot("go2"), sf.FlatTerrain()
    command = VelocityCommand.constant(0.4, 0.0, 0.0)
    controller = walking_controller(robot, command, None, ground, mu=0.6)
    scenario = sf.Scenario(2.0, mu=0.6, start=start_pose(robot, ground))
    log = sf.run(BulletWorld(robot, ground), controller, scenario)
    assert sf.audit_log(log).passed
    assert float(log["q"][-1][0] - log["q"][0][0]) > 0.5


@bullet
def test_a_softness_that_is_translated_gives_way_as_its_law_says() -> None:
    law = sf.laws.SpringDamper(stiffness=2e4, damping=200.0)
    contact = sf.translate(law, to="bullet", mass=2.0).parameters
    world = BulletWorld(ball(2.0, 0.1), contact=contact)
    assert contacts_after(world, 1500).gaps[0] == pytest.approx(-2.0 * GRAVITY / 2e4, rel=0.01)


@bullet
@pytest.mark.long
def test_broken_controllers_and_detuned_ground_are_named() -> None:
    runs = broken_runs(32, seed=31, worlds=("bullet",))
    missed = [run for run in runs if not run.named(sf.audit_log(run.log()))]
    assert len(missed) <= 3, missed


@bullet
def test_wrong_input_is_one_line() -> None:
    with pytest.raises(ProblemError, match="valid names: contactDamping"):
        BulletWorld(ball(1.0, 0.1), contact={"stiffness": 1.0})
    with pytest.raises(ProblemError, match="turbo"):
        BulletWorld(ball(1.0, 0.1), engine={"turbo": 1.0})
    with pytest.raises(ModelError, match="planes and boxes"):
        BulletWorld(ball(1.0, 0.1), rough_ground(1, 0.02))
