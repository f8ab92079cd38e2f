"""The logged force is a multiple of the true one."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    true = e.true
    if true is None or not e.has("motion"):
        return None
    known = np.isfinite(true).all(axis=1)
    factor = float((e.force[known] * true[known]).sum() / max(float((true[known] ** 2).sum()), 1e-12))
    share = e.explained(factor * true)
    if factor <= 0.02 or abs(factor - 1.0) < 0.02 or share < 0.9:
        return None
    return Evidence(
        share - 0.002, f"{factor:.3g} times the force that the legs carry ({100 * share:.0f} % explained)"
    )


SYMPTOM = Symptom(
    "wrong scale",
    cause="wrong unit (kgf, lbf), gain, or share of a foot",
    confirm="a standing robot's forces must add up to m g",
    cure="convert once, where the log is read",
    judge=_judge,
)
