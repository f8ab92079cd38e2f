"""A force across the ground where there is no contact."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    air = (e.gap > 1e-3) & (e.force[:, 2] <= 0.005 * e.weight)
    side = np.hypot(e.force[:, 0], e.force[:, 1])
    if not e.has("distance") or (air & (side > e.rows.setting.threshold)).mean() < 0.5:
        return None
    return Evidence(
        0.98,
        f"{float(side[air].max()):.3g} N across the ground, {1e3 * float(e.gap[air].max()):.3g} mm above it",
    )


SYMPTOM = Symptom(
    "friction in the air",
    cause="friction is computed from a stale or padded contact, or from a foot's speed near the ground",
    confirm="plot f_t against the gap",
    cure="tie the friction to the normal force of the same instant",
    judge=_judge,
)
