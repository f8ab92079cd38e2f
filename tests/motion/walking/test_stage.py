"""A stage of the tick on a whole state: one literal in, one out, and no robot's file."""

from __future__ import annotations

import copy
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.whole_body_tasks import Kinematics
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.walking.foot_phases import FOOT, FeetContact, FootArray, FootPhase
from surefoot.motion.walking.force_planner import Ramps
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.walk_state import GaitState, PlanTimes, WalkState
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.motion.walking.walking_feet import Feet, FeetModel, SwingRequest
from tests.motion.walking.walked_feet import CENTRES

TROT = Gait.from_phases("trot", 0.5, 0.5, [0.0, 0.5, 0.5, 0.0])
"""Its times, as those below, are sums of powers of two: no rounding stands between literals and results."""
BEHIND = 2.0**-8
NEVER = -np.inf
MODEL = FeetModel(FlatTerrain(), np.full(4, 0.02), 0.06, 0.1)
FIRST = MODEL.lift_first
LANDED = np.array([0.21, -0.15, 0.02])
"""Where the foot that lands has come down."""


def records(*feet: dict[str, Any]) -> FootArray:
    """Return records of `FOOT`: of these fields, and else of a foot that has always stood where it is."""
    out = np.zeros(len(feet), FOOT)
    for record, centre, fields in zip(out, CENTRES, feet, strict=True):
        stood = {
            "phase": FootPhase.STANCE, "planned": 1, "touched_at": 0.24, "lifted_at": NEVER,
            "restart": (NEVER, NEVER), "search_from": 0.0, "start": centre, "target": centre,
            "previous_target": centre, "ground": centre - [0.0, 0.0, 0.02], "frame": np.eye(3),
        }  # fmt: skip
        for name, value in {**stood, **fields}.items():
            record[name] = value
    return out


def state(clock: GaitClock, *feet: dict[str, Any]) -> WalkState:
    """Return a whole state, of a trot in its second half-cycle, at a clock and with these feet."""
    return WalkState(
        clock=clock, gait=GaitState(stance_time=0.25, leap=None, fits=True, unease=0.5),
        feet=Feet(records(*feet)),
        body=BodyPlan(0.3, np.array([0.02, 0.0, 0.3]), 0.0), ramps=Ramps.of(4), touch=None, plan=None,
        horizon=None, times=PlanTimes(begun=0.19, aimed_at=0.18, aimless=False, load_waits=False),
        swing=SwingRequest(0.06), biped=None, parts={},
    )  # fmt: skip


SWINGING = {
    "phase": FootPhase.SWING,
    "planned": 0,
    "share": 0.995,
    "duration": 0.25,
    "lifted_at": 0.0,
    "apex": 0.08,
}
BEFORE = state(
    GaitClock(0.249, behind=BEHIND),
    {},
    {**SWINGING, "target": (0.22, -0.15, 0.02)},
    {**SWINGING, "target": (-0.18, 0.15, 0.02)},
    {},
)
"""Two feet stand whose swings begin at 0.25 s, two are at the end of theirs."""
LIFTED = {
    "phase": FootPhase.SWING, "planned": 0, "share": 0.0, "duration": 0.25, "touched_at": 0.25,
    "lifted_at": 0.25, "lift_first": FIRST,
}  # fmt: skip
AFTER = state(
    GaitClock(0.25, behind=BEHIND),
    LIFTED,
    {  # its touchdown was felt
        **SWINGING, "phase": FootPhase.STANCE, "planned": 1, "touched_at": 0.25,
        "target": LANDED, "previous_target": (0.22, -0.15, 0.02), "ground": LANDED - [0.0, 0.0, 0.02],
    },
    {  # its was not: the clock is behind the time since the gait's start, in which searches count
        **SWINGING, "phase": FootPhase.SEARCHING, "planned": 1, "target": (-0.18, 0.15, 0.02),
        "search_from": 0.25 + BEHIND,
    },
    LIFTED,
)  # fmt: skip


def advance(before: WalkState, clock: GaitClock, contact: FeetContact) -> tuple[WalkState, bool]:
    """Return the state after the stage that moves the feet on, and whether one has changed its phase."""
    walk = SimpleNamespace(_feet_model=MODEL, _followed=lambda gait: gait.leap or TROT)
    centres = CENTRES.copy()
    centres[1] = LANDED
    now = cast(Kinematics, SimpleNamespace(centres=centres))
    stage = cast(Any, WalkingController._advance_feet)
    feet, biped, changed = stage(walk, before, before.feet, contact, now, clock)
    return before._replace(clock=clock, feet=feet, biped=biped), changed


def test_feet_lift_land_and_miss_the_ground_at_the_half_of_a_trot() -> None:
    before = copy.deepcopy(BEFORE)
    contact = FeetContact.of(np.array([True, True, False, True]))
    after, changed = advance(before, before.clock.at(0.25 + BEHIND), contact)
    assert changed
    assert after == AFTER
    assert before == BEFORE  # a stage changes nothing that it is given
    assert WalkState.from_arrays(*after.to_arrays()) == AFTER


def test_before_the_gait_begins_all_feet_stand() -> None:
    clock = GaitClock(-0.1)
    before = BEFORE._replace(clock=clock)
    after, changed = advance(before, clock, FeetContact.of(np.zeros(4, dtype=bool)))
    assert not changed
    assert after == before
