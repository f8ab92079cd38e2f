"""What counts as an event of a story, and as evidence of a cause."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import setting
from surefoot.records.audit.limit_sources import STORIES
from surefoot.records.audit.story.cause_limits import CauseLimits


@dataclass(frozen=True)
class StoryLimits(CauseLimits):
    """Limits of events and of causes, with those of single rules; none decides whether a law holds."""

    loaded: float = setting(
        0.02,
        "m g",
        "normal force from which a contact carries something",
        low=0.0,
        tuned=STORIES + "0.0003125 to 0.04",
    )
    used_up: float = setting(
        0.95, "-", "share of mu from which friction is used up", low=0.0, tuned=STORIES + "0 to 0.9992"
    )
    slip_speed: float = setting(
        0.03, "m/s", "speed from which a loaded contact slides", low=0.0, tuned=STORIES + "0.0004687 to 0.12"
    )
    slide: float = setting(
        0.04,
        "m",
        "way from which a slide of feet is one that matters",
        low=0.0,
        tuned=STORIES + "0.02 to 0.06",
    )
    strays: float = setting(
        0.35,
        "h",
        "way beside what a command leads to that fails it, and half of that way",
        low=0.0,
        tuned=STORIES + "0.35 to 22.4",
    )
    crooked: float = setting(
        0.2,
        "rad",
        "lean of the base to the end, with which it stands crooked",
        low=0.0,
        tuned=STORIES + "0.0125 to 12.8",
    )
    lean: float = setting(
        0.5, "rad", "lean of the base from which it falls", low=0.0, tuned=STORIES + "0.25 to 0.5"
    )
    drop: float = setting(
        0.35,
        "-",
        "share of its height that a falling centre of mass has lost",
        low=0.0,
        tuned=STORIES + "0.175 to 22.4",
    )
    brief: float = setting(
        0.02, "s", "shortest time of what is an event", low=0.0, tuned=STORIES + "0.0003125 to 0.04"
    )
    push: float = setting(
        0.02,
        "sqrt(g h)",
        "change of velocity from which a push matters",
        low=0.0,
        tuned=STORIES + "0.00125 to 0.32",
    )
    fades: float = setting(
        1.5,
        "s",
        "time after which a push or a slip explains a fall no more",
        low=0.0,
        tuned=STORIES + "1.5 to 96",
    )
    steep: float = setting(
        0.95,
        "-",
        "tangent of the ground's tilt over mu from which nothing stands",
        low=0.0,
        tuned=STORIES + "0 to 0.9992",
    )
    slippery: float = setting(
        0.35, "-", "mu below which ground is slippery", low=0.0, tuned=STORIES + "0.0875 to 0.35"
    )
    less_grip: float = setting(
        0.7,
        "-",
        "share of the mu before, from which on ground is more slippery",
        low=0.0,
        tuned=STORIES + "0.01094 to 0.7",
    )
    edge: float = setting(
        0.015,
        "m",
        "change of the ground's height that a gait on flat ground meets",
        low=0.0,
        tuned=STORIES + "0.0009375 to 0.96",
    )
    depth: float = setting(
        0.01,
        "m",
        "depth of a loaded contact from which the world is soft",
        low=0.0,
        tuned=STORIES + "0.005 to 0.04",
    )
    payload: float = setting(
        0.05,
        "m",
        "mass that is added, from which it matters, over the robot's",
        low=0.0,
        tuned=STORIES + "0.0007813 to 0.2",
    )
    lies: float = setting(
        0.3, "s", "time from which what touches from above lies there", low=0.0, tuned=STORIES + "0.2 to 0.6"
    )
    inner: float = setting(
        0.05,
        "m g",
        "force between links from which they hit each other",
        low=0.0,
        tuned=STORIES + "0.0007813 to 0.8",
    )
    weaker: float = setting(
        0.9,
        "-",
        "share of a torque asked for, below which an actuator is weak",
        low=0.0,
        tuned=STORIES + "0.225 to 0.9984",
    )
    saturated: float = setting(
        0.5, "-", "share of a time with a torque at its limit", low=0.0, tuned=STORIES + "0.25 to 0.75"
    )
    window: float = setting(0.1, "s", "that time", low=0.0, tuned=STORIES + "0.05 to 0.4")
    flips: float = setting(
        0.25,
        "-",
        "share of rows in which a chattering torque turns",
        low=0.0,
        tuned=STORIES + "0.125 to 0.375",
    )
    swing: float = setting(
        0.3, "-", "size of that, over the largest torque", low=0.0, tuned=STORIES + "0.075 to 1.2"
    )
    lag: float = setting(
        0.012,
        "s",
        "delay of torques behind the state they answer",
        low=0.0,
        tuned=STORIES + "0.0001875 to 0.018",
    )
    lag_better: float = setting(
        0.05,
        "-",
        "share of the torques' changes that it explains beyond what no delay does",
        low=0.0,
        tuned=STORIES + "0.0007813 to 0.1",
    )
    froude: float = setting(
        1.0, "sqrt(g h)", "commanded speed from which legs cannot follow", low=0.0, tuned=STORIES + "0.5 to 1"
    )
    turned: float = setting(
        0.3,
        "-",
        "share of the force that a log's own forces leave unexplained",
        low=0.0,
        tuned=STORIES + "0.004687 to 4.8",
    )
    returned: float = setting(
        0.3,
        "m g h",
        "energy that contact gives back in a window, from which it is soft",
        low=0.0,
        tuned=STORIES + "0.075 to 19.2",
    )
    thrown: float = setting(
        0.1,
        "-",
        "rise of what slides flat, over the height of its centre of mass, from which it was thrown up",
        low=0.0,
    )
    lifts: float = setting(
        0.08,
        "m g",
        "force that lifts or drops a body at rest, of a controller for another mass",
        low=0.0,
        tuned=STORIES + "0.05333 to 5.12",
    )
    drives: float = setting(
        0.3,
        "m g",
        "such a force along the ground, of another centre of mass",
        low=0.0,
        tuned=STORIES + "0.3 to 19.2",
    )
    biased: float = setting(
        0.15,
        "-",
        "torque asked for that no motion explains, over the largest",
        low=0.0,
        tuned=STORIES + "0.075 to 0.3",
    )
    stop_time: float = setting(
        0.15,
        "s",
        "time for which a joint pushes against its stop",
        low=0.0,
        tuned=STORIES + "0.002344 to 0.6",
    )


STORY_LIMITS = StoryLimits()
"""What stories are told by."""
