"""A drop that a blind robot's foot finds: what it makes of it, and Go2 at a step down."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import PitTerrain
from surefoot.motion.ground.ground_settings import TOUCHED_GROUND
from surefoot.motion.ground.touched_ground import Ledge, TouchedGround
from surefoot.motion.walking.behaviours.behaviour import NOTHING
from surefoot.motion.walking.behaviours.stop_at_drop import StopAtDrop
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from surefoot.worlds.running.walk_terrain import start_pose
from tests.motion.walking.behaviours.views import ALL, HEIGHT, HIPS, NONE, level, view_of, walk_of

RADIUS = 0.022
ONE_UP = np.array([False, True, True, True])


def reach_down(ground: TouchedGround, depths: list[float], place: float = 0.3) -> np.ndarray:
    """Let the left front foot look for the ground at a place, ever lower [m]; return the stands."""
    stands = np.column_stack([HIPS, np.zeros(4)])
    ground.radius = RADIUS
    ground.begin(level(0.0, speed=0.4), stands, HEIGHT)
    ground.observe(level(0.001, speed=0.4), stands, ONE_UP, NONE, stands)
    for k, depth in enumerate(depths):
        soles = stands.copy()
        soles[0] = place, 0.14, -depth
        ground.observe(level(0.1 + 0.01 * k, speed=0.4), stands, ONE_UP, ~ONE_UP, soles)
    return stands


def stand(ground: TouchedGround, stands: np.ndarray, at: tuple[float, float]) -> None:
    """Let the left front foot stand at (x, z)."""
    stands[0] = at[0], 0.14, at[1]
    ground.observe(level(0.4, speed=0.4), stands, ALL, NONE, stands)


def test_a_foot_that_finds_no_ground_stops_the_body_and_the_walk_says_why() -> None:
    ground = TouchedGround()
    one = StopAtDrop.of(walk_of(ground))
    assert one is not None
    command = (0.4, 0.1, 0.0)
    reach_down(ground, [0.0, 0.03, 0.06])
    assert ground.drop is None  # a hole as on rough ground
    assert one.propose(view_of(command)) is NOTHING
    stands = reach_down(ground, [0.0, 0.03, 0.06, 0.08, 0.11])
    assert ground.drop is not None
    asked = one.propose(view_of(command, ground=stands, stance=ONE_UP))
    assert asked.velocity is not None
    assert asked.velocity.tolist() == [0.0, 0.0, 0.0]
    assert asked.search is not None
    assert asked.search.careful
    assert asked.note == ""
    assert not asked.hold  # a body at rest over three feet goes on looking
    assert one.propose(view_of(command, ground=stands)).hold
    stand(ground, stands, (0.3, -0.12))
    assert ground.drop.depth == pytest.approx(0.12)
    note = one.propose(view_of(command, ground=stands, time=0.4)).note
    assert note.startswith("stopped from 0.40 s on: a foot found the ground 120 mm lower")
    stand(ground, stands, (0.31, -0.12))
    assert one.propose(view_of(command, ground=stands, time=0.5)).note == note
    one.reset()
    ground.begin(level(0.0, speed=0.4), stands, HEIGHT)
    assert one.propose(view_of(command)) is NOTHING


def test_a_small_step_is_none_and_the_walk_goes_on_as_on_a_plane() -> None:
    low = 0.9 * TOUCHED_GROUND.drop * HEIGHT
    ground = TouchedGround()
    stands = reach_down(ground, [0.0, 0.05, low - 0.005])
    assert ground.drop is not None
    stand(ground, stands, (0.3, -low))
    assert (ground.drop, ground.unsure) == (None, False)
    assert ground.gradient(HIPS[0])[0] < -0.03


def test_feet_keep_to_where_feet_have_stood() -> None:
    drop = Ledge(np.array([1.0, 0.0]), 0.5, 0.6, 0.0, 0.12, HEIGHT, RADIUS)
    drop.stand(0.6, -0.12)
    places = np.linspace(0.3, 1.2, 91)
    found = np.array([drop.nearest(np.array([s, 0.1]))[0] for s in places])
    before, beyond = found <= 0.5, found >= drop.edge + TOUCHED_GROUND.reach
    assert (before | beyond).all()
    assert before[places < 0.5].all()
    assert beyond[places > 0.65].all()
    assert drop.height(found[before]).tolist() == [0.0] * before.sum()
    assert drop.height(found[beyond]).tolist() == [-0.12] * beyond.sum()
    assert found.max() < 0.6 + HEIGHT


@pytest.mark.long
def test_a_blind_go2_stops_at_a_drop_and_stays() -> None:
    go2, pit = load_robot("go2"), PitTerrain(0.45, 3.0, 0.12)
    walker = WalkingController(go2, VelocityCommand.constant(0.4), "trot", TouchedGround())
    log = run(MujocoWorld(go2, pit, 0.6), walker, Scenario(5.0, 0.6, start=start_pose(go2, pit)), [])
    assert log.fact("outcome") == "done"
    assert rotation_from_quaternion(log["q"][:, 3:7])[:, 2, 2].min() > np.cos(np.radians(26.0))
    at_rest = log["q"][3300:, 0]
    assert np.ptp(at_rest) < 0.05  # it stands astride, and goes on no more
    assert 0.2 < at_rest.mean() < 0.65
    assert log["q"][3400, 2] < 0.31
    (note,) = log.fact("notes")
    assert "not taken by touch alone" in note
    walker.reset()
    assert walker.notes == []  # of the next walk; this one's log keeps its line
    assert log.fact("notes") == [note]
