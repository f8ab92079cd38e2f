"""Steps when they are needed: after a push the gait's clock is a wish, and feet go where they catch the body.

A pushed body comes to rest over its capture point, sqrt(h / g) times its speed ahead [1]_. Where the feet of
a trot do not reach so far within the gait's own time, the way is taken in several quick steps: the gait goes
faster, so that feet lift before they are out of reach and those in the air come down at once; the wanted
velocity gives way to the body's and comes back as fast as friction lets it, so that the plan ahead does not
throw the body over feet that stand in the wrong place.

A body that was thrown aside leaves the feet of the far side behind. With one of them in each pair of a trot,
the pressure of a pair is behind the body, and a force from there that does not tip it drives it on. So all
feet leave the ground and meet it together: both feet of the near side land ahead of the body, and brake it.

References
----------
.. [1] J. Pratt, J. Carff, S. Drakunov, A. Goswami, "Capture point: a step toward humanoid push recovery",
   Humanoids 2006.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.motion.walking.behaviours.behaviour import NOTHING, Recovery, Request, WalkFacts, WalkView


class PushRecovery(Remembering):
    """Catches a body that was pushed.

    Parameters
    ----------
    walk
        What it is for.
    """

    MEMORY = ("_calm", "_aside")

    name = "push recovery"

    def __init__(self, walk: WalkFacts) -> None:
        self.schedule, self.height, self.terrain = walk.schedule, walk.height, walk.terrain
        self._unit = math.sqrt(GRAVITY * walk.height)
        self.settings = walk.settings.push_recovery
        self.reset()

    def reset(self) -> None:
        """Forget the last push."""
        self._calm: float | None = None  # speed before the push
        self._aside: bool | None = None  # whether it was thrown aside, once it was thrown far

    def propose(self, view: WalkView) -> Request:
        """Ask for quick steps that go with the body, while it is far off its wanted velocity."""
        (x, y, _), (forward, left, turn) = view.now.com_velocity.tolist(), view.velocity.tolist()
        c, s, _ = view.now.rotation[:, 0].tolist()
        c, s = c / math.hypot(c, s), s / math.hypot(c, s)
        ahead, aside = c * x + s * y - forward, c * y - s * x - left
        off, speed = math.hypot(ahead, aside) / self._unit, math.hypot(x, y)
        if self._calm is None and off < self.settings.begin_error:  # nearly always: the cheapest way here
            return NOTHING
        caught = (
            off < self.settings.end_error
            and speed < (self._calm or 0.0) + 2.0 * self.settings.end_error * self._unit
        )
        if caught or view.clock < 0.0 or self.schedule.held or self.schedule.stance_time == 0.0:
            self.reset()
            return NOTHING
        if self._calm is None:
            self._calm = math.hypot(forward, left)
        onward, across = ahead + forward - view.command[0], aside + left - view.command[1]
        lost = self.terrain.planar and math.hypot(onward, across) > self.settings.leap_error * self._unit
        if lost and self._aside is None:
            self._aside = abs(across) > self.settings.aside * abs(onward)
        rate = min(
            max(self.schedule.stance_time * speed / (self.settings.stride * self.height), 1.0),
            self.settings.quickest,
        )
        more = 1.0 - min(1.0, self.settings.give / off)
        velocity = np.array([forward + more * ahead, left + more * aside, turn])
        recovery = Recovery(rate, velocity, self.settings.back * GRAVITY, lost and bool(self._aside))
        return Request(recovery=recovery, height=self.settings.height * self.height)
