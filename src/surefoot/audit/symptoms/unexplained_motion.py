"""Forces and motion do not belong together."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("motion"):
        return None
    return Evidence(0.3, f"{e.failed['motion'].value:.3g} N of this foot's force are unaccounted for")


SYMPTOM = Symptom(
    "unexplained motion",
    cause="a measurement of this leg is wrong: force, torque or joints",
    confirm="stand still and compare J^T f with the torques",
    cure="check units, order and time of the channels of this leg",
    judge=_judge,
)
