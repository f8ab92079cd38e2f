"""The force does not change in the last digit."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("frozen"):
        return None
    if e.true is not None and not e.has("motion"):
        return None
    same = (np.diff(e.force, axis=0) == 0.0).all(axis=1)
    if same.mean() < 0.7 or float(np.median(e.gap)) > 1e-3:
        return None
    value = float(np.median(e.force[:, 2]))
    return Evidence(1.0, f"{value:.6g} N in {e.failed['frozen'].rows} rows, not one digit moves")


SYMPTOM = Symptom(
    "frozen",
    cause="the same sample again: a stale buffer or a driver that repeats",
    confirm="compare the message's own time stamp",
    cure="log the sensor's stamp, drop repeats",
    judge=_judge,
)
