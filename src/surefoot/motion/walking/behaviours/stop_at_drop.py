"""Stopping upright before drops that feet find.

At a drop nothing of the command is followed any more. The body comes down with the foot that has found no
ground, stands as soon as it can come to rest over its feet, goes to the middle of them, and stays there.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Memory, Remembering
from surefoot.base.spatial import GRAVITY, base_velocity, heading_of
from surefoot.motion.ground.ground_belief import believed
from surefoot.motion.ground.ground_settings import TOUCHED_GROUND
from surefoot.motion.ground.touched_ground import Ledge, TouchedGround
from surefoot.motion.walking.behaviours.behaviour import NOTHING, FootSearch, Request, WalkFacts, WalkView


class StopAtDrop(Remembering):
    """What a robot does that finds drops by touch; which feet catch its fall is known of four.

    Parameters
    ----------
    walk
        What it is for.
    ground
        What its feet have found.
    """

    MEMORY = ("_standing", "note")

    name = "stop at drop"

    def __init__(self, walk: WalkFacts, ground: TouchedGround) -> None:
        self._ground, self.height = ground, walk.height
        self.settings = walk.settings.stop_at_drop
        self.reset()

    @classmethod
    def of(cls, walk: WalkFacts) -> StopAtDrop | None:
        """Return the behaviour for walks by touch alone."""
        belief = believed(walk.terrain)
        found = belief is not None and belief.finds_drops
        return cls(walk, cast(TouchedGround, belief)) if found else None

    def reset(self) -> None:
        """Forget the last drop."""
        self._drop: Ledge | None = None
        self._standing, self.note = False, ""

    def resume(self, memory: Memory) -> None:
        """See `Remembering`: the drop is the one that the ground remembers, which is resumed before."""
        super().resume(memory)
        self._drop = self._ground.drop

    def propose(self, view: WalkView) -> Request:
        """Ask for no speed before a drop, and for rest once the body can come to it."""
        drop = self._ground.drop
        if drop is not self._drop:
            self._drop, self._standing = drop, False
        if drop is None:
            return NOTHING
        self._standing = self._standing or self._rests(drop, view)
        if drop.certain and not self.note:
            most = 1e3 * TOUCHED_GROUND.drop * self.height
            self.note = (
                f"stopped from {view.time:.2f} s on: a foot found the ground {1e3 * drop.depth:.0f} mm "
                f"lower, and drops of more than {most:.0f} mm are not taken by "
                "touch alone"
            )
        return Request(
            velocity=self._to_the_middle(view) if self._standing else np.zeros(3), hold=self._standing,
            foot_goals=lambda place, start: drop.nearest(place), note=self.note,
            search=FootSearch(
                self.settings.search_speed, 0.0 if drop.found else self.settings.lead, careful=True
            ),
        )  # fmt: skip

    def _rests(self, drop: Ledge, view: WalkView) -> bool:
        """Return whether the body, all four feet on the ground, comes to rest over them."""
        if len(view.stance) != 4 or not view.stance.all():
            return False
        q, flow = view.state.q, base_velocity(view.state.q, view.state.v)[:2]
        rest = (q[:2] + math.sqrt(self.height / GRAVITY) * flow) @ drop.along
        return bool(rest < np.sort(view.ground[:, :2] @ drop.along)[-2:].mean())

    def _to_the_middle(self, view: WalkView) -> FloatArray:
        """Return the (3,) velocity that takes a body over its feet [m/s, m/s, rad/s]."""
        way = (view.ground[:, :2].mean(axis=0) - view.state.q[:2]) / self.settings.shift_time
        way *= min(1.0, self.settings.fastest_shift / max(math.hypot(*way), 1e-9))
        c, s = heading_of(view.state.q[3:7])
        return np.array([c * way[0] + s * way[1], c * way[1] - s * way[0], 0.0])
