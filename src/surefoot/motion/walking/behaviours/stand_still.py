"""Standing still: before the gait begins nobody goes anywhere, and a body that is pushed away takes steps."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.spatial import GRAVITY
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Request, WalkFacts, WalkView

STANDING = Request(pace=0.0)


class StandStill:
    """Keeps a robot in place that is not asked to go.

    Parameters
    ----------
    walk
        What it is for.
    """

    name = "stand still"

    def __init__(self, walk: WalkFacts) -> None:
        self._unit = math.sqrt(GRAVITY * walk.height)
        self.settings = walk.settings.stand_still

    def reset(self) -> None:
        """Forget nothing: it knows the present alone."""

    def propose(self, view: WalkView) -> Request:
        """Ask for no speed before the gait begins, and for steps of a body that moves."""
        x, y, _ = view.now.com_velocity.tolist()
        drift = None
        if math.hypot(x, y) > self.settings.unrest * self._unit and not any(view.velocity.tolist()):
            drift = np.array([x, y, 0.0])
        if view.clock < 0.0:
            return STANDING._replace(step_times=drift)
        return NOTHING if drift is None else Request(step_times=drift)
