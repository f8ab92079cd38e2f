"""What can be left out of walking, and the tasks that it should help with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from benchmarks.stacks.tasks import TASKS as STACK_TASKS
from benchmarks.stacks.tasks import Task
from surefoot.base.errors import ProblemError, unknown_name

FIRST_SEED = 1000
"""First seed: those of the stacks begin at 0."""
SHORT = 5.0
"""Length of a walk over flat ground [s]."""


@dataclass(frozen=True)
class WalkTask(Task):
    """A task of the stacks, or one that they do not have.

    Attributes
    ----------
    gait
        Name of the gait; bipeds walk with their own.
    watch
        Whether the controller finds out friction.
    stops
        Whether it is enough to stay up: a robot that stops before a drop does not go on; one that has just
        reached stairs or a steep slope is slower than it should be elsewhere.
    """

    gait: str = "trot"
    watch: bool = False
    stops: bool = False


def _stack(name: str, duration: float | None = None) -> WalkTask:
    given = STACK_TASKS[name]
    values = {key: getattr(given, key) for key in given.__dataclass_fields__}
    return replace(WalkTask(**values), duration=duration or given.duration)


def _own(
    name: str, title: str, speed: float | tuple[float, float, float], duration: float, **more: Any
) -> WalkTask:
    asked = speed if isinstance(speed, tuple) else (speed, 0.0, 0.0)
    return WalkTask(name, title, asked, duration=duration, **more)


TASKS: dict[str, WalkTask] = {
    task.name: task
    for task in (
        *(_stack(f"speed-{speed}", SHORT) for speed in ("0.5", "0.8", "1", "1.4")),
        *(_stack(name) for name in ("push-left", "push-back-left", "shove-200-left")),
        *(_stack(name) for name in ("stairs-up", "stairs-down", "stairs-up-map", "stairs-down-map")),
        _stack("rough-blind", 6.0),
        _own("drop", "a drop of 11 cm, found by touch", 0.4, SHORT, terrain="pit:0.6,2,0.11",
             knowledge="blind", stops=True),
        _own("stairs-blind", "stairs of 12 cm down, found by touch", 0.4, 6.0, terrain="stairs:-0.12,0.3",
             knowledge="blind", stops=True),
        _own("even-1", "flat ground, seen, 1 m/s", 1.0, 4.0, knowledge="map"),
        _own("even-1.4", "flat ground, seen, 1.4 m/s", 1.4, 4.0, knowledge="map"),
        _own("rough-map", "rough ground of 4 cm, seen, 0.8 m/s", 0.8, SHORT, terrain="rough:1,0.04",
             knowledge="map"),
        _own("ice-found", "mu 0.2, 0.6 believed, found out", 0.5, SHORT, mu=0.2, watch=True),
        _own("stand", "standing, 100 N to the left", 0.0, 4.0, push=(0.0, 100.0), stops=True),
        _own("stand-shoved", "standing, 250 N to the left", 0.0, 4.6, push=(0.0, 250.0), stops=True),
        _own("walk-auto", "standing", 0.0, 3.0),
        _own("trot", "a short trot, 0.8 m/s", 0.8, 3.5),
        _own("pushed", "a short trot, 0.5 m/s, 150 N to the left", 0.5, 4.6, push=(0.0, 150.0)),
        _own("shoved", "a short trot, 0.5 m/s, 250 N to the back left", 0.5, 4.6, push=(-177.0, 177.0)),
        _own("shoved-aside", "a short trot, 0.5 m/s, 350 N to the left", 0.5, 4.6, push=(0.0, 350.0)),
        _own("shoved-back", "a short trot, 0.5 m/s, 300 N back", 0.5, 4.6, push=(-300.0, 0.0)),
        _own("turn", "a short trot, 0.3 m/s, turning 1.2 rad/s", (0.3, 0.1, 1.2), 3.5),
        _own("fast", "a short trot, 1.7 m/s", 1.7, 4.2),
        _own("slope", "a short trot, 15 degrees down", 0.5, 4.0, terrain="slope:-15"),
        _own("slope-up", "a short trot, 20 degrees up", 0.5, 4.0, terrain="slope:20"),
        _own("steep-down", "a short trot, 25 degrees down", 0.5, 4.0, terrain="slope:-25", stops=True),
        *(
            _own(f"steps-{name}{end}", f"six seconds of stairs of 12 cm, {name}{title}", 0.4, 6.0,
                 terrain=f"stairs:{rise},0.3", knowledge=knowledge, stops=knowledge == "map")
            for knowledge, end, title in (("exact", "", ""), ("map", "-map", ", seen"))
            for name, rise in (("up", "0.12"), ("down", "-0.12"))
        ),
        _own("steps-blind", "low steps of 6 cm up, found by touch", 0.4, 5.0, terrain="stairs:0.06,0.3",
             knowledge="blind"),
        _own("ice-fast", "mu 0.2, 0.6 believed, found out, 0.8 m/s", 0.8, 4.0, mu=0.2, watch=True),
        _own("laden", "a short trot, 5 kg off the middle", 0.5, 4.0, payload=5.0,
             payload_at=(0.1, 0.08, 0.08)),
        _own("rough", "a short trot over rough ground of 6 cm, blind", 0.5, 4.5,
             terrain="rough:1,0.06", knowledge="blind"),
        _own("gait-walk", "a short walk, 0.2 m/s", 0.2, 3.5, gait="walk"),
        _own("gait-pace", "a short pace, 0.6 m/s", 0.6, 3.5, gait="pace"),
        _own("gait-bound", "a short bound, 0.8 m/s", 0.8, 3.5, gait="bound"),
        _own("gait-flying-trot", "a short flying trot, 1 m/s", 1.0, 3.5, gait="flying_trot"),
        _own("gait-walk-fast", "a walk as fast as it gets, 0.8 m/s asked", 0.8, 4.0, gait="walk"),
        _own("gait-pace-fast", "a pace as fast as it gets, 1.5 m/s asked", 1.5, 4.0, gait="pace"),
        _own("six-tripod", "six legs by tripods, 0.4 m/s", 0.4, 3.5, robot="legged6", gait="tripod"),
        _own("six-ripple", "six legs by ripples, 0.3 m/s", 0.3, 3.5, robot="legged6", gait="ripple"),
        _own("six-wave", "six legs, one after the other, 0.2 m/s", 0.2, 4.0, robot="legged6", gait="wave"),
        _own("six-tripod-fast", "six legs by tripods, 0.9 m/s", 0.9, 3.5, robot="legged6", gait="tripod"),
        _own("six-ripple-fast", "six legs by ripples, 0.7 m/s", 0.7, 3.5, robot="legged6", gait="ripple"),
        _own("six-wave-fast", "six legs, one by one, 0.5 m/s", 0.5, 4.0, robot="legged6", gait="wave"),
        _own("auto", "a gait chosen by speed, 0.2 m/s", 0.2, 4.0, gait="auto"),
        _own("auto-fast", "a gait chosen by speed, 0.7 m/s", 0.7, 3.5, gait="auto"),
        _own("g1-step", "G1, 0.3 m/s", 0.3, 5.5, robot="g1"),
        _own("g1-pushed", "G1, 0.3 m/s, 60 N to the left", 0.3, 5.0, robot="g1", push=(0.0, 60.0)),
        _own("g1-shoved", "G1, 0.3 m/s, 150 N to the left", 0.3, 5.0, robot="g1", push=(0.0, 150.0)),
        _own("g1-thrown", "G1, 0.3 m/s, 250 N to the left", 0.3, 5.0, robot="g1", push=(0.0, 250.0)),
        _own("g1-stopped", "G1, 0.3 m/s, 200 N back", 0.3, 5.0, robot="g1", push=(-200.0, 0.0)),
        _own("g1-fast", "G1, 0.6 m/s", 0.6, 5.0, robot="g1"),
        _own("g1-laden", "G1, 0.3 m/s, 5 kg ahead of the middle", 0.3, 5.5, robot="g1", payload=5.0,
             payload_at=(0.08, 0.0, 0.15)),
        _own("g1-turning", "G1, 0.3 m/s, turning 0.3 rad/s", (0.3, 0.0, 0.3), 5.5, robot="g1"),
    )
}  # fmt: skip
"""By name."""
STAIRS = ("stairs-up", "stairs-down", "stairs-up-map", "stairs-down-map")


@dataclass(frozen=True)
class Part:
    """A behaviour or a heuristic, and what leaves it out.

    Attributes
    ----------
    name, title
        On the command line, and in tables.
    tasks
        Those that it should help with.
    without
        Name of the behaviour that is left out; empty for none.
    changes
        Settings that leave it out, by "Class.setting".
    """

    name: str
    title: str
    tasks: tuple[str, ...]
    without: str = ""
    changes: Mapping[str, Any] = field(default_factory=dict)


PARTS: dict[str, Part] = {
    part.name: part
    for part in (
        Part("push-recovery", "behaviour: push recovery",
             ("push-left", "push-back-left", "shove-200-left", "shoved"), "push recovery"),
        Part("stop-at-drop", "behaviour: stop at drop", ("drop", "stairs-blind"), "stop at drop"),
        Part("slip", "behaviour: slip", ("ice-found",), "slip"),
        Part("seen-stairs", "behaviour: seen stairs", ("stairs-up-map", "stairs-down-map"), "seen stairs"),
        Part("stumble", "behaviour: stumble", ("rough-blind",), "stumble"),
        Part("cruise", "behaviour: cruise", ("stairs-up-map", "stairs-down-map"), "cruise"),
        Part("stand-still", "behaviour: stand still", ("stand", "speed-0.5"), "stand still"),
        Part("ease", "lower swings while the body is calm", ("speed-0.8", "speed-1", "speed-1.4"),
             changes={"WalkSettings.ease": 1.0}),
        Part("unease", "swings in full after an error of the velocity",
             ("push-left", "shove-200-left", "shoved"),
             changes={"LeapSettings.calm": 10.0, "LeapSettings.uneasy": 20.0}),
        Part("brisk", "a gait hurries at brisk speeds", ("speed-0.8", "speed-1", "speed-1.4"),
             changes={"SpeedLimitSettings.brisk": 0.0}),
        Part("in-step", "in step with stairs: cycle and phase", STAIRS,
             changes={"StairGaitSettings.used": False}),
        Part("phase", "in step with stairs: phase alone", (*STAIRS, "steps-down"),
             changes={"StairPhaseSettings.used": False}),
        Part("drops", "drops found by touch", ("drop", "stairs-blind"),
             changes={"TouchedGroundSettings.finds_drops": False}),
        Part("dip", "lower body down steps", ("stairs-down", "stairs-down-map"),
             changes={"BodyMotionSettings.dip": 0.0}),
        Part("even", "even swings over learned ground", ("even-1", "even-1.4", "rough-map"),
             changes={"FeetSettings.fast": 1e9}),
    )
}  # fmt: skip
"""By name."""

CLASS_TASKS: dict[str, tuple[str, ...]] = {
    "PushRecoverySettings": ("push-left", "shove-200-left"),
    "LeapSettings": ("push-left", "shove-200-left"),
    "SlipSettings": ("ice-found",),
    "StopAtDropSettings": ("drop", "stairs-blind"),
    "TouchedGroundSettings": ("drop", "stairs-blind"),
    "StairApproachSettings": ("stairs-up-map", "stairs-down-map"),
    "StairGaitSettings": STAIRS,
    "StairPhaseSettings": STAIRS,
    "StumbleSettings": ("rough-blind",),
    "TouchdownSettings": ("rough-blind", "rough-map"),
    "FootholdSettings": ("stairs-down", "rough-map"),
}
"""Tasks that settings of a class are varied over."""
USUAL_TASKS = ("speed-0.5", "speed-1", "push-left")
"""Tasks that all other settings are varied over."""


def choose_parts(names: Sequence[str] | None) -> tuple[Part, ...]:
    """Return the named parts, or all.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    for name in names or ():
        if name not in PARTS:
            raise ProblemError(unknown_name("part of walking", name, tuple(PARTS)))
    return tuple(PARTS[name] for name in names or PARTS)
