"""Settings of certificates of motions."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting

PROTOTYPE = "of a prototype on 42 executed motions, whose figures issue 60 has"


@dataclass(frozen=True)
class CertificateSettings(Settings):
    """What counts as a contact, how long forces are averaged, and from where a frame is impossible."""

    clearance: float = setting(0.02, "m", "distance to the ground up to which a point may touch it", low=0.0)
    stand: float = setting(
        0.015,
        "m",
        "height of the resting points of a whole motion up to which contacts are counted from there",
        low=0.0,
    )
    stick: float = setting(0.15, "m/s", "speed of a point up to which it may stick", low=0.0)
    arm: float = setting(0.3, "m", "length by which moments are divided", low=1e-6)
    impossible: float = setting(0.1, "m g", "residual from which a frame is impossible", low=0.0)
    floor: float = setting(
        0.03, "m g", "residual up to which a frame is possible, however clean its data", low=0.0
    )
    sigmas: float = setting(
        3.0, "-", "residual up to which it is possible, in deviations of the noise", low=0.0
    )
    window: float = setting(0.1, "s", "length of the window of clean data", low=1e-3)
    mean: float = setting(1.0 / 30.0, "s", "time over which the momentum at its ends is averaged", low=1e-4)
    long_window: float = setting(
        0.2, "s", "length of the window of noisy data, both means included", low=1e-3
    )
    detour: float = setting(
        0.005, "m", "detour of the centre of mass up to which forces might exist beside a frame", low=0.0
    )
    quiet: float = setting(0.02, "m g", "noise of the needed wrench above which windows grow", low=0.0)
    at_stop: float = setting(0.03, "rad", "distance to a stop within which it may carry any torque", low=0.0)
    overspeed: float = setting(1.1, "-", "share of its speed limit above which a motor only brakes", low=1.0)
    least_share: float = setting(
        0.005, "-", "share of impossible frames above which a motion is", low=0.0, high=1.0
    )
