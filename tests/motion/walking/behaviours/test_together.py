"""Behaviours together: each gait on ground that is known, seen or touched walks upright for a second."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import Terrain, read_terrain
from surefoot.motion.ground.terrain_knowledge import KNOWLEDGE, controller_ground
from surefoot.motion.walking.behaviours import BEHAVIOURS
from surefoot.motion.walking.behaviours.arbiter import LOGGED, RULES
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController, WalkSettings
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.height_scan import RangeSensor
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from surefoot.worlds.running.walk_terrain import start_pose

NAMES = {
    "exact": ["stand still", "push recovery", "seen stairs", "cruise"],
    "map": ["stand still", "push recovery", "seen stairs", "stumble", "cruise"],
    "blind": ["stand still", "push recovery", "stop at drop", "seen stairs", "stumble", "cruise"],
}
"""Behaviours by what is known of the ground: "seen stairs" where a gait adapts, "slip" where friction is
watched."""


@pytest.mark.long
@pytest.mark.parametrize(("ground", "watch"), [("flat", True), ("slope:8", False)], ids=["slip", "slope"])
@pytest.mark.parametrize("knowledge", KNOWLEDGE)
@pytest.mark.parametrize("gait", ["trot", "walk", "auto"])
def test_behaviours_walk_together(gait: str, knowledge: str, ground: str, watch: bool) -> None:
    terrain: Terrain = read_terrain(ground, "terrain")
    belief = controller_ground(knowledge, terrain)
    go2, settings = load_robot("go2"), WalkSettings(watch_friction=watch, behaviours=BEHAVIOURS)
    walker = WalkingController(go2, VelocityCommand.constant(0.3), gait, belief, settings)
    scanner = RangeSensor() if knowledge == "map" else None
    scenario = Scenario(1.0, 0.6, start=start_pose(go2, terrain), scanner=scanner)
    log = run(MujocoWorld(go2, terrain, 0.6), walker, scenario, [])
    assert log.fact("outcome") == "done"
    up = rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2]
    assert up.min() > np.cos(np.radians(20.0))
    if gait != "auto":  # which turns its first walk into a trot before it goes anywhere
        assert log["q"][-1, 0] > log["q"][0, 0] + 0.08
    names = log.facts["behaviours"]
    assert [name for name in names if name != "slip"] == [
        name for name in NAMES[knowledge] if name != "seen stairs" or name in names
    ]
    assert ("slip" in names) == watch
    asked_by = log["asked_by"]
    assert asked_by.shape == (1000, len(RULES))
    start = asked_by[:250, LOGGED.index("pace")]
    assert (start == names.index("stand still")).all()  # nobody goes before the gait begins
    if watch:
        assert (asked_by[:, LOGGED.index("mu")] == names.index("slip")).all()
