"""The logged force is the true one, turned."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.fits import rotation_between
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None or not e.has("motion"):
        return None
    turn = rotation_between(true, e.force)
    angle = float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
    share = e.explained(true @ turn.T)
    if angle < 3.0 or share < 0.8:
        return None
    return Evidence(
        share - 0.03, f"turning the forces by {angle:.0f} deg explains {100 * share:.0f} % of the mismatch"
    )


SYMPTOM = Symptom(
    "wrong frame",
    cause="forces and Jacobian are in different frames (LOCAL with world forces, another normal)",
    confirm="the power test f . J v = tau . v, in each frame",
    cure="state the frame in the name and rotate once, at the door",
    judge=_judge,
)
