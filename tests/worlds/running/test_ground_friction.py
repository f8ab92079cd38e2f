"""Ice as a place on the ground: what the world does there, what the log says, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.running.run import IcePatch, Scenario, run
from surefoot.worlds.running.sensors import SensorModel
from tests.worlds.running.walks import walk


@pytest.mark.long
def test_a_robot_that_watches_walks_on_ice_that_throws_another() -> None:
    (_, careful), (_, careless) = (
        walk(0.5, 2.5, mu=0.2, settings=WalkSettings(watch_friction=watch), sensors=SensorModel(), seed=2)
        for watch in (True, False)
    )
    assert careful.outcome == "walked"
    assert careful.laws_broken == []
    assert max(foot.slip for foot in careful.feet) < 0.01
    assert max(foot.slip for foot in careless.feet) > 0.03


@pytest.mark.long
def test_a_patch_of_ice_is_where_it_says_and_the_log_knows() -> None:
    patches = (IcePatch((0.3, -1.0), (0.6, 1.0), 0.25),)
    log, summary = walk(0.5, 2.5, patches=patches, sensors=SensorModel(), seed=2)
    told, x = log["contact_friction"], log["contact_positions"][..., 0]
    deep = (x > 0.31) & (x < 0.59)
    assert deep.any()
    assert (told[deep] == 0.25).all()
    assert (told[(x < 0.29) | (x > 0.61)] == 0.6).all()
    forces = log["forces"]
    loaded = forces[..., 2] > 5.0
    use = np.hypot(forces[..., 0], forces[..., 1])[loaded] / forces[..., 2][loaded]
    assert (use <= told[loaded] * 1.001).all()
    assert summary.laws_broken == []


def test_the_rigid_world_has_one_friction_everywhere() -> None:
    robot = load_robot("go2")
    controller = WalkingController(robot, VelocityCommand.constant(0.0))
    scenario = Scenario(0.1, 0.6, patches=(IcePatch((0.0, 0.0), (1.0, 1.0), 0.1),))
    with pytest.raises(ProblemError, match="mujoco"):
        run(RigidWorld(robot), controller, scenario)


def test_a_patch_without_an_inside_is_refused() -> None:
    with pytest.raises(ProblemError, match="patch of ice"):
        IcePatch((1.0, 0.0), (1.0, 2.0), 0.1)
