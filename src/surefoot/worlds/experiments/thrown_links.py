"""A thrown body's links and joints in the words that engines behind a URDF take, and the step of them all."""

from __future__ import annotations

import math
from typing import Any

from surefoot.records import ThrownBody

LONGEST_STEP = 1e-3
"""Of a simulation of tosses by an engine [s]."""


def steps_between(dt: float) -> int:
    """Return how many steps there are between frames dt [s] apart."""
    return max(1, math.ceil(dt / LONGEST_STEP - 1e-9))


def joint_words(body: ThrownBody, i: int) -> dict[str, Any]:
    """Return a link, and the joint that it hangs on, as Drake's worker and Bullet's URDF take it."""
    tree = body.tree
    kind = "free" if i == 0 else ("prismatic" if tree.sliding[i] else "revolute")
    arrays = {
        "rotation": tree.turns[i], "place": tree.places[i], "axis": tree.axes[i], "com": tree.centres[i],
        "inertia": tree.inertias[i],
    }  # fmt: skip
    return {
        "kind": kind, "parent": int(tree.parents[i]) + 1, "low": -math.inf, "high": math.inf,
        "mass": float(tree.masses[i]), "damping": float(tree.damping[i]),
        **{name: value.tolist() for name, value in arrays.items()},
    }  # fmt: skip
