"""Settings of gaits."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class GaitChangeSettings(Settings):
    """How fast timing and pattern of a gait may change."""

    stance_step: float = setting(
        1.35, "-", "largest factor between times on the ground of one cycle and the next", low=1.0,
        tuned="`surefoot bench ablation --vary GaitChangeSettings.stance_step --factor 20 "
        "--task fast --seeds 6`, 2026-11-26: as good from 1.35 to 27",
    )  # fmt: skip
    air_step: float = setting(
        1.15, "-", "largest factor between times in the air of one cycle and the next", low=1.0,
        tuned="`surefoot bench ablation --vary GaitChangeSettings.air_step --factor 20 "
        "--task fast --seeds 3`, 2026-11-26: as good from 1.15 to 23",
    )  # fmt: skip
    offset_step: float = setting(
        0.07,
        "-",
        "largest change of a foot's offset between cycles, as a share of the period",
        low=0.0,
        high=1.0,
    )
    slow_offset_step: float = setting(
        0.02,
        "-",
        "that change into step with the ground and out of it, where stances are short",
        low=0.0,
        high=1.0,
    )
    nearly: float = setting(
        0.08,
        "-",
        "distance of a cycle's period from that of steps, as a share, up to which it is in step with them",
        low=0.0,
        high=1.0,
    )
    unfit: float = setting(
        1.1, "-",
        "time that feet carry over the one wanted at a speed from which a cycle is not fit for the speed",
        low=1.0,
        tuned="`surefoot bench ablation --vary GaitChangeSettings.unfit --factor 20 "
        "--task fast --seeds 3`, 2026-11-26: as good from 1.1 to 22",
    )  # fmt: skip
    first_lift: float = setting(
        0.02, "s", "least time before a foot at rest lifts after a walk is commanded again", low=0.0
    )
    earlier: float = setting(
        0.25,
        "-",
        "share of a cycle by which feet that would lift earlier than the first wait for the next cycle",
        low=0.0,
        high=1.0,
    )
    least_air: float = setting(
        0.95, "-", "least time in the air between two cycles over that of the later one", low=0.0, high=1.0
    )


GAIT_CHANGE = GaitChangeSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class GaitTimings(Settings):
    """Period for a leg of 0.3 m, and share of it that each foot carries, of the named gaits."""

    trot_period: float = setting(
        0.40,
        "s",
        "period of a trot",
        low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.trot_period "
        "--value 0.3 --value 0.5 --task speed-1 --seeds 3`, "
        "2026-11-25: as good from 0.4 to 0.4",
    )
    trot_duty: float = setting(
        0.55,
        "-",
        "share that feet of a trot carry",
        low=0.0,
        high=1.0,
        tuned="`surefoot bench ablation --vary GaitTimings.trot_duty "
        "--value 0.45 --value 0.65 --task speed-1 --seeds 3`, "
        "2026-11-25: as good from 0.55 to 0.55",
    )
    walk_period: float = setting(
        0.80, "s", "period of a walk on four feet", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.walk_period --factor 20 "
        "--task gait-walk --seeds 6`, 2026-11-25: as good from 0.8 to 0.8",
    )  # fmt: skip
    walk_duty: float = setting(
        0.78, "-", "share that feet of a walk on four carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary GaitTimings.walk_duty --factor 20 "
        "--task gait-walk --seeds 6`, 2026-11-25: as good from 0.78 to 0.78",
    )  # fmt: skip
    pace_period: float = setting(
        0.36, "s", "period of a pace", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.pace_period --factor 20 "
        "--task gait-pace --seeds 6`, 2026-11-25: as good from 0.36 to 0.36",
    )  # fmt: skip
    pace_duty: float = setting(
        0.60, "-", "share that feet of a pace carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary GaitTimings.pace_duty --factor 20 "
        "--task gait-pace --seeds 6`, 2026-11-25: as good from 0.6 to 0.6",
    )  # fmt: skip
    bound_period: float = setting(
        0.34, "s", "period of a bound", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.bound_period --factor 20 "
        "--task gait-bound --seeds 6`, 2026-11-25: as good from 0.34 to 0.34",
    )  # fmt: skip
    bound_duty: float = setting(
        0.55, "-", "share that feet of a bound carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary GaitTimings.bound_duty --factor 20 "
        "--task gait-bound --seeds 6`, 2026-11-25: as good from 0.55 to 0.55",
    )  # fmt: skip
    flying_trot_period: float = setting(
        0.34, "s", "period of a flying trot", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.flying_trot_period --factor 20 "
        "--task gait-flying-trot --seeds 6`, 2026-11-25: as good from 0.34 to 0.34",
    )  # fmt: skip
    flying_trot_duty: float = setting(
        0.44, "-", "share that feet of a flying trot carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary GaitTimings.flying_trot_duty --factor 20 "
        "--task gait-flying-trot --seeds 6`, 2026-11-25: as good from 0.44 to 0.44",
    )  # fmt: skip
    two_feet_period: float = setting(0.70, "s", "period of a walk on two feet", low=1e-3)
    two_feet_duty: float = setting(0.60, "-", "share that feet of a walk on two carry", low=0.0, high=1.0)
    tripod_period: float = setting(
        0.45, "s", "period of a tripod gait", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.tripod_period --factor 1.6 --factor 2.5 "
        "--task six-tripod --seeds 3`, 2026-11-27: as good from 0.45 to 0.45",
    )  # fmt: skip
    tripod_duty: float = setting(
        0.5, "-", "share that feet of a tripod gait carry", low=0.0, high=1.0,
        tuned="`surefoot bench ablation "
        "--vary GaitTimings.tripod_duty --value 0.45 --value 0.55 --value 0.6 --value 0.75 "
        "--task six-tripod --seeds 3`, 2026-11-27: as good from 0.5 to 0.5",
    )  # fmt: skip
    swing_time: float = setting(
        0.17, "s", "time of a foot in the air in a wave and a ripple gait", low=1e-3,
        tuned="`surefoot bench ablation --vary GaitTimings.swing_time --factor 1.7 --factor 3 "
        "--task six-ripple --task six-wave --seeds 3`, 2026-11-27: as good from 0.17 to 0.17",
    )  # fmt: skip
    beside: float = setting(
        0.2, "-", "share of the half width nearer than which to the middle a foot is of neither side",
        low=0.0, high=1.0,
    )  # fmt: skip


GAITS = GaitTimings()
"""The values in use."""
