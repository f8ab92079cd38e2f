"""The ground pulls."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("pull"):
        return None
    return Evidence(0.97, f"normal force down to {float(e.force[:, 2].min()):.3g} N")


SYMPTOM = Symptom(
    "pull",
    cause="a row f_n >= 0 is missing, or z is not the surface normal",
    confirm="print the normal and the smallest normal force",
    cure="add the row; turn the frame so that z leaves the ground",
    judge=_judge,
)
