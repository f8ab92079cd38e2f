"""A constant has been added to the force."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None or not e.has("motion"):
        return None
    offset = np.nanmean(e.force - true, axis=0)
    share = e.explained(true + offset)
    if share < 0.9:
        return None
    flies = bool((np.linalg.norm(np.nan_to_num(true), axis=1) < 0.03 * e.weight).mean() > 0.1)
    doubt = 0.02 if flies else 0.15  # where the load never changes a gain or a turn explains as much
    return Evidence(
        share - doubt, f"a constant of {float(np.linalg.norm(offset)):.3g} N explains {100 * share:.0f} %"
    )


SYMPTOM = Symptom(
    "bias",
    cause="the sensor's zero has drifted, or the foot's own weight is in it",
    confirm="read the sensor with the foot in the air",
    cure="zero it in flight",
    judge=_judge,
)
