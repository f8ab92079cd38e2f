"""Fast walks on slopes that nobody has told, with motors, whole bodies and an estimated state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.robot.actuators import actuators_of
from surefoot.mechanics.terrain import SlopeTerrain, StairsTerrain, Terrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.walking.foot_phases import FootPhase
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand, first_stance
from surefoot.motion.walking.walking_feet import FeetModel, SwingRequest
from surefoot.records.audit import summarise_walk
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from surefoot.worlds.running.sensors import SensorModel
from surefoot.worlds.running.walk_terrain import start_pose

MU = 0.6


@pytest.mark.parametrize(("knowledge", "degrees", "speed"), [("blind", 15.0, 1.0), ("map", -15.0, 1.2)])
@pytest.mark.long
def test_a_fast_trot_on_a_slope_that_is_learned_does_not_fall(
    knowledge: str, degrees: float, speed: float
) -> None:
    robot, terrain = load_robot("go2"), SlopeTerrain(degrees)
    motors, command = actuators_of(robot, "real"), VelocityCommand.constant(speed)
    ground = controller_ground(knowledge, terrain)
    controller = walking_controller(robot, command, "trot", ground, MU, motors)
    scenario = Scenario(
        2.5, MU, seed=1, start=start_pose(robot, terrain), sensors=replace(SensorModel(), heights=False),
        scanner=RangeSensor() if knowledge == "map" else None,
    )  # fmt: skip
    summary = summarise_walk(
        run(MujocoWorld(robot, terrain, MU, collision="full", actuators="real"), controller, scenario)
    )
    assert summary.outcome == "walked"
    assert abs(summary.velocity.forward.error) < 0.1
    assert knowledge == "map" or not summary.laws_broken  # a noisy map lets a foot down hard now and then


def swing(terrain: Terrain, way: float) -> float:
    """Return the share in which a foot only lifts that has just begun its way over a terrain [m]."""
    centres = np.array([[0.2, 0.15, 0.02], [0.2, -0.15, 0.02], [-0.2, 0.15, 0.02], [-0.2, -0.15, 0.02]])
    model = FeetModel(terrain, np.full(4, 0.02), 0.07, 0.21)
    feet = model.standing(centres)
    feet.foot["phase"], feet.foot["duration"] = FootPhase.SWING, 0.18
    feet = model.aimed(feet, 0, centres[0, :2] + [way, 0.0], SwingRequest(0.07))
    return float(feet.foot["lift_first"][0])


def test_fast_swings_over_learned_even_ground_are_those_of_even_ground() -> None:
    class Learned(StairsTerrain):
        learns = True

    flat, riser = Learned(0.12, 9.0), Learned(0.12, 0.3)
    flat.rise = 0.0
    assert swing(flat, 0.3) < 0.0
    assert swing(flat, 0.1) > 0.0  # slow enough to lift first
    assert swing(riser, 0.3) > 0.0  # over an edge
    assert swing(StairsTerrain(0.12, 9.0), 0.3) > 0.0  # known ground is as it is


def test_a_body_whose_feet_stand_for_long_changes_its_speed_slowly() -> None:
    robot = load_robot("go2")
    changes = {}
    for gait in ("trot", "walk"):
        controller = walking_controller(robot, VelocityCommand.constant(0.2), gait, SlopeTerrain(0.0), MU)
        world = MujocoWorld(robot)
        q, v = world.q_v()
        controller.step(RobotState(q, v, 0.0, np.ones(4, dtype=bool)))
        changes[gait] = controller.body.change
    assert first_stance(named_gait("walk", 4)) > 2.0 * first_stance(named_gait("trot", 4))
    assert changes["walk"] < 0.7 * changes["trot"]
