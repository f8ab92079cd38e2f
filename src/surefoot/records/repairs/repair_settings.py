"""Settings of repairs of motions."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.settings import Settings, setting


def _source(name: str, range_: str) -> str:
    """Return the source of a setting that spoilt walks decide."""
    command = f"python -m benchmarks.certificate_limits {name} --repairs --walks 2 --seconds 2"
    return f"`{command}`, 2026-11-27: as good from {range_}"


@dataclass(frozen=True)
class RepairSettings(Settings):
    """What counts as a resting foot, and how far a repair goes for forces to exist.

    Chosen on the six impossible motions of the G1 that `docs/reports/certify.md` lists.
    """

    rest: float = setting(
        0.3, "m/s", "speed of a foot's slowest point up to which it rests", low=0.0,
        tuned=_source("rest", "0.2 to 19.2"),
    )  # fmt: skip
    lowest: float = setting(
        0.04, "m", "height above the lowest foot up to which a slow foot rests", low=0.0,
        tuned=_source("lowest", "0.000625 to 0.06"),
    )  # fmt: skip
    drift: float = setting(
        0.15, "s", "time over which a ground that drifts is averaged", low=1e-3,
        tuned=_source("drift", "0.002344 to 0.225"),
    )  # fmt: skip
    handover: float = setting(
        0.06, "s", "time over which feet begin and end to rest", low=1e-3,
        tuned=_source("handover", "0.001 to 0.96"),
    )  # fmt: skip
    reach: float = setting(
        0.5, "m", "shift of the centre of mass that costs as much as the weight", low=1e-3,
        tuned=_source("reach", "0.125 to 1"),
    )  # fmt: skip
    calm: float = setting(
        0.1, "s", "deviation of the mean that smooths impossible stretches", low=1e-3,
        tuned="`python -m benchmarks.certificate_limits calm --repairs --people FILE...`, 2026-11-27: "
        "with five references of ASAP as good from 0.06667 to 0.2",
    )  # fmt: skip
    stretch: float = setting(
        0.1, "s", "time over which the pace changes beside an impossible stretch", low=1e-3,
        tuned=_source("stretch", "0.1 to 0.1"),
    )  # fmt: skip
    slowest: float = setting(
        0.5, "-", "least pace of an impossible stretch, and one over the largest; 1 leaves times as they are",
        low=0.1, high=1.0, tuned=_source("slowest", "0.1 to 0.5"),
    )  # fmt: skip
    paces: int = setting(
        4, "-", "changes of pace in turn with certificates at most", low=0, tuned=_source("paces", "4 to 24")
    )
    rounds: int = setting(
        8, "-", "certificates in turn with shifts at most", low=1,
        tuned=_source("rounds", "4 to 28"),
    )  # fmt: skip
    joints: float = setting(
        0.1, "rad", "mean change of the joints that no repair exceeds", low=0.0,
        tuned=_source("joints", "0.025 to 6.4"),
    )  # fmt: skip
