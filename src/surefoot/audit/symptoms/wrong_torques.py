"""Forces explain the body's motion, the joint torques do not."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    rest = e.rows.unexplained
    if rest is None or not e.has("motion"):
        return None
    body = np.linalg.norm(rest.force[e.rows.core], axis=1)
    if float(np.nanmean(body)) > 0.02 * e.weight:
        return None
    return Evidence(0.97, "the forces add up to the body's motion, and this leg's torques ask for others")


SYMPTOM = Symptom(
    "wrong torques",
    cause="joint torques are permuted, of the other sign, or not those that were applied",
    confirm="the power test tau . v = f . J v, joint by joint",
    cure="map joints by name; log the applied torque, not the commanded one",
    judge=_judge,
)
