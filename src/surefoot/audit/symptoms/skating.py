"""The foot travels by chattering."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    way = e.velocity[:, :2] * e.dt[:, None]
    gone = float(np.hypot(*way.sum(axis=0)))
    if not e.has("chatter") or gone < 2e-3:
        return None
    return Evidence(0.995, f"{1e3 * gone:.3g} mm while it chattered")


SYMPTOM = Symptom(
    "skating",
    cause="between blows nothing brakes the foot, and the policy has learnt to travel on that",
    confirm="add up the way of a foot while its force switches on and off",
    cure="average the contact over a few steps in the reward; damp the contact",
    judge=_judge,
)
