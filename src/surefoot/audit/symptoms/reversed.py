"""The logged force acts on the ground."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None:
        if e.has("pull") and float(np.mean(e.force[:, 2])) < -0.05 * e.weight:
            return Evidence(0.9, "the ground pulls with a share of the weight throughout")
        return None
    share = e.explained(-true)
    return (
        Evidence(share, f"the sign reversed explains {100 * share:.0f} % of the mismatch")
        if share > 0.9
        else None
    )


SYMPTOM = Symptom(
    "reversed",
    cause="action and reaction are exchanged: the force on the ground, not on the robot",
    confirm="a standing robot's forces must add up to +m g",
    cure="reverse the sign where the forces are read",
    judge=_judge,
)
