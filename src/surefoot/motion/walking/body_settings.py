"""Settings of the body of a walk: reference pose and load."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class BodyMotionSettings(Settings):
    """How the reference pose of the body follows command and ground."""

    lead_time: float = setting(
        0.05, "s", "lead of the reference place over the larger of sqrt(g h) and the reference speed",
        low=0.0,
        tuned="`surefoot bench ablation --vary BodyMotionSettings.lead_time --factor 20 "
        "--task rough --seeds 6`, 2026-11-26: as good from 0.05 to 1",
    )  # fmt: skip
    ground_time: float = setting(
        0.12, "s", "time constant with which the slope under the feet is followed", low=1e-06
    )
    flattening: float = setting(
        0.0001, "m²", "pull of that slope to zero where the places of the feet do not determine it", low=0.0
    )
    dip: float = setting(
        0.25, "-", "how much lower the body goes down steps, per unit of slope, on ground that is no plane",
        low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary BodyMotionSettings.dip --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.25 to 1",
    )  # fmt: skip
    lowering_time: float = setting(
        0.3, "s", "time constant with which the body comes down to the height that suits a slope", low=1e-06,
        tuned="`surefoot bench ablation --vary BodyMotionSettings.lowering_time --factor 20 "
        "--task steps-down --seeds 3`, 2026-11-26: as good from 0.015 to 0.3",
    )  # fmt: skip
    acceleration: float = setting(
        0.12, "g", "largest change of the reference velocity", low=0.0,
        tuned="`surefoot bench ablation --vary BodyMotionSettings.acceleration --factor 20 "
        "--task fast --seeds 6`, 2026-11-25: as good from 0.12 to 0.12",
    )  # fmt: skip
    steepest_pitch: float = setting(0.4, "rad", "largest pitch that may be commanded", low=0.0, high=1.5)
    lowest: float = setting(0.4, "h", "farthest that a body may go below its usual height", low=0.0, high=1.0)
    highest: float = setting(
        0.08, "h", "farthest that a body may go above its usual height", low=0.0, high=1.0
    )
    crouch_rate: float = setting(0.4, "h/s", "rate at which a commanded height is taken", low=0.0)
    pitch_rate: float = setting(0.5, "rad/s", "rate at which a commanded pitch is taken", low=0.0)
    long_stance: float = setting(
        2.5, "sqrt(h / g)",
        "stance from which the reference velocity changes more slowly, since feet stay behind", low=0.0,
        tuned="`surefoot bench ablation --vary BodyMotionSettings.long_stance --factor 20 "
        "--task fast --seeds 6`, 2026-11-25: as good from 2.5 to 50",
    )  # fmt: skip
    landed: float = setting(
        0.001,
        "s",
        "time of its ramp that a foot has used when it touches: it may push at once, if little",
        low=0.0,
    )


BODY_MOTION = BodyMotionSettings()
"""The values in use; compiled code folds them when it is compiled."""


@dataclass(frozen=True)
class LoadSettings(Settings):
    """How far the estimated external wrench is trusted."""

    most: float = setting(
        0.1,
        "m g; m g h",
        "largest external force and moment along an axis that controllers count on: feet slip with more",
        low=0.0,
    )
    lean: float = setting(
        0.8,
        "rad",
        "lean of the base beyond which the load observer stands still, since the robot falls",
        low=0.0,
    )


LOAD = LoadSettings()
"""The values in use; compiled code folds them when it is compiled."""
