"""The ground gives nothing, and the robot does not fall."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("idle"):
        return None
    if e.rows.has("gaps") and float(np.median(e.rows.gaps[e.rows.core].min(axis=1))) > 1e-3:
        return None
    return Evidence(1.0, "no contact carries anything though feet touch the ground")


SYMPTOM = Symptom(
    "no forces",
    cause="the schedule says swing, the Jacobian's frame makes J^T f vanish, or the forces were never read",
    confirm="print the contact schedule and the force buffer while the robot stands",
    cure="read the forces after the step; check body names and the frame of the Jacobian",
    judge=_judge,
    body=True,
)
