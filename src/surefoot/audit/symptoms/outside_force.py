"""Something pushes the body that the log does not know."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    rest = e.rows.unexplained
    if rest is None or not e.has("motion"):
        return None
    force = np.nanmedian(rest.force[e.rows.core], axis=0)
    return Evidence(0.8, f"about ({force[0]:.3g}, {force[1]:.3g}, {force[2]:.3g}) N on the body, world axes")


SYMPTOM = Symptom(
    "outside force",
    cause="a push, a cable or a hand; or a contact of another part of the robot",
    confirm="look at the robot at that time: what touches it?",
    cure="log pushes; give every geom that may touch",
    judge=_judge,
    body=True,
)
