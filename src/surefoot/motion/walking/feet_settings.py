"""Settings of the feet of a walk: swing, foothold, touchdown."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.loaded import DEBOUNCE
from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class SwingSettings(Settings):
    """Shape of the path of a foot through the air, in shares of the swing."""

    rise: float = setting(
        0.45, "-", "share of the swing after which the foot is at its highest", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SwingSettings.rise --factor 20 "
        "--task steps-down --seeds 6`, 2026-11-26: as good from 0.0225 to 0.45",
    )  # fmt: skip
    down: float = setting(
        0.95, "-", "share of the swing after which the foot only sinks, at its speed of touchdown", low=0.0,
        high=1.0,
        tuned="`surefoot bench ablation --vary SwingSettings.down --factor 20 "
        "--task fast --seeds 6`, 2026-11-26: as good from 0.95 to 1; "
        "1 takes less work on `steps-down`",
    )  # fmt: skip
    lift_first: float = setting(
        0.08,
        "-",
        "share of the swing before which the foot does not move sideways, so that it lifts first",
        low=0.0,
        high=1.0,
    )
    straight_from: float = setting(
        0.92, "-",
        "share of the swing after which the foot does not move sideways, so that it lands straight", low=0.0,
        high=1.0,
        tuned="`surefoot bench ablation --vary SwingSettings.straight_from --factor 20 "
        "--task steps-down --seeds 6`, 2026-11-26: as good from 0.92 to 1",
    )  # fmt: skip
    ramp: float = setting(
        0.15, "-",
        "share of the swing over which the acceleration along even ground rises from zero, and falls to it",
        low=1e-06, high=0.5,
        tuned="`surefoot bench ablation --vary SwingSettings.ramp --factor 20 "
        "--task trot --seeds 3`, 2026-11-25: as good from 0.15 to 0.15",
    )  # fmt: skip
    land: float = setting(
        0.9, "-", "share of the swing after which the foot does not move along even ground any more",
        low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SwingSettings.land --factor 20 "
        "--task trot --seeds 6`, 2026-11-25: as good from 0.9 to 0.9",
    )  # fmt: skip


SWING_PATH = SwingSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class FootPhaseSettings(Settings):
    """When a foot in the air has landed, and what a foot does that has struck an edge."""

    early: float = setting(
        0.6, "-",
        "share of its swing after which a foot that touches has landed early; before, it brushes the ground",
        low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary FootPhaseSettings.early --factor 20 "
        "--task rough --seeds 3`, 2026-11-26: as good from 0.03 to 0.6",
    )  # fmt: skip
    release_time: float = setting(
        DEBOUNCE,
        "s",
        "time without touch after which a foot in stance has lost the ground and searches for it",
        low=0.0,
    )
    retry: float = setting(
        0.7,
        "-",
        "least time for the rest of a restarted swing, as a share of the whole swing's",
        low=0.0,
        high=1.0,
    )


FOOT_PHASES = FootPhaseSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class FootholdSettings(Settings):
    """Distances that feet keep from edges, and how far they reach to catch a body."""

    shin: float = setting(
        0.13, "m", "distance that a descending foot keeps from the edge behind it, which the shin leans over",
        low=0.0,
        tuned="`surefoot bench ablation --vary FootholdSettings.shin --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.13 to 0.13",
    )  # fmt: skip
    low_step: float = setting(
        0.03, "m", "height difference from which ground is a step", low=0.0,
        tuned="`surefoot bench ablation --vary FootholdSettings.low_step --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.0015 to 0.03",
    )  # fmt: skip
    unsure: float = setting(
        0.01, "m", "additional distance to edges where their places are estimated", low=0.0,
        tuned="`surefoot bench ablation --vary FootholdSettings.unsure --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.0005 to 0.01",
    )  # fmt: skip
    farthest: float = setting(
        0.15, "m", "farthest that a foot is moved for an edge", low=0.0,
        tuned="`surefoot bench ablation --vary FootholdSettings.farthest --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.15 to 3",
    )  # fmt: skip
    catch_reach: float = setting(0.8, "h", "farthest from its place that a foot catches a body", low=0.0)
    catch_aside: float = setting(
        0.35,
        "-",
        "least distance of a catching foot from the body's middle over its usual distance",
        low=0.0,
        high=1.0,
    )
    edge_weight: float = setting(
        3.0, "-", "cost of a height difference within the margin to edges over that of the distance", low=0.0
    )
    tilt_weight: float = setting(0.05, "m", "cost of the ground's slope over that of the distance", low=0.0)


FOOTHOLDS = FootholdSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class FeetSettings(Settings):
    """When footholds freeze, how feet come down, and how swings over learned ground differ."""

    freeze: float = setting(
        0.75, "-", "share of the swing after which the foothold stays where it is", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary FeetSettings.freeze --factor 20 "
        "--task shoved --seeds 3`, 2026-11-26: as good from 0.75 to 1",
    )  # fmt: skip
    freeze_rough: float = setting(
        0.4, "-",
        "share of the swing after which the foothold changes ever less where the path must clear edges",
        low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary FeetSettings.freeze_rough --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.4 to 1",
    )  # fmt: skip
    least_clearance: float = setting(
        0.3, "-", "least height of a swing over the usual one, whatever is commanded", low=0.0, high=1.0
    )
    descent: float = setting(
        0.12, "sqrt(g h)", "speed towards the ground at touchdown", low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.descent --factor 20 "
        "--task trot --seeds 3`, 2026-11-25: as good from 0.006 to 0.12",
    )  # fmt: skip
    search: float = setting(
        0.3, "g", "acceleration with which a late foot goes down on known ground", low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.search --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.015 to 0.3",
    )  # fmt: skip
    search_fast: float = setting(
        0.8, "g", "acceleration with which a late foot goes down on unknown ground", low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.search_fast --factor 20 "
        "--task rough --seeds 3`, 2026-11-25: as good from 0.04 to 0.8",
    )  # fmt: skip
    search_speed: float = setting(
        0.4, "sqrt(g h)", "largest speed of a late foot on unknown ground", low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.search_speed --factor 20 "
        "--task drop --seeds 3`, 2026-11-26: as good from 0.02 to 0.4",
    )  # fmt: skip
    same_tread: float = setting(
        2.0,
        "radii",
        "how much farther than the nearest tread the one next to the last may be in step with stairs",
        low=0.0,
    )
    chosen: float = setting(
        0.1, "-", "share of the swing after which a foot keeps to the tread that it is on its way to",
        low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.chosen --factor 20 "
        "--task steps-up --seeds 3`, 2026-11-26: as good from 0.1 to 2",
    )  # fmt: skip
    fast: float = setting(
        0.7, "sqrt(g h)",
        "speed of a swing plus its slope from which it is one over even ground where that is learned",
        low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.fast --factor 20 "
        "--task rough-map --seeds 3`, 2026-11-26: as good from 0.035 to 0.7; "
        "without such swings (`--only even`) a trot takes 53 to 64 % more work",
    )  # fmt: skip
    even: float = setting(
        0.5, "radii", "deviation of learned ground from a line, beyond its noise, up to which it is even",
        low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.even --factor 20 "
        "--task rough-map --seeds 3`, 2026-11-26: as good from 0.5 to 10",
    )  # fmt: skip
    even_until: float = setting(
        0.05, "-", "share of the swing up to which it is decided whether it goes over even ground", low=0.0,
        high=1.0,
        tuned="`surefoot bench ablation --vary FeetSettings.even_until --factor 20 "
        "--task rough --seeds 3`, 2026-11-25: as good from 0.05 to 1",
    )  # fmt: skip
    down_noisy: float = setting(
        0.85, "-", "share of the swing after which a foot only sinks on noisy ground", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary FeetSettings.down_noisy --factor 20 "
        "--task rough-map --seeds 6`, 2026-11-26: as good from 0.85 to 1",
    )  # fmt: skip
    noisy: float = setting(0.012, "m", "noise of the ground at which that share applies", low=1e-09)
    raised: float = setting(
        0.7, "-",
        "how much higher than estimated the ground is taken for, over its noise, so that it is met gently",
        low=0.0,
        tuned="`surefoot bench ablation --vary FeetSettings.raised --factor 20 "
        "--task rough-map --seeds 3`, 2026-11-26: as good from 0.7 to 14; "
        "3 of 3 fall with 14, which may be chance",
    )  # fmt: skip


FEET = FeetSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class TouchdownSettings(Settings):
    """When a touch is a touchdown, and how long the gait waits for one."""

    longest_wait: float = setting(
        1.5, "sqrt(h / g)", "longest time that the gait waits for a foot", low=0.0,
        tuned="`surefoot bench ablation --vary TouchdownSettings.longest_wait --factor 20 "
        "--task rough --seeds 3`, 2026-11-26: as good from 1.5 to 30",
    )  # fmt: skip
    careful_wait: float = setting(
        3.0, "sqrt(h / g)", "longest time that the gait waits for a foot at a drop", low=0.0,
        tuned="`surefoot bench ablation --vary TouchdownSettings.careful_wait --factor 20 "
        "--task drop --seeds 3`, 2026-11-26: as good from 3 to 60",
    )  # fmt: skip
    slowing: float = setting(
        1.3, "g", "deceleration of late feet that should go on more slowly", low=0.0,
        tuned="`surefoot bench ablation --vary TouchdownSettings.slowing --factor 20 "
        "--task drop --seeds 6`, 2026-11-26: as good from 1.3 to 1.3",
    )  # fmt: skip
    at_once: float = setting(
        3.0,
        "steps",
        "steps of the controller within which a foot that is about to lift counts as lifting",
        low=0.0,
    )
    lead_time: float = setting(
        0.03, "s", "time in which late feet gain the body's speed", low=1e-06,
        tuned="`surefoot bench ablation --vary TouchdownSettings.lead_time --factor 20 "
        "--task drop --seeds 3`, 2026-11-26: as good from 0.03 to 0.6",
    )  # fmt: skip
    struck: float = setting(
        0.1, "m g", "force against its motion from which a foot has struck something", low=0.0,
        tuned="`surefoot bench ablation --vary TouchdownSettings.struck --factor 20 "
        "--task rough --seeds 3`, 2026-11-26: as good from 0.1 to 2",
    )  # fmt: skip
    steep: float = setting(
        1.0, "-", "sideways force over the normal one from which a touch is an edge, no ground", low=0.0
    )
    sensed: float = setting(
        0.06, "m g",
        "normal force below which a foot in the air has not landed: a braked leg seems to feel some", low=0.0,
        tuned="`surefoot bench ablation --vary TouchdownSettings.sensed --factor 20 "
        "--task rough --seeds 6`, 2026-11-26: as good from 0.003 to 0.06",
    )  # fmt: skip
    stopped: float = setting(
        0.5,
        "-",
        "share of the reference speed below which a foot that is pushed back has struck something",
        low=0.0,
        high=1.0,
    )
    strikes_from: float = setting(
        0.15,
        "-",
        "share of its swing from which a foot can strike something: lift-off drags",
        low=0.0,
        high=1.0,
    )
    strikes_until: float = setting(
        1.0, "-", "share of its swing up to which a foot can strike something", low=0.0
    )
    lasting: float = setting(
        0.02, "s", "time that a force must last which is measured above the map", low=0.0
    )
    lasting_far: float = setting(
        0.1, "s", "time that a force must last which is measured far above the map", low=0.0
    )
    far: float = setting(
        3.0, "-", "height over the map, in standard deviations, from which `lasting_far` applies", low=0.0
    )
    young: float = setting(
        0.04, "s", "time after a touchdown within which it may be found to be false", low=0.0
    )
    silent: float = setting(0.008, "s", "time without touch after which such a touchdown is false", low=0.0)


TOUCHDOWN = TouchdownSettings()
"""The values in use; compiled code folds them when it is compiled."""
