"""A sensor reports force on a foot that is in the air."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("distance", "motion") or e.true is None:
        return None
    air = e.gap > 1e-3
    none = np.linalg.norm(e.true[air], axis=1) < 0.03 * e.weight
    if air.mean() < 0.5 or none.mean() < 0.8:
        return None
    return Evidence(0.98, f"{float(np.abs(e.force[air, 2]).max()):.3g} N while the leg carries nothing")


SYMPTOM = Symptom(
    "phantom force",
    cause="the sensor has an offset, or another foot's force got into this channel",
    confirm="lift the foot by hand: it should read zero",
    cure="zero the sensors in flight",
    judge=_judge,
)
