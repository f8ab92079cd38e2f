"""Settings of repairs of motions."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


@dataclass(frozen=True)
class RepairSettings(Settings):
    """What counts as a resting foot, and how far a repair goes for forces to exist.

    Chosen on the six impossible motions of the G1 that `docs/certify.md` lists.
    """

    rest: float = setting(0.3, "m/s", "speed of a foot's slowest point up to which it rests", low=0.0)
    lowest: float = setting(0.04, "m", "height above the lowest foot up to which a slow foot rests", low=0.0)
    drift: float = setting(0.15, "s", "time over which a ground that drifts is averaged", low=1e-3)
    handover: float = setting(0.06, "s", "time over which feet begin and end to rest", low=1e-3)
    reach: float = setting(0.5, "m", "shift of the centre of mass that costs as much as the weight", low=1e-3)
    calm: float = setting(0.05, "s", "deviation of the mean that smooths impossible stretches", low=1e-3)
    rounds: int = setting(8, "-", "certificates in turn with shifts at most", low=1)
    joints: float = setting(0.1, "rad", "mean change of the joints that no repair exceeds", low=0.0)
