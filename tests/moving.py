"""What many tests do to a world: start it higher up, and let it run."""

from __future__ import annotations

from typing import Any

import numpy as np


def lifted(q: np.ndarray, height: float) -> np.ndarray:
    """Return a pose that is moved up by a height [m]."""
    out = q.copy()
    out[2] += height
    return out


def advance(world: Any, steps: int, *given: Any) -> Any:
    """Return a world after so many steps, each with what is given."""
    for _ in range(steps):
        world.step(*given)
    return world
