"""The force sits in the corner of a friction pyramid outside the cone."""

from __future__ import annotations

import numpy as np

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    if not e.has("friction") or not e.sideways:
        return None
    fast = (e.force[:, 2] > 0.005 * e.weight) & np.isfinite(e.mu)
    use = e.force[:, :2] / np.maximum(e.mu * e.force[:, 2], 1e-12)[:, None]
    over = fast & (np.hypot(use[:, 0], use[:, 1]) > 1.01)
    if over.sum() < 3:
        return None
    for facets in (4, 8):
        angle = 2.0 * np.pi * np.arange(facets) / facets
        reach = (use[over] @ np.stack([np.cos(angle), np.sin(angle)])).max(axis=1)
        if np.percentile(reach, 90) < 1.005 and np.percentile(reach, 10) > 0.98:
            return Evidence(0.995, f"forces lie on the edge of a pyramid of {facets} facets about the cone")
    return None


SYMPTOM = Symptom(
    "coarse facets",
    cause="an outer pyramid of too few facets: 41 % more friction on its corners for four, 8 % for eight",
    confirm="plot f_t / f_n: the points fill a square or an octagon, not a circle",
    cure="use the exact cone, or an inner pyramid of eight facets or more",
    judge=_judge,
)
