"""More friction than the material has."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("friction"):
        return None
    needed = np.hypot(e.force[:, 0], e.force[:, 1]) / np.maximum(e.force[:, 2], 1e-12)
    over = (needed > 1.001 * e.mu) & (e.force[:, 2] > e.rows.setting.threshold)
    if not over.any():
        return None
    worst = float(needed[over].max())
    return Evidence(
        0.985 if e.sideways else 0.9,
        f"needs mu of {worst:.3g} where the ground has {float(e.mu[over].min()):.3g}",
    )


SYMPTOM = Symptom(
    "too much friction",
    cause="the simulated friction is higher than the material's, or the log's mu is not the ground's",
    confirm="pull the robot sideways with a spring balance until it slides",
    cure="measure mu, and lower it in training and in the controller",
    judge=_judge,
)
