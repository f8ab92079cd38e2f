"""A foot that carries reports nothing."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None or not e.has("motion"):
        return None
    none = np.linalg.norm(e.force, axis=1) <= e.rows.setting.threshold
    carried = np.nan_to_num(true[:, 2]) > 0.04 * e.weight
    share = float((none & carried).mean())
    if share < 0.7:
        return None
    return Evidence(0.999, f"zero where the leg carries {float(np.nanmean(true[:, 2])):.3g} N")


SYMPTOM = Symptom(
    "dropout",
    cause="the sensor or its message was lost, or the contact was not found",
    confirm="compare with the leg's torques: they carry on",
    cure="hold or flag lost samples; check the contact filter",
    judge=_judge,
)
