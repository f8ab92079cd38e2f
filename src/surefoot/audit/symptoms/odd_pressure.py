"""The centre of pressure lies outside the sole."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("pressure"):
        return None
    return Evidence(0.9, f"{1e3 * e.failed['pressure'].value:.3g} mm beyond the edge")


SYMPTOM = Symptom(
    "odd pressure",
    cause="pulling corners, or a wrench about another point than is told",
    confirm="print the corner forces",
    cure="take moments about the sole's own frame",
    judge=_judge,
)
