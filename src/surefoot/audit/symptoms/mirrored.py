"""The logged force is the true one in a mirror."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom

_SIGNS = np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]])


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None or not e.has("motion"):
        return None
    best, which = max((e.explained(true * sign), k) for k, sign in enumerate(_SIGNS))
    if best < 0.9:
        return None
    return Evidence(
        best - 0.005, f"the sign of {'xy'[which]} reversed explains {100 * best:.0f} % of the mismatch"
    )


SYMPTOM = Symptom(
    "mirrored",
    cause="one tangent has the wrong sign: a left-handed contact frame or another order of axes",
    confirm="push the robot sideways and compare the sign of the forces",
    cure="build the frame from the normal and a heading, right-handed",
    judge=_judge,
)
