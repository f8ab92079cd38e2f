"""What a sample changes, against closed forms and Pinocchio."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.contact.solution import Status
from surefoot.mechanics.robot import load_robot
from surefoot.motion.control.controller import Command
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.sweep import EXPERIMENTS, sweep_from_dict
from surefoot.worlds.sweep.drop import DropExperiment
from surefoot.worlds.sweep.sample_experiment import KINDS, make_experiment

SEED = 1


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_experiment_keeps_to_the_table(name: str) -> None:
    experiment = make_experiment(name)
    assert set(experiment.columns.values()) <= set(KINDS)
    assert experiment.columns[experiment.goal] == "bool"
    assert not set(experiment.columns) & {*experiment.parameters(), "index", "status", "error", "wall_time"}
    assert all(experiment.limits(n)[0] <= (getattr(experiment, n) or 1.0) for n in experiment.numbers())


@pytest.mark.long
def test_no_box_rests_where_coulomb_says_that_it_slides() -> None:
    config = sweep_from_dict({"experiment": "drop", "settings": {"height": 0.01, "tumble": False},
                              "ranges": {"mu": [0.1, 1.0], "slope": [0, 40]}})  # fmt: skip
    rested = steep = 0
    for one in config.space.sample(range(32)):
        drop = replace(config.experiment, **one.values)
        result = drop.run(one.seed)
        sticks = drop.mu > math.tan(math.radians(drop.slope))
        rested, steep = rested + result["rested"], steep + (not sticks)
        assert sticks or not result["rested"]
    assert rested >= 8
    assert steep >= 5


@pytest.mark.parametrize("restitution", [0.0, 0.4, 0.8])
def test_a_ball_bounces_by_its_restitution_squared(restitution: float) -> None:
    height, dt = 0.2, 0.001
    result = DropExperiment(body="ball", height=height, tumble=False, dt=dt, restitution=restitution).run(
        SEED
    )
    speed = math.sqrt(2.0 * GRAVITY * height)
    assert result["bounce"] == pytest.approx(restitution**2 * height, abs=2.0 * speed * dt)
    assert result["depth_max"] < 1e-6


def test_a_ball_sinks_into_a_spring_as_its_energy_says() -> None:
    height, stiffness, mass = 0.1, 2e4, 1.5
    settings = {"body": "ball", "height": height, "tumble": False, "dt": 1e-4, "duration": 0.3}
    result = DropExperiment(**settings, stiffness=stiffness, mass=mass).run(SEED)
    rest = mass * GRAVITY / stiffness
    assert result["depth_max"] == pytest.approx(rest + math.sqrt(rest**2 + 2.0 * rest * height), rel=0.02)


def test_mass_inertia_and_centre_of_mass() -> None:
    robot = load_robot("go2")
    own = DropExperiment(mass=1.3, inertia=1.5, com_x=0.02, com_z=-0.01).alter_masses(robot)
    assert own.mass == pytest.approx(1.3 * robot.mass, rel=1e-12)
    share = robot.model.inertias[1].mass / robot.mass
    turn = pinocchio.Quaternion(robot.nominal[3:7]).toRotationMatrix()
    np.testing.assert_allclose(own.com() - robot.com(), share * turn @ [0.02, 0.0, -0.01], atol=1e-12)
    for k in range(1, robot.model.njoints):
        np.testing.assert_allclose(
            own.model.inertias[k].inertia, 1.95 * robot.model.inertias[k].inertia, rtol=1e-12
        )
    np.testing.assert_array_equal(own.contact_points.places, robot.contact_points.places)
    assert robot.model.inertias[1].mass * 1.3 == own.model.inertias[1].mass  # the robot itself is as it was
    assert DropExperiment().alter_masses(robot) is robot


def test_motors_give_their_share() -> None:
    world = RigidWorld(load_robot("go2"))
    faults = Faults(strength=0.8, weak_joint="FL_calf_joint", torque_loss=0.5).start(world, None)
    asked = Command(np.ones(12), np.zeros((4, 3)), np.zeros(4, dtype=bool), True, Status.SOLVED)
    given = faults.act(asked, *world.q_v())
    assert sorted(given.tolist()) == pytest.approx([0.4] + [0.8] * 11)
    with pytest.raises(ProblemError, match="strength must be a number between 0 and 10, got -1"):
        Faults(strength=-1.0).start(world, None)


@pytest.mark.parametrize("world", ["mujoco", "rigid"])
@pytest.mark.long
def test_a_walk_depends_on_its_ground_and_motors(world: str) -> None:
    settings = {"world": world, "duration": 0.5, "slope": 15.0}
    held, lost = (make_experiment("walk", {**settings, "mu": mu}).run(SEED) for mu in (0.6, 0.1))
    assert lost["slip"] > 0.01 > held["slip"]
    stiff = make_experiment("walk", {**settings, "joint_friction": 5.0}).run(SEED)
    assert stiff["velocity"] != held["velocity"]
    plain = make_experiment(
        "walk", {**settings, "armature": 0.0, "joint_damping": 0.0, "joint_friction": 0.0}
    )
    assert plain.run(SEED)["velocity"] == pytest.approx(held["velocity"], abs=1e-6)


def test_soft_ground_is_sunk_into_and_gives_work_back() -> None:
    settings = {"duration": 1.0, "damping_ratio": 1.0}
    stiff, soft = (make_experiment("walk", {**settings, "time_constant": t}).run(SEED) for t in (0.004, 0.08))
    assert soft["sink"] > 10.0 * stiff["sink"]
    assert soft["ground_work"] > stiff["ground_work"] >= 0.0
    assert set(soft) == set(make_experiment("walk").columns)


def test_a_sample_gives_the_same_twice() -> None:
    walk = make_experiment("walk", {"duration": 0.5, "noise": 0.7, "roughness": 0.01})
    walk.check()
    assert walk.run(4) == walk.run(4)
