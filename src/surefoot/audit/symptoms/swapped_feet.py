"""The force belongs to another foot."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("motion") or e.true is None:
        return None
    fits = []
    for other in range(e.rows.points):
        theirs = None if other == e.column else e.true_of(other)
        if theirs is not None:
            fits.append((e.explained(theirs), other))
    share, other = max(fits, default=(0.0, 0))
    if share < 0.9:
        return None
    return Evidence(
        share,
        f"what is logged here is the force of {e.rows.setting.names[other]} ({100 * share:.0f} % explained)",
    )


SYMPTOM = Symptom(
    "swapped feet",
    cause="the order of the feet differs between the sensor and the robot",
    confirm="lift one foot: which channel goes to zero?",
    cure="map by name, never by position",
    judge=_judge,
)
