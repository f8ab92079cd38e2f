"""The robot weighs something else than the log says."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom
from surefoot.spatial import GRAVITY


def _judge(e: Episode) -> Evidence | None:
    rest = e.rows.unexplained
    if rest is None or not e.has("motion") or e.failed["motion"].rows * e.rows.setting.dt < 0.2:
        return None
    force = rest.force[e.rows.core]
    force = force[np.isfinite(force).all(axis=1)]
    mean, spread = force.mean(axis=0), force.std(axis=0)
    upright = abs(mean[2]) > 0.9 * np.linalg.norm(mean)
    if not upright or np.linalg.norm(spread) > 0.6 * abs(mean[2]):
        return None
    return Evidence(0.9, f"the forces carry {-mean[2] / GRAVITY:+.3g} kg against the log's mass")


SYMPTOM = Symptom(
    "wrong mass",
    cause="a payload, or the model's mass is not the robot's",
    confirm="weigh the robot",
    cure="correct the mass; estimate the payload while standing",
    judge=_judge,
    body=True,
)
