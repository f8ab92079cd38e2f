"""The motion needs forces where nothing touches the ground."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not (e.has("idle") or e.has("motion")) or not e.rows.has("gaps"):
        return None
    if float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) <= 1e-3:
        return None
    return Evidence(0.99, "the body is held up while every foot is off the ground")


SYMPTOM = Symptom(
    "infeasible",
    cause="the motion is not one that contacts can give: wrong mode, or gap and force demanded at once",
    confirm="look which contacts are closed while the body is held",
    cure="relax the complementarity step by step; check modes and the ground's height",
    judge=_judge,
    body=True,
)
