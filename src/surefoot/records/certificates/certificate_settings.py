"""Settings of certificates of motions."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting

VARIED = "python -m benchmarks.certificate_limits"


def _walk_source(name: str, range_: str) -> str:
    """Return the source of a setting that walks executed in MuJoCo decide, whole and spoilt."""
    return f"`{VARIED} {name}`, 2026-11-26: as good from {range_}"


def _people_source(name: str, range_: str) -> str:
    """Return the source of one that the errors of nine retargeted walks of LAFAN1 decide as well."""
    return f"`{VARIED} {name} --people FILE...`, 2026-11-26: with nine walks of LAFAN1 as good from {range_}"


@dataclass(frozen=True)
class CertificateSettings(Settings):
    """What counts as a contact, how long forces are averaged, and from where a frame is impossible."""

    clearance: float = setting(
        0.02, "m", "distance to the ground up to which a point may touch it", low=0.0,
        tuned=_people_source("clearance", "0.02 to 0.02"),
    )  # fmt: skip
    stand: float = setting(
        0.015, "m", "height of a motion's resting points up to which contacts are counted from there",
        low=0.0, tuned=_people_source("stand", "0.0075 to 0.0225"),
    )  # fmt: skip
    stick: float = setting(
        0.15,
        "m/s",
        "speed of a point up to which it may stick",
        low=0.0,
        tuned=_people_source("stick", "0.15 to 0.15"),
    )
    arm: float = setting(
        0.3,
        "m",
        "length by which moments are divided",
        low=1e-6,
        tuned=_walk_source("arm", "0.01875 to 0.45"),
    )
    impossible: float = setting(
        0.1,
        "m g",
        "residual from which a frame is impossible",
        low=0.0,
        tuned=_people_source("impossible", "0.1 to 0.15"),
    )
    floor: float = setting(
        0.03, "m g", "residual up to which a frame is possible, however clean its data", low=0.0,
        tuned=_walk_source("floor", "0.0004687 to 0.06"),
    )  # fmt: skip
    sigmas: float = setting(
        3.0, "-", "residual up to which it is possible, in deviations of the noise", low=0.0,
        tuned=_walk_source("sigmas", "1.5 to 6"),
    )  # fmt: skip
    window: float = setting(
        0.1,
        "s",
        "length of the window of clean data",
        low=1e-3,
        tuned=_walk_source("window", "0.001563 to 0.15"),
    )
    mean: float = setting(
        1.0 / 30.0, "s", "time over which the momentum at its ends is averaged", low=1e-4,
        tuned=_walk_source("mean", "0.0005208 to 0.06667"),
    )  # fmt: skip
    long_window: float = setting(
        0.2, "s", "length of the window of noisy data, both means included", low=1e-3,
        tuned=_walk_source("long_window", "0.2 to 0.3"),
    )  # fmt: skip
    detour: float = setting(
        0.005, "m", "detour of the centre of mass up to which forces might exist beside a frame", low=0.0,
        tuned=_people_source("detour", "0.003333 to 0.02"),
    )  # fmt: skip
    quiet: float = setting(
        0.02, "m g", "noise of the needed wrench above which windows grow", low=0.0,
        tuned=_walk_source("quiet", "0.0003125 to 0.08"),
    )  # fmt: skip
    at_stop: float = setting(
        0.03, "rad", "distance to a stop within which it may carry any torque", low=0.0,
        tuned=_walk_source("at_stop", "0.02 to 0.12"),
    )  # fmt: skip
    overspeed: float = setting(
        1.1, "-", "share of its speed limit above which a motor only brakes", low=1.0,
        tuned=_walk_source("overspeed", "1.025 to 1.65"),
    )  # fmt: skip
    least_share: float = setting(
        0.005, "-", "share of impossible frames above which a motion is", low=0.0, high=1.0,
        tuned=_walk_source("least_share", "7.813e-05 to 0.08"),
    )  # fmt: skip
