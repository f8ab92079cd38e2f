"""Settings of ground that feet find."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


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
    drop: float = setting(0.29, "h", "depth from which a drop is not taken by touch alone", low=0.0)
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


TOUCHED_GROUND = TouchedGroundSettings()
"""The values in use."""
