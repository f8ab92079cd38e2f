"""A loaded foot slides and hardly anything brakes it."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("dissipation") or e.has("distance"):
        return None
    return Evidence(0.986, f"{1e3 * e.failed['dissipation'].value:.3g} mm without friction")


SYMPTOM = Symptom(
    "frictionless slide",
    cause="friction is missing: creep of a soft contact, unknown ice, or a regularised law",
    confirm="compare f_t with mu f_n while it slides",
    cure="a stiffer friction (impratio, stiction), or the true mu",
    judge=_judge,
)
