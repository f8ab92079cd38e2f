"""The force stops at a value that it never exceeds."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("motion"):
        return None
    whole = e.rows.normal[:, e.column]
    top = float(whole.max())
    at = np.isclose(e.force[:, 2], top, rtol=1e-9)
    if (
        e.true is None
        or top <= 0.0
        or at.mean() < 0.3
        or float(np.nanmin(e.true[at, 2] - top)) < -0.01 * e.weight
    ):
        return None
    return Evidence(0.985, f"stays at {top:.4g} N in {100 * at.mean():.0f} % of the rows, none is higher")


SYMPTOM = Symptom(
    "clipped",
    cause="the sensor or its channel is at the end of its range",
    confirm="load the foot by hand beyond it",
    cure="a larger range; treat the limit as unknown, not as a value",
    judge=_judge,
)
