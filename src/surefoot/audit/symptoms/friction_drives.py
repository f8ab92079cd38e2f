"""Friction works with the slip and not against it."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("work") or e.has("distance"):
        return None
    return Evidence(0.992, f"{e.failed['work'].value:.3g} J given by friction in 50 ms")


SYMPTOM = Symptom(
    "friction drives",
    cause="the sign of the tangential force or of the velocity, or a conveyor that the log does not know",
    confirm="f_t . v_t of a sliding foot must be negative",
    cure="check the sign; give the ground's own velocity",
    judge=_judge,
)
