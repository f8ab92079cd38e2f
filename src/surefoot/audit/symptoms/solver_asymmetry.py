"""One diagonal of feet carries more than the other, for no reason of the motion's."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("lean"):
        return None
    text = f"one diagonal carries {e.failed['lean'].value:.2g} m g more than the other"
    return Evidence(0.9 if e.consistent else 0.6, text)


SYMPTOM = Symptom(
    "solver asymmetry",
    cause="the solver favours the contacts that it visits first: too few sweeps",
    confirm="change the order of the contacts, or the number of sweeps: the share moves",
    cure="more iterations, a solver that converges, or contacts in random order",
    judge=_judge,
)
