"""Stopping upright before drops that feet find.

At a drop the body stops. It comes down with the foot that has found no ground, stands as soon as it can come
to rest over its feet, and goes to the middle of them; feet keep to where feet have stood, and the only way
that is left is back.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.behaviours.behaviour import NOTHING, FootSearch, Request, WalkFacts, WalkView
from surefoot.estimation.ground_belief import believed
from surefoot.estimation.ledge import DROP, Ledge
from surefoot.estimation.touched_ground import TouchedGround
from surefoot.spatial import GRAVITY, base_velocity

RETREAT = 0.3
"""Share of its speed with which the body leaves a drop."""
FALLING = 1.8
"""Lead of a foot over the body that falls into a drop (`FootSearch.lead`)."""
GENTLE_SPEED = 0.03
"""How fast late feet go down at a drop, as a share of sqrt(g h)."""
LITTLE = 0.5
"""What is left of a command is nothing if it is less than this share of it."""
NEAR, SKEW, QUIET = 0.08, 0.15, 0.08
"""A body that stands may step again once it is so near to the line between the feet that will stand, in
heights of the centre of mass, and no faster [m/s]. It does so, on the spot, where the middles of the feet's
diagonals are that far apart along the way, likewise."""
FAR = 0.35
"""From so far away it goes to the middle of its feet, likewise."""
SHIFT_TIME, FASTEST_SHIFT = 0.3, 0.25
"""Time in which it goes there [s], and how fast at most [m/s]."""
AHEAD = 0.1
"""One that goes back but is so far ahead of the middle of its feet stands again, likewise."""


class StopAtDrop:
    """What a robot does that finds drops by touch.

    Parameters
    ----------
    walk
        What it is for.
    ground
        What its feet have found.
    """

    name = "stop at drop"

    def __init__(self, walk: WalkFacts, ground: TouchedGround) -> None:
        self._ground, self._height = ground, walk.height
        self.reset()

    @classmethod
    def of(cls, walk: WalkFacts) -> StopAtDrop | None:
        """Return the behaviour for walks by touch alone."""
        belief = believed(walk.terrain)
        found = belief is not None and belief.finds_drops
        return cls(walk, cast(TouchedGround, belief)) if found else None

    def reset(self) -> None:
        """Forget the last drop."""
        self._stop: AstrideStop | None = None
        self._note = ""

    def propose(self, view: WalkView) -> Request:
        """Ask for no speed before a drop."""
        drop = self._ground.drop
        if drop is None:
            self._stop = None
            return NOTHING
        if self._stop is None or self._stop.drop is not drop:
            self._stop = AstrideStop(drop, self._height)
        stop, state = self._stop, view.state
        stop.rest(state.q[:2], base_velocity(state.q, state.v)[:2], view.ground, view.stance)
        if drop.certain and not self._note:
            self._note = (
                f"stopped from {view.time:.2f} s on: a foot found the ground {1e3 * drop.depth:.0f} mm "
                f"lower, and drops of more than {1e3 * DROP * self._height:.0f} mm are not taken by touch "
                f"alone; only commands that lead back are followed"
            )
        return Request(
            velocity=stop.velocity(view.command, self._ground.axes), pace=RETREAT, hold=stop.standing,
            leading=stop.leading, foot_goals=stop.goal, note=self._note,
            search=FootSearch(GENTLE_SPEED, 0.0 if drop.found else FALLING, careful=True),
        )  # fmt: skip


class AstrideStop:
    """How a robot on four feet comes to rest at a drop, and leaves it.

    Parameters
    ----------
    drop
        What is known of it.
    height
        Of the centre of mass above the ground [m].

    Attributes
    ----------
    standing, astride
        Whether the body stands still, and whether feet stand beyond the edge.
    leading
        A foot of the diagonal that should step first then.
    """

    def __init__(self, drop: Ledge, height: float) -> None:
        self.drop, self._height = drop, height
        self.standing = self.astride = self._halted = self._stood = self._onward = False
        self.leading = 0
        self._excess, self._shift = np.zeros(2), np.zeros(2)
        self._stepped: BoolArray = np.zeros(4, dtype=bool)

    def rest(self, place: FloatArray, flow: FloatArray, feet: FloatArray, stance: BoolArray) -> None:
        """Decide whether to stand still: once the body can come to rest over the feet as they stand.

        Parameters
        ----------
        place, flow
            (2,) of the body [m], and its velocity [m/s], world axes.
        feet
            (n, 3) where feet stand [m].
        stance
            (n,) which of them do.
        """
        if len(feet) != len(self._stepped):
            return  # which feet step together, and which stand then, is known of four
        s, stands = float(place @ self.drop.along), feet[:, :2] @ self.drop.along
        beyond = stands > self.drop.edge
        self.astride, last = bool(beyond.any()), int(beyond.sum()) == 1
        self.leading = int(last and (beyond[1] or beyond[2]))
        skew = self._lines(place, feet)
        speed, ahead = math.hypot(*flow), s - float(stands.mean())
        self._stepped |= ~stance
        self._halted &= last
        if self.standing:
            ready = math.hypot(*self._excess) < NEAR * self._height and speed < QUIET
            self.standing = not (stance.all() and ready and (self._onward or skew > SKEW * self._height))
            self._stepped &= self.standing
        elif self._stood:
            off = bool(self._stepped.all()) and ahead > AHEAD * self._height
            square = bool(stance.all()) and skew < 0.5 * SKEW * self._height and speed < 2.0 * QUIET
            self.standing = off or (last and not self._halted) or (square and not self._onward)
            self._halted = last
        elif stance.all():
            rest = s + float(flow @ self.drop.along) * math.sqrt(self._height / GRAVITY)
            self._stood = self.standing = rest < float(np.sort(stands)[-2:].mean())

    def _lines(self, place: FloatArray, feet: FloatArray) -> float:
        """Find where the body should go when it stands; return how far apart the diagonals are [m]."""
        first, last = feet[[[1, 2], [0, 3]][self.leading], :2]  # of the diagonal that will stand first
        way = last - first
        share = float(np.clip((place - first) @ way / (way @ way), 0.0, 1.0))
        self._excess = first + share * way - place
        middle = feet[:, :2].mean(axis=0) - place
        self._shift = middle if math.hypot(*middle) > FAR * self._height else self._excess
        return abs(float((feet[0] + feet[3] - feet[1] - feet[2])[:2] @ self.drop.along)) / 2.0

    def velocity(self, command: FloatArray, axes: FloatArray) -> FloatArray:
        """Return what is followed of a command (3,), heading `axes` (2, 2) by rows [m/s, m/s, rad/s]."""
        slowed, turn = self.slowed(command[:2] @ axes), 0.0 if self.astride else float(command[2])
        self._onward = bool(slowed.any() or turn != 0.0)
        if self.standing:
            speed = math.hypot(*self._shift) / SHIFT_TIME
            slowed = self._shift / SHIFT_TIME * min(1.0, FASTEST_SHIFT / max(speed, 1e-9)) / RETREAT
            turn = 0.0
        return np.array([*(axes @ slowed), turn])

    def slowed(self, velocity: FloatArray) -> FloatArray:
        """Return a (2,) velocity along x and y of the world without what leads on towards the drop [m/s]."""
        left = velocity - max(float(velocity @ self.drop.along), 0.0) * self.drop.along
        little = math.hypot(*left) < LITTLE * math.hypot(*velocity)
        return np.zeros(2) if little else np.asarray(left)

    def goal(self, place: FloatArray, start: FloatArray) -> FloatArray:
        """Return the (2,) place where a foot may land [m], see `FootGoals`: where feet have stood."""
        s, begun = float(place @ self.drop.along), float(start[:2] @ self.drop.along)
        return np.asarray(place + (self.drop.nearest(s, begun, self._stood) - s) * self.drop.along)
