"""When a foot is loaded: four questions, each with its share of the robot's weight m g.

A question asked of exact forces (a solver's, a plan's, a world's own) needs a smaller share than one asked of
a sensor. Behaviours that ask for more than a load, such as enough force to judge friction by, have limits of
their own that say so.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray

ACTS = 1e-3
"""Does the ground push at all [m g]? A smaller normal force is a solver's or a simulator's rounding."""
PLANNED = 0.01
"""Does a foot stand in a plan [m g]? Less is what an optimiser leaves on feet in the air."""
CARRIES = 0.02
"""Does the foot bear weight [m g]? Under less, soft contacts ring and have no centre of pressure."""
SENSED = 0.05
"""Does a sensor in the foot feel the ground [m g]? Less may be all noise and offset."""
UNLOADED = 0.02
"""How long is a foot without load that has left the ground [s]? A shorter time is a bounce."""
DEBOUNCE = 0.03
"""How long is a phase at least that a sensor in the foot tells [s]? A shorter one may be its noise."""


def loaded_feet(normal: Any, weight: float, share: float = CARRIES) -> BoolArray:
    """Return where normal forces (...) exceed a share of the weight: (...).

    Parameters
    ----------
    normal
        Of feet or of contact points [N].
    weight
        m g of the robot [N].
    share
        Which question is asked: `ACTS`, `PLANNED`, `CARRIES` or `SENSED`.
    """
    return np.asarray(np.asarray(normal) > share * weight)
