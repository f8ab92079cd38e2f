"""Where flat feet press: the centre of pressure in the sole, from a log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from surefoot.base.arrays import FloatArray
from surefoot.base.loaded import loaded_feet
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log


@dataclass(frozen=True)
class SolePressure:
    """The centre of pressure of one flat foot over a run.

    Attributes
    ----------
    foot
        Index of the foot.
    outline
        (k, 2) corners of the sole in the foot's frame, in order [m].
    centres
        (T, 2) centre of pressure in the foot's frame [m]; NaN where the foot is not loaded.
    margin
        Least distance from the sole's edge [m], never negative beyond rounding: no pressure acts outside
        the contact points; NaN if the foot never was loaded.
    """

    foot: int
    outline: FloatArray
    centres: FloatArray
    margin: float


def sole_pressures(log: Log) -> list[SolePressure]:
    """Return the centres of pressure of all flat feet, from the measured forces.

    The centre of pressure is the mean of the contact points weighted by their normal forces. Logs
    that do not say where the points lie in their feet (``contact_centres``) have none.
    """
    owner = log.fact("contact_foot")
    if "contact_centres" not in log.facts:
        return []
    places = log.fact("contact_centres")[:, :2]
    weight = log.fact("mass") * GRAVITY
    out = []
    for foot in range(len(log.fact("feet"))):
        mine = owner == foot
        if mine.sum() < 3:
            continue
        normal = np.maximum(log["forces"][:, mine, 2], 0.0)
        total = normal.sum(axis=1)
        loaded = loaded_feet(total, weight)
        centres = np.full((len(log), 2), np.nan)
        centres[loaded] = normal[loaded] @ places[mine] / total[loaded, None]
        hull = ConvexHull(places[mine])
        inside = -(centres[loaded] @ hull.equations[:, :2].T + hull.equations[:, 2])
        margin = float(inside.min()) if loaded.any() else float("nan")
        out.append(SolePressure(foot, places[mine][hull.vertices], centres, margin))
    return out
