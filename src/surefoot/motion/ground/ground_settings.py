"""Settings of ground that feet find."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting

FITTED = "`python -m benchmarks.learnt_ground StairFitSettings`, 2026-11-26: as good from "
FELT = "`python -m benchmarks.learnt_ground GroundEstimateSettings`, 2026-11-26: as good from "
DETECTED = "`python -m benchmarks.learnt_ground StairDetectionSettings`, 2026-11-26: as good from "
"""How sources begin: other values are tried over what walks have sensed, and those beyond do worse."""


@dataclass(frozen=True)
class TouchedGroundSettings(Settings):
    """Drops that feet find by touch; lengths in heights h of the centre of mass."""

    finds_drops: bool = setting(
        True,
        "-",
        "whether a foot that finds no ground has found a drop",
        tuned="`surefoot bench ablation --only drops`, 2026-11-25: "
        "without it 0 of 6 stay up on stairs down, with it 6",
    )
    drop: float = setting(
        0.29, "h", "depth from which a drop is not taken by touch alone", low=0.0,
        tuned="`surefoot bench ablation --vary TouchedGroundSettings.drop --factor 20 "
        "--task drop --seeds 3`, 2026-11-26: as good from 0.0145 to 0.29",
    )  # fmt: skip
    bottomless: float = setting(0.5, "h", "depth below which no ground is looked for", low=0.0)
    sure_tread: float = setting(
        0.75, "h", "length for which ground beyond a drop is taken for level", low=0.0
    )
    like: float = setting(
        0.5, "-", "distance of a stand from either level, as a share of the depth, up to which it is on it",
        low=0.0, high=1.0,
    )  # fmt: skip
    reach: float = setting(
        0.1, "m", "least distance from the edge of feet beyond it: shins lean back over it", low=0.0
    )
    unmoved: float = setting(
        0.1, "m/s", "speed below which a body does not show which way a drop lies", low=0.0
    )
    noise: float = setting(0.02, "m", "noise of the height of the ground about a drop", low=0.0)
    steep_tread: float = setting(0.9, "h", "tread of stairs as steep as a drop is taken for", low=1e-3)


@dataclass(frozen=True)
class GroundPlaneSettings(Settings):
    """The window of the plane that a body follows; lengths in heights h of the centre of mass."""

    half_length: float = setting(
        2.0, "h", "half of the window's length along the heading", low=1e-3,
        tuned="`surefoot bench ablation --vary GroundPlaneSettings.half_length --factor 20 "
        "--task steps-down --seeds 6`, 2026-11-26: as good from 0.1 to 2; "
        "4 of 6 fall with 0.1, which may be chance",
    )  # fmt: skip
    half_width: float = setting(0.5, "h", "half of the window's width", low=1e-3)
    ahead: float = setting(
        0.1, "s", "time by which the window runs ahead of the body", low=0.0,
        tuned="`surefoot bench ablation --vary GroundPlaneSettings.ahead --factor 20 "
        "--task steps-down --seeds 6`, 2026-11-26: as good from 0.005 to 0.1",
    )  # fmt: skip


@dataclass(frozen=True)
class GroundEstimateSettings(Settings):
    """Ground that a robot estimates from its feet; lengths in heights h of the centre of mass."""

    landings: int = setting(3, "-", "landings of each foot that the plane under the feet goes through", low=1)
    forgetting: float = setting(
        0.7,
        "-",
        "weight of a foot's landing against its next one",
        low=0.0,
        high=1.0,
        tuned=FELT + "0.07 to 0.7",
    )
    smooth: float = setting(
        0.004, "m", "distances of footholds from their plane that count as flat ground", low=0.0
    )
    bumps: float = setting(
        1.5, "-", "height by which ground may stick out, over the footholds' deviation from their plane",
        low=0.0,
        tuned="`surefoot bench ablation --vary GroundEstimateSettings.bumps --factor 20 "
        "--task steps-blind --seeds 3`, 2026-11-26: as good from 0.075 to 1.5; "
        "a twentieth takes less work on `rough`",
    )  # fmt: skip
    strike_reach: float = setting(
        0.25, "h", "distance up to which a foot over known ground may strike it", low=0.0
    )
    low: float = setting(
        0.22, "h", "height up to which steps of the ground need no preparation", low=0.0,
        tuned="`surefoot bench ablation --vary GroundEstimateSettings.low --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.011 to 0.22",
    )  # fmt: skip


@dataclass(frozen=True)
class MappedGroundSettings(Settings):
    """Ground that a range sensor maps."""

    remembered: float = setting(
        0.3, "s", "time for which poses of the base are kept, for scans that come late", low=0.0,
        tuned="`surefoot bench ablation --vary MappedGroundSettings.remembered --factor 20 "
        "--task steps-down-map --seeds 6`, 2026-11-26: as good from 0.3 to 6",
    )  # fmt: skip
    stair_noise: float = setting(
        0.004, "m", "noise of the height of stairs that edges and feet have located", low=0.0
    )
    strike_noise: float = setting(
        2.0, "-", "height of an obstacle above a sole, in its noise, from which a foot can strike it", low=0.0
    )


@dataclass(frozen=True)
class StairDetectionSettings(Settings):
    """Stairs that are looked for in the heights along the way."""

    behind: float = setting(
        1.0, "m", "distance behind the robot from which stairs are looked for", low=0.0,
        tuned="`surefoot bench ablation --vary StairDetectionSettings.behind --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 1 to 20",
    )  # fmt: skip
    ahead: float = setting(
        1.1, "m", "distance ahead of the robot up to which stairs are looked for", low=0.0,
        tuned="`surefoot bench ablation --vary StairDetectionSettings.ahead --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 1.1 to 22",
    )  # fmt: skip
    least_jump: float = setting(
        0.04, "m", "jump of the height from which there is an edge", low=0.0,
        tuned="`surefoot bench ablation --vary StairDetectionSettings.least_jump --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.002 to 0.04",
    )  # fmt: skip
    treads: tuple[float, float] = setting(
        (0.15, 0.6), "m", "least and largest tread of stairs", low=0.0,
        tuned="`surefoot bench ablation --vary StairDetectionSettings.treads --factor 20 "
        "--task steps-down-map --seeds 3`, 2026-11-26: as good from 0.15, 0.6 to 0.15, 0.6",
    )  # fmt: skip
    even_treads: float = setting(
        0.15, "-", "largest deviation of a tread from the median, as a share of it", low=0.0
    )
    even_rises: float = setting(
        0.3,
        "-",
        "largest deviation of a rise from the median, as a share of it",
        low=0.0,
        tuned=DETECTED + "0.1 to 3",
    )
    looks: int = setting(5, "-", "looks of which stairs are the medians", low=1, tuned=DETECTED + "5 to 50")
    other: float = setting(0.03, "-", "change of the tread by which looks replace known stairs", low=0.0)
    fitted: float = setting(
        0.005,
        "-",
        "change of the tread by which a fit replaces known stairs",
        low=0.0,
        tuned=DETECTED + "0.0005 to 0.015",
    )
    doubtful: float = setting(
        1.0, "s", "time after which an uncertain fit begins anew", low=0.0,
        tuned="`python -m benchmarks.learnt_ground StairDetectionSettings.doubtful --factor 3 10 100`, "
        "2026-11-26: as good from 0.1 to 100",
    )  # fmt: skip
    patience: float = setting(0.6, "s", "time without any edge after which stairs are over", low=0.0)


@dataclass(frozen=True)
class StairFitSettings(Settings):
    """Errors that the filter of stairs reckons with, and when it takes stairs for known or lost."""

    gate: float = setting(
        3.0,
        "-",
        "standard deviations beyond which a measurement is left out",
        low=0.0,
        tuned=FITTED + "3 to 30",
    )
    angle: float = setting(
        0.008,
        "rad",
        "standard deviation of a range sensor's mounting angle",
        low=0.0,
        tuned=FITTED + "0.008 to 0.08",
    )
    place: float = setting(
        0.004, "m", "standard deviation of an edge's place in a scan", low=0.0,
        tuned="`surefoot bench ablation --vary StairFitSettings.place --factor 20 "
        "--task steps-up-map --seeds 3`, 2026-11-26: as good from 0.0002 to 0.004",
    )  # fmt: skip
    repeated: float = setting(
        8.0,
        "-",
        "factor on variances of scans, which repeat the mounting's errors",
        low=1.0,
        tuned=FITTED + "8 to 24",
    )
    drift: float = setting(
        4e-3, "m/√s", "drift of the stairs along themselves in the estimated frame", low=0.0
    )
    rising: float = setting(
        6e-3,
        "m/√s",
        "drift of the stairs' height in the estimated frame",
        low=0.0,
        tuned=FITTED + "0.0006 to 0.006",
    )
    turning: float = setting(2e-3, "rad/√s", "drift of the stairs' direction in the estimated frame", low=0.0)
    stretch: float = setting(3e-4, "m/√s", "drift of treads and rises", low=0.0)
    few: int = setting(
        5, "-", "least number of points on each side of an edge, or on a tread", low=1,
        tuned="`surefoot bench ablation --vary StairFitSettings.few --factor 20 "
        "--task steps-up-map --seeds 3`, 2026-11-26: as good from 1 to 5",
    )  # fmt: skip
    near: float = setting(
        0.3,
        "-",
        "distance from an edge's expected place within which it is looked for, in treads",
        low=0.0,
        tuned=FITTED + "0.3 to 3",
    )
    measurements: int = setting(
        4, "-", "measurements from which an edge is part of the stairs", low=1,
        tuned="`surefoot bench ablation --vary StairFitSettings.measurements --factor 20 "
        "--task steps-up-map --seeds 3`, 2026-11-26: as good from 1 to 4",
    )  # fmt: skip
    agreeing: float = setting(
        0.6,
        "-",
        "least share of points on treads that lie at their heights",
        low=0.0,
        high=1.0,
        tuned=FITTED + "0.06 to 0.6",
    )
    patience: int = setting(10, "-", "scans in turn with a lower share after which stairs are lost", low=0)
    sure: float = setting(
        0.01, "m", "standard deviation of the first edges from which stairs are known", low=0.0,
        tuned="`surefoot bench ablation --vary StairFitSettings.sure --factor 20 "
        "--task steps-up-map --seeds 3`, 2026-11-26: as good from 0.01 to 0.2",
    )  # fmt: skip
    touch: float = setting(
        0.003,
        "m",
        "standard deviation of a height that a foot measures",
        low=0.0,
        tuned=FITTED + "0.003 to 0.003",
    )
    level: float = setting(
        0.004,
        "m",
        "standard deviation of a height that a scan measures, without its pitch",
        low=0.0,
        tuned=FITTED + "0.004 to 0.004",
    )
    beside: int = setting(
        2,
        "-",
        "treads before the first and beyond the last edge over which ground is taken for level",
        low=0,
        tuned=FITTED + "2 to 20",
    )


TOUCHED_GROUND = TouchedGroundSettings()
GROUND_PLANE = GroundPlaneSettings()
GROUND_ESTIMATE = GroundEstimateSettings()
MAPPED_GROUND = MappedGroundSettings()
STAIR_DETECTION = StairDetectionSettings()
STAIR_FIT = StairFitSettings()
"""The values in use."""
