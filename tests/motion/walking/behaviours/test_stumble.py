"""After a stumble feet are lifted higher: what is asked for, and what the swings then do."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.gaits.library import named_gait
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.ground.mapped_ground import MappedGround
from surefoot.motion.ground.touched_ground import TouchedGround
from surefoot.motion.walking.behaviours.behaviour import NOTHING
from surefoot.motion.walking.behaviours.behaviour_settings import StumbleSettings
from surefoot.motion.walking.behaviours.stumble import Stumble
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.worlds.rigid.rigid_world import RigidWorld
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from surefoot.worlds.running.walk_terrain import start_pose
from tests.motion.walking.behaviours.views import HEIGHT, HIPS, view_of, walk_of


@pytest.mark.parametrize("belief", [TouchedGround(), MappedGround()], ids=["touch", "map"])
def test_a_stumble_is_remembered_for_a_while(belief: BeliefTerrain) -> None:
    one = Stumble.of(walk_of(belief))
    assert one is not None
    belief.begin(RobotState(np.zeros(19), np.zeros(18)), np.column_stack([HIPS, np.zeros(4)]), HEIGHT)
    assert one.propose(view_of(time=1.0)) is NOTHING
    belief.stumbled(1.0)
    assert one.propose(view_of(time=1.0)).clearance == pytest.approx(StumbleSettings().lift * HEIGHT)
    assert one.propose(view_of(time=1.0 + 0.49 * StumbleSettings().memory)).clearance == pytest.approx(
        StumbleSettings().lift * HEIGHT
    )
    assert (
        0.0
        < one.propose(view_of(time=1.0 + 0.9 * StumbleSettings().memory)).clearance
        < 0.5 * StumbleSettings().lift * HEIGHT
    )
    assert one.propose(view_of(time=1.0 + StumbleSettings().memory)) is NOTHING


def test_bumps_that_are_not_seen_are_stepped_over_and_not_too_high() -> None:
    class Bumpy(TouchedGround):
        bumps = 0.03  # type: ignore[assignment]

    one, high = Stumble.of(walk_of(Bumpy())), Bumpy()
    high.bumps = 1.0  # type: ignore[assignment]
    assert one is not None
    assert one.propose(view_of()).clearance == pytest.approx(0.03)
    assert Stumble(walk_of(high), high).propose(view_of()).clearance == pytest.approx(
        StumbleSettings().highest * HEIGHT
    )
    assert Stumble.of(walk_of()) is None  # known ground


class Stumbling(TouchedGround):
    """Believes at 0.4 s that a foot has struck an edge."""

    def observe(self, state: RobotState, *feet: np.ndarray) -> None:
        if abs(state.time - 0.4) < 1e-6:
            self.stumbled(state.time)
        super().observe(state, *feet)


def highest_lift(ground: BeliefTerrain, gait: str | Gait) -> float:
    """Return how far off flat ground Go2 gets its feet from 0.5 s on [m]."""
    go2, flat = load_robot("go2"), FlatTerrain()
    walker = WalkingController(go2, VelocityCommand.constant(0.4), gait, ground)
    log = run(RigidWorld(go2, flat, 0.6), walker, Scenario(1.0, 0.6, start=start_pose(go2, flat)), [])
    radius = float(np.mean([foot.radius for foot in go2.feet]))
    return max(float(go2.foot_positions(q)[:, 2].max()) for q in log["q"][500:]) - radius


@pytest.mark.parametrize("gait", ["trot", named_gait("trot", 4)], ids=["adaptive", "fixed"])
@pytest.mark.long
def test_after_a_stumble_a_trot_lifts_its_feet_as_high_as_is_asked_for(gait: str | Gait) -> None:
    usual, raised = highest_lift(TouchedGround(), gait), highest_lift(Stumbling(), gait)
    assert usual == pytest.approx(0.07, abs=0.01)
    assert raised == pytest.approx(0.133, abs=0.01)
