"""The foot sinks into the ground."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("penetration"):
        return None
    depth = 1e3 * e.failed["penetration"].value
    return Evidence(0.95, f"{depth:.3g} mm deep" + (", more than 5 mm" if depth > 5.0 else ""))


SYMPTOM = Symptom(
    "sinking",
    cause="contact stiffness too low for the load, or the step too long",
    confirm="halve the step; the depth of a soft contact stays, that of a missed one halves",
    cure="stiffer with a shorter step, or a pressure-field contact",
    judge=_judge,
)
