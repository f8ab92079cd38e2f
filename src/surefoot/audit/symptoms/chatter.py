"""The contact opens and closes, or its force rings, at high frequency."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("chatter"):
        return None
    return Evidence(0.993, f"as if {e.failed['chatter'].value:.0f} switches in 0.1 s")


SYMPTOM = Symptom(
    "chatter",
    cause="contact too stiff for an explicit integrator, or a threshold without hysteresis",
    confirm="halve the step: the frequency doubles",
    cure="implicit integration, damping, a softer contact",
    judge=_judge,
)
