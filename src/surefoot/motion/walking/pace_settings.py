"""Settings of gait and speed: limits, choice, leaps, stairs."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class SpeedLimitSettings(Settings):
    """Shares of joint limits that a gait may use, how it hurries, and speeds on slopes and stairs."""

    timing_speed: float = setting(
        0.85, "-", "share of the joints' speed limits that a gait's timing is chosen for", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.timing_speed --factor 20 "
        "--task trot --seeds 3`, 2026-11-26: as good from 0.85 to 1",
    )  # fmt: skip
    most_speed: float = setting(
        0.9, "-", "share of the joints' speed limits that a command may need", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.most_speed --factor 20 "
        "--task fast --seeds 6`, 2026-11-25: as good from 0.9 to 1",
    )  # fmt: skip
    most_torque: float = setting(
        1.0, "-", "share of the joints' torque limits that a stance may need", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.most_torque --factor 20 "
        "--task fast --seeds 6`, 2026-11-25: as good from 1 to 1",
    )  # fmt: skip
    force_factor: float = setting(
        1.1, "-", "force of a foot in the middle of its stance over its mean", low=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.force_factor --factor 20 "
        "--task fast --seeds 6`, 2026-11-26: as good from 1 to 1.1",
    )  # fmt: skip
    slope_speed: float = setting(
        0.75, "sqrt(g h)", "speed at which walking doubles the share of friction that a slope needs", low=0.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.slope_speed --factor 20 "
        "--task slope-up --seeds 6`, 2026-11-26: as good from 0.75 to 15",
    )  # fmt: skip
    steep_stairs: float = setting(
        0.5, "-", "rise over tread of stairs up to which only the rise bounds the speed", low=0.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.steep_stairs --factor 20 "
        "--task steps-up --seeds 6`, 2026-11-26: as good from 0.5 to 0.5",
    )  # fmt: skip
    steepest_stairs: float = setting(
        0.53, "-", "rise over tread of stairs beyond which nothing is tried", low=0.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.steepest_stairs --factor 20 "
        "--task steps-up --seeds 6`, 2026-11-26: as good from 0.53 to 10.6",
    )  # fmt: skip
    step_speed: float = setting(
        0.142, "sqrt(g h)",
        "speed at which steps of the body's height are taken; it grows with the root of height over rise",
        low=0.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.step_speed --factor 20 "
        "--task steps-up --seeds 6`, 2026-11-26: as good from 0.142 to 2.84",
    )  # fmt: skip
    hurried_period: float = setting(
        0.7, "-", "period of a gait in the greatest hurry over its own", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.hurried_period --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.7 to 0.7",
    )  # fmt: skip
    hurried_duty: float = setting(
        0.36, "-", "share of the period that feet of a gait in the greatest hurry carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.hurried_duty --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.36 to 0.36",
    )  # fmt: skip
    hurried_clearance: float = setting(
        0.4, "-", "height of the swings of a gait in the greatest hurry over its own", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.hurried_clearance --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.02 to 0.4",
    )  # fmt: skip
    brisk: float = setting(
        0.26, "-", "hurry of a gait at brisk speeds on a plane, whatever joints can do", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.brisk --factor 20 "
        "--task speed-1 --seeds 3`, 2026-11-26: as good from 0.26 to 0.26; "
        "without it (`--only brisk`) 18 % more work at 1 m/s; twice as much takes still less there",
    )  # fmt: skip
    brisk_from: float = setting(
        0.35, "sqrt(g h)", "speed up to which a gait does not hurry beyond what joints need", low=0.0
    )
    brisk_to: float = setting(
        0.55, "sqrt(g h)", "speed from which a gait hurries by `brisk`", low=0.0,
        tuned="`surefoot bench ablation --vary SpeedLimitSettings.brisk_to --factor 20 "
        "--task speed-1 --seeds 3`, 2026-11-26: as good from 0.0275 to 0.55; "
        "a twentieth takes less work on `trot`",
    )  # fmt: skip
    stance_ends: float = setting(
        0.7,
        "-",
        "share by which the force of a foot is lower at the ends of its stance than in the middle",
        low=0.0,
        high=1.0,
    )


SPEED_LIMITS = SpeedLimitSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class GaitChoiceSettings(Settings):
    """When `auto` walks, and how long feet of a hurried gait carry at least."""

    walks_below: float = setting(
        0.12, "sqrt(g h)", "speed up to which `auto` walks; it trots above", low=0.0,
        tuned="`surefoot bench ablation --vary GaitChoiceSettings.walks_below --factor 20 "
        "--task auto-fast --seeds 3`, 2026-11-26: as good from 0.006 to 0.12",
    )  # fmt: skip
    hysteresis: float = setting(
        0.15, "-", "share by which that speed must be passed before the gait changes", low=0.0, high=1.0
    )
    walk_least_duty: float = setting(
        0.5, "-", "share that feet of a walk carry in the greatest hurry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation "
        "--vary GaitChoiceSettings.walk_least_duty --value 0.4 --value 0.6 --value 0.75 "
        "--task gait-walk-fast --seeds 3`, 2026-11-27: as good from 0.4 to 0.6",
    )  # fmt: skip
    pace_least_duty: float = setting(
        0.5, "-", "share that feet carry in the greatest hurry of a pace", low=0.0, high=1.0
    )
    tripod_least_duty: float = setting(
        0.5, "-", "share that feet carry in the greatest hurry of a tripod gait", low=0.0, high=1.0
    )
    ripple_least_duty: float = setting(
        0.6, "-", "share that feet carry in the greatest hurry of a ripple gait", low=0.0, high=1.0
    )
    wave_least_duty: float = setting(
        0.75, "-", "share that feet carry in the greatest hurry of a wave gait", low=0.0, high=1.0,
        tuned="`surefoot bench ablation "
        "--vary GaitChoiceSettings.wave_least_duty --value 0.6 --value 0.7 --value 0.8 "
        "--task six-wave-fast --seeds 3`, 2026-11-27: as good from 0.75 to 0.75",
    )  # fmt: skip


GAIT_CHOICE = GaitChoiceSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class LeapSettings(Settings):
    """Timing of leaps, and how calm a body is."""

    air_time: float = setting(0.5, "sqrt(h / g)", "time in the air of a body that leaps", low=0.0)
    ground_time: float = setting(0.44, "sqrt(h / g)", "time on the ground between two leaps", low=0.0)
    calm: float = setting(
        0.06, "sqrt(g h)", "error of the velocity up to which a body moves as planned", low=0.0,
        tuned="`surefoot bench ablation --vary LeapSettings.calm --factor 20 "
        "--task trot --seeds 3`, 2026-11-26: as good from 0.06 to 0.06",
    )  # fmt: skip
    uneasy: float = setting(
        0.15, "sqrt(g h)", "error of the velocity from which feet are lifted in full", low=0.0,
        tuned="`surefoot bench ablation --vary LeapSettings.uneasy --factor 20 "
        "--task trot --seeds 3`, 2026-11-26: as good from 0.15 to 3",
    )  # fmt: skip
    unease_time: float = setting(
        1.0, "s", "time in which swings come down again after such an error", low=1e-06
    )


LEAPING = LeapSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class StairGaitSettings(Settings):
    """The trot in step with stairs."""

    used: bool = setting(
        True,
        "-",
        "whether a trot gets in step with stairs",
        tuned="`surefoot bench ablation --only in-step`, 2026-11-25: "
        "without it stairs take 15 to 57 % more work, and land 35 to 72 % harder",
    )
    duty: float = setting(
        0.6, "-", "share of the cycle that each foot carries", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary StairGaitSettings.duty --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.6 to 0.6",
    )  # fmt: skip
    longest_cycle: float = setting(
        2.2, "-", "longest cycle over the trot's own; slower bodies take more strides for a tread", low=1.0,
        tuned="`surefoot bench ablation --vary StairGaitSettings.longest_cycle --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 2.2 to 44",
    )  # fmt: skip
    longest_stride: float = setting(
        1.2, "h", "longest stride up or down steps", low=0.0,
        tuned="`surefoot bench ablation --vary StairGaitSettings.longest_stride --factor 20 "
        "--task steps-down --seeds 6`, 2026-11-26: as good from 1.2 to 24",
    )  # fmt: skip
    single: tuple[float, float] = setting(
        (1.1, 1.15), "-",
        "shortest cycle over the trot's where a tread takes one stride, and growth with rise over h",
        tuned="`surefoot bench ablation --vary StairGaitSettings.single --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.055, 0.0575 to 1.1, 1.15",
    )  # fmt: skip
    several: tuple[float, float] = setting(
        (-0.2, 5.5), "-", "shortest cycle over the trot's where a tread takes several strides, and its growth"
    )


STAIR_GAIT = StairGaitSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class StairPhaseSettings(Settings):
    """How a body takes up its phase over stairs."""

    used: bool = setting(
        True, "-", "whether a body takes up its phase over stairs",
        tuned="`surefoot bench ablation --only phase`, 2026-11-25: without it feet land with 7.5 in place of "
        "2.4 m g down known stairs",
    )  # fmt: skip
    strides: int = setting(3, "-", "strides looked ahead beyond the next one where stairs are known", low=0)
    strides_mapped: int = setting(
        6,
        "-",
        "strides looked ahead beyond the next one on stairs that come into view one after the other",
        low=0,
    )
    pace_time: float = setting(
        0.75, "s", "time in which the body takes up its place", low=1e-06,
        tuned="`surefoot bench ablation --vary StairPhaseSettings.pace_time --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.0375 to 0.75",
    )  # fmt: skip
    most_change: float = setting(
        0.15, "-", "largest share of the body's speed that taking up its place may cost", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary StairPhaseSettings.most_change --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.15 to 1",
    )  # fmt: skip
    in_step: float = setting(
        0.1,
        "-",
        "distance of a stride from the tread, as a share of the stride, from which it is out of step",
        low=0.0,
        high=1.0,
    )
    set_off: float = setting(
        0.01, "m", "distance of the feet from their best places at which a waiting body sets off", low=0.0
    )
    longest_wait: float = setting(
        1.2, "cycles", "time after which a waiting body sets off whatever its phase", low=0.0
    )
    last_tread: float = setting(
        0.2, "-", "share of the tread beyond the last detected edge that is looked at", low=0.0, high=1.0
    )
    move_cost: float = setting(0.05, "-", "cost of a move of the body over that of a foot", low=0.0)
    change_cost: float = setting(
        1.0, "-", "cost of a change of the best place over that of a move of a foot", low=0.0
    )


STAIR_PHASE = StairPhaseSettings()
"""The values in use; compiled code folds them when it is compiled."""
