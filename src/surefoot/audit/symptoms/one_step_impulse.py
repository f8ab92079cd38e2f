"""A blow of one step that no foot gives."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("blow"):
        return None
    if e.failed["blow"].rows > 6:
        return None
    return Evidence(0.975, f"{e.failed['blow'].value:.3g} m g above the rows on both sides")


SYMPTOM = Symptom(
    "one step impulse",
    cause="a contact resolved in one step: a missed collision, a reset, or a force read as impulse over dt",
    confirm="halve the step: the force doubles and its impulse stays",
    cure="restitution zero, shorter steps, limit forces before they enter a reward",
    judge=_judge,
)
