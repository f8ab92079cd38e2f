"""Something carries the foot above the ground that the log knows."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("distance") or e.has("motion"):
        return None
    real = "and the motion needs it" if e.consistent else "and nothing contradicts it"
    height = 1e3 * float(e.gap[e.loaded].max(initial=0.0))
    return Evidence(0.95, f"{float(e.force[:, 2].max()):.3g} N at a gap of {height:.3g} mm, {real}")


SYMPTOM = Symptom(
    "invisible geometry",
    cause="it leans on what is not the ground: a wide contact margin, a collision shape, a wrong map",
    confirm="draw the collision geometry at that instant",
    cure="set margins to zero, and measure the gap to what really touches",
    judge=_judge,
)
