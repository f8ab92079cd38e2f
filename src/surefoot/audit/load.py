"""What a walking controller found out about its load, at the end of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.log import Log

LAST = 1.0
"""Length of the end of a run over which the estimates are averaged [s]."""
LIGHT = 0.05
"""Share of the robot's mass below which a payload's place is not told."""


@dataclass(frozen=True)
class LoadEstimate:
    """The payload and the wrench that were estimated, means of the last `LAST` seconds.

    Attributes
    ----------
    mass
        Beyond the controller's model [kg].
    place
        (3,) base axes [m], the third seen only while the base leans; None for a mass too light to have one.
    force, moment
        (3,) what else pushed from outside, world axes, the moment about the base's origin [N, N m].
    """

    mass: float
    place: list[float] | None
    force: list[float]
    moment: list[float]


def load_estimate(log: Log) -> LoadEstimate:
    """Return the mean of a log's ``load_estimated`` and ``wrench_estimated`` at its end."""
    rows = max(1, round(LAST / float(log.fact("dt"))))
    mass, *moment = log["load_estimated"][-rows:].mean(axis=0).tolist()
    wrench = log["wrench_estimated"][-rows:].mean(axis=0)
    light = abs(mass) < LIGHT * float(log.fact("mass_controller"))
    place = None if light else (np.array(moment) / mass).tolist()
    return LoadEstimate(mass, place, wrench[:3].tolist(), wrench[3:].tolist())
