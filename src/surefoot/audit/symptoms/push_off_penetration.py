"""The ground gives back more than it took: the foot is thrown out of it."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("penetration"):
        return None
    power = e.force[:, 2] * e.velocity[:, 2] * e.dt
    gained, rising = float(power[e.gap < 0.0].sum()), e.gap < -1e-3
    speed = float(e.velocity[rising, 2].max(initial=0.0))
    if gained < 2e-4 * e.weight or speed < 0.05:
        return None
    return Evidence(
        0.97,
        f"{gained:.3g} J won while it left {-1e3 * float(e.gap.min()):.3g} mm of depth at {speed:.2g} m/s",
    )


SYMPTOM = Symptom(
    "push off penetration",
    cause="the engine turns depth into speed (projection, a stiff spring), and the policy uses it",
    confirm="add up f_n v_n over the contact: it must not be positive",
    cure="limit the depenetration speed, shorten the step, punish depth in training",
    judge=_judge,
)
