"""The table of causes: what each is, the evidence that it needs, and what would refute it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from surefoot.records.audit.report import Finding
from surefoot.records.audit.story import (
    control_causes,
    counterfactuals,
    gait_causes,
    sensor_causes,
    soft_causes,
    world_causes,
)
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.told import Event


@dataclass(frozen=True)
class Rule:
    """One cause.

    Attributes
    ----------
    name
        What it is called.
    find
        From signals to what speaks for it.
    refuted
        The counterfactual that would refute it, in words.
    remedy
        What to try.
    lasts
        Whether it goes on once it has begun; else it explains nothing that comes much later.
    alone
        Whether it is one also where the log shows no failure.
    outside
        Whether nothing that the robot does can bring it about: it is no consequence of another cause.
    leads
        Whether its first sign comes late: what begins as soon before it counts as its consequence.
    acts
        Whether only what has joints can bring it about.
    residual
        Whether it is told only by what it leads to: it is a cause where no other is.
    dear
        Whether it takes long to look for: of a robot with a free base that has not failed it is not.
    without
        The counterfactual, recomputed from what speaks for it and the failure; None from a log that does not
        allow it. None where no log does.
    """

    name: str
    find: Callable[[Signals], Iterator[Sign]]
    refuted: str
    remedy: str
    lasts: bool = True
    alone: bool = True
    outside: bool = False
    leads: bool = False
    acts: bool = False
    residual: bool = False
    dear: bool = False
    without: Callable[[Signals, Sign, Event], counterfactuals.Without | None] | None = None


FRAMES = ("wrong frame", "reversed", "mirrored", "swapped feet", "wrong scale")
"""Symptoms of an audit that say what was done to the forces of a log."""
WRONG_FRAME = Rule(
    "wrong contact frame",
    world_causes.wrong_frame,
    "the forces as logged explain the motion",
    "state the frame and the sign of every force in its name; turn it once",
    outside=True,
)
CATCH = "land earlier, and nearer to the capture point"
CALIBRATE = "calibrate: the level of the base, the zeros of the joints"
RULES = (
    Rule(
        "push", world_causes.push, "the impulse is too small to matter, or was long before",
        "plan for it: wider stance, quicker steps, or keep away", lasts=False, alone=False, outside=True,
        without=counterfactuals.without_push,
    ),
    Rule(
        "payload", world_causes.payload, "the mass of the robot is what it was",
        "estimate the load and give it to the controller", outside=True,
        without=counterfactuals.without_load,
    ),
    Rule(
        "weak actuator", control_causes.weak, "it gives what is asked for within its limits",
        "check the drive; make the controller stop, or walk without it", outside=True,
        without=counterfactuals.without_limit, acts=True,
    ),
    Rule(
        "slope too steep", world_causes.slope, "friction holds on that tilt",
        "less slope, or feet with more friction", alone=False, outside=True,
        without=counterfactuals.without_slope,
    ),
    Rule(
        "slippery ground", world_causes.slippery, "the foot sticks on as much friction as before",
        "ask for less tangential force: slower, wider, the friction told to the controller", lasts=False,
        alone=False, outside=True, without=counterfactuals.without_ice,
    ),
    Rule(
        "terrain edge", world_causes.edge, "all feet stand on the plane that they began on",
        "tell the gait of the ground, or lift the feet higher and land by touch", lasts=False, alone=False,
        outside=True,
    ),
    Rule(
        "soft contact", soft_causes.soft, "no contact goes deeper than shoes would",
        "stiffer contact (solref, solimp) and a shorter time step", outside=True,
    ),
    Rule(
        "self-collision", world_causes.self_collision, "no links touch",
        "keep links apart in the targets, or leave the pair out of collision if the model is wrong",
        leads=True, acts=True,
    ),
    Rule(
        "chattering gains", control_causes.chatter, "torques do not alternate",
        "lower the gains, or the time step; damping below the mass over the time step", leads=True, acts=True,
    ),
    Rule(
        "delayed control", control_causes.delay, "torques answer the state of their own row",
        "use the newest measurement; lower the gains for the delay that is left", outside=True, dear=True,
        acts=True,
    ),
    Rule(
        "saturated actuator", control_causes.saturation, "no torque is at its limit for long",
        "slower or smaller motions, or stronger motors", without=counterfactuals.without_limit, acts=True,
    ),
    Rule(
        "impossible command", control_causes.too_fast, "the speed is possible",
        "ask for what is within reach", alone=False, outside=True, acts=True,
    ),
    Rule(
        "impossible command", control_causes.at_stops, "no joint is at its stop",
        "ask for what is within reach", alone=False, acts=True,
    ),
    Rule(
        "foot placement", gait_causes.placement, "feet land where and when they have landed so far",
        CATCH, alone=False, acts=True,
    ),
    Rule(
        "foot placement", gait_causes.late_catch, "the capture point stays within the feet", CATCH,
        alone=False, residual=True, acts=True,
    ),
    Rule(
        "slow gait", gait_causes.tips, "each stance is shorter than the time to tip", "a shorter period",
        alone=False, acts=True,
    ),
    Rule(
        "slow gait", gait_causes.slow, "the body's way in a stance is within the legs' reach",
        "a shorter period for this speed", alone=False, residual=True, acts=True,
    ),
    Rule(
        "wrong mass", sensor_causes.wrong_mass, "at rest the feet carry the weight and no more",
        "give the controller the mass and the centre of mass that there are", alone=False, outside=True,
        acts=True,
    ),
    Rule(
        "sensor bias", sensor_causes.bias, "torques change with the motion", CALIBRATE, outside=True,
        leads=True, acts=True,
    ),
    Rule(
        "sensor bias", sensor_causes.drift, "the body is not driven to one side from the start", CALIBRATE,
        alone=False, residual=True, acts=True,
    ),
    Rule(
        "impossible command", sensor_causes.led_out, "the body stays within its feet",
        "ask for what is within reach", alone=False, residual=True, acts=True,
    ),
)  # fmt: skip


def frame_sign(symptoms: tuple[Finding, ...]) -> Sign | None:
    """Return what an audit's symptoms say of forces that are not what acted; None where they do not."""
    found = next((f for f in symptoms[:1] if f.name in FRAMES), None)
    return None if found is None else Sign(found.start, found.contact, found.evidence, found.strength)
