"""Settings of the behaviours, one part for each."""

from __future__ import annotations

from dataclasses import dataclass, field

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class PushRecoverySettings(Settings):
    """Catching a body that was pushed."""

    begin_error: float = setting(0.4, "sqrt(g h)", "velocity error that starts a recovery", low=0.0)
    end_error: float = setting(
        0.2,
        "sqrt(g h)",
        "velocity error below which it ends, at a speed at most twice as much above that before the push",
        low=0.0,
    )
    give: float = setting(
        0.5, "sqrt(g h)", "largest distance of the reference velocity from the body's", low=0.0,
        tuned="`surefoot bench ablation --vary PushRecoverySettings.give --factor 20 "
        "--task shoved --task shoved-back --seeds 3`, 2026-11-26: as good from 0.5 to 10",
    )  # fmt: skip
    stride: float = setting(
        0.75, "h", "way of the body over a stance from which the gait is hurried", low=0.001
    )
    quickest: float = setting(1.6, "-", "largest factor by which the gait is hurried", low=1.0)
    height: float = setting(
        0.8, "-", "height of the body over its own: feet far aside of a tall body are out of reach", low=0.1,
        high=1.0,
        tuned="`surefoot bench ablation --vary PushRecoverySettings.height --factor 20 "
        "--task shoved --seeds 3`, 2026-11-26: as good from 0.1 to 0.8",
    )  # fmt: skip
    leap_error: float = setting(
        0.7,
        "sqrt(g h)",
        "error from the commanded velocity beyond which a body leaps that was thrown aside",
        low=0.0,
    )
    aside: float = setting(
        2.0, "-", "sideways over forward error from which a body was thrown aside", low=0.0,
        tuned="`surefoot bench ablation --vary PushRecoverySettings.aside --factor 20 "
        "--task shoved-back --seeds 3`, 2026-11-26: as good from 2 to 40",
    )  # fmt: skip
    back: float = setting(
        0.3,
        "g",
        "change of the reference velocity on the way back: half of the friction that is counted on",
        low=0.0,
    )


@dataclass(frozen=True)
class SlipSettings(Settings):
    """Friction as sliding feet show it."""

    loaded: float = setting(
        0.08,
        "m g",
        "normal force from which a foot shows friction: the ratio of its forces is worth something",
        low=0.0,
    )
    sliding_speed: float = setting(
        0.07, "sqrt(g h)",
        "speed from which a foot slides: above what encoder noise makes of a foot at rest", low=0.0,
        tuned="`surefoot bench ablation --vary SlipSettings.sliding_speed --factor 20 "
        "--task ice-fast --seeds 6`, 2026-11-26: as good from 0.07 to 1.4",
    )  # fmt: skip
    filter_time: float = setting(
        0.004, "s", "time constant with which the feet's speeds are smoothed", low=1e-06,
        tuned="`surefoot bench ablation --vary SlipSettings.filter_time --factor 20 "
        "--task ice-fast --seeds 6`, 2026-11-26: as good from 0.0002 to 0.004",
    )  # fmt: skip
    memory: float = setting(5.0, "s", "time for which a slide is remembered", low=0.0)
    margin: float = setting(
        0.1, "-", "share of the friction that a slide showed which is left unused", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SlipSettings.margin --factor 20 "
        "--task ice-fast --seeds 6`, 2026-11-26: as good from 0.005 to 0.1",
    )  # fmt: skip
    least: float = setting(
        0.05, "-", "least friction that is counted on: with none, no force could be planned", low=0.001
    )
    speed: float = setting(1.7, "mu sqrt(g h)", "largest speed on slippery ground", low=0.0)
    acceleration: float = setting(
        0.1, "mu g", "largest change of the reference velocity on slippery ground", low=0.0,
        tuned="`surefoot bench ablation --vary SlipSettings.acceleration --factor 20 "
        "--task ice-fast --seeds 6`, 2026-11-26: as good from 0.1 to 2",
    )  # fmt: skip
    soon: float = setting(
        0.003, "s", "age of a slide from which the friction that its foot uses counts at once", low=0.0
    )
    hold: float = setting(0.1, "s", "time after its end for which such a slide counts", low=0.0)
    falling_time: float = setting(
        0.002, "s", "time constant with which the friction that is counted on falls", low=1e-06
    )
    rising_time: float = setting(1.0, "s", "time constant with which it rises again", low=1e-06)


@dataclass(frozen=True)
class CruiseSettings(Settings):
    """Keeping the speed to what gait and ground allow."""

    slack: float = setting(
        1.08,
        "-",
        "factor on what estimated ground allows: a command at the limit should not be slowed by noise",
        low=1.0,
    )


@dataclass(frozen=True)
class StandStillSettings(Settings):
    """Standing before the gait begins and at rest."""

    unrest: float = setting(
        0.1, "sqrt(g h)", "speed of a body that should stand from which it takes steps", low=0.0
    )


@dataclass(frozen=True)
class StairApproachSettings(Settings):
    """Coming to stairs that a sensor sees."""

    approach: float = setting(
        0.1,
        "-",
        "share of its speed with which a body comes near to steps until its gait is in step with them",
        low=0.0,
        high=1.0,
    )
    search_speed: float = setting(
        0.15, "sqrt(g h)", "largest speed of late feet over ground that has been seen", low=0.0
    )


@dataclass(frozen=True)
class StopAtDropSettings(Settings):
    """Stopping before drops that feet find."""

    lead: float = setting(
        1.8, "-", "speed of a late foot over the body's while the body falls into a drop", low=0.0
    )
    search_speed: float = setting(
        0.03, "sqrt(g h)", "speed of late feet at a drop", low=0.0,
        tuned="`surefoot bench ablation --vary StopAtDropSettings.search_speed --factor 20 "
        "--task drop --seeds 3`, 2026-11-26: as good from 0.0015 to 0.03",
    )  # fmt: skip
    shift_time: float = setting(
        0.3, "s", "time in which a standing body goes to the middle of its feet", low=0.001
    )
    fastest_shift: float = setting(0.25, "m/s", "largest speed of that", low=0.0)


@dataclass(frozen=True)
class StumbleSettings(Settings):
    """Lifting feet over what they have struck."""

    memory: float = setting(
        4.0,
        "s",
        "time for which a stumble is remembered; for half of it feet are lifted as high as right after it",
        low=0.001,
    )
    lift: float = setting(
        0.2,
        "h",
        "additional height of swings after a stumble: over a step of 6 cm for a robot of Go2's size",
        low=0.0,
    )
    highest: float = setting(
        0.25,
        "h",
        "largest additional height of swings: more takes a trot's swing more joint speed than motors have",
        low=0.0,
    )


@dataclass(frozen=True)
class BehaviourSettings(Settings):
    """Settings of all behaviours, a part for each."""

    stand_still: StandStillSettings = field(default_factory=StandStillSettings)
    push_recovery: PushRecoverySettings = field(default_factory=PushRecoverySettings)
    stop_at_drop: StopAtDropSettings = field(default_factory=StopAtDropSettings)
    slip: SlipSettings = field(default_factory=SlipSettings)
    stair_approach: StairApproachSettings = field(default_factory=StairApproachSettings)
    stumble: StumbleSettings = field(default_factory=StumbleSettings)
    cruise: CruiseSettings = field(default_factory=CruiseSettings)
