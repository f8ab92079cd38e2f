"""Edges of steps down, found by a robot that stands astride the first one: its feet slide to them.

A foot that goes down a step strikes nothing that would tell where its edge is. But one that is drawn along a
tread with a light push sinks as soon as it is over the edge, by what a sphere on a corner does. So while the
other three carry the body, one of the upper feet is drawn forward to the edge before it, and one of the lower
feet to the next edge: that is where the steps begin, and how deep their treads are. Each foot then stands
a little before the edge that it has found. A front foot that is still on the upper level finds the first edge
before all that, and joins the other one beyond it. In the end the body goes where the walk can set off from.

For the way of a foot's centre behind an edge at which it has sunk by z, r² = (r - z)² + s² holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.walking_feet import FootProbe
from surefoot.spatial import GRAVITY

MARGIN, CALM = 0.1, 0.09
"""A foot is lifted once the body would come to rest so far within the triangle of the others, in heights of
the centre of mass, and is slower than this share of sqrt(g h)."""
SHIFT_TIME, SHIFT_SPEED, USUAL_SHIFT = 0.25, 0.17, 0.06
"""Time in which the body goes where it should be for that [s], how fast at most, and how fast it usually
does, as shares of sqrt(g h)."""
HIND_AHEAD, FRONT_AHEAD, FRONT_BEFORE, REACHED = 0.23, 0.07, -0.85, 0.06
"""How far beyond the first edge it should be for an upper hind foot to reach that edge, for a lower front
foot to reach the next, and for an upper front foot to reach the first; and how near to that is enough, in
heights of the centre of mass."""
NEARLY_OVER, MIDDLE = 0.15, 0.3
"""The walk goes on once the body is so near to the line between the feet that carry first, likewise, without
these shares of it at its ends."""
SHORT = 0.02
"""A foot is worth a second more for which the body comes that much nearer to there [m]."""
FRONT = 2
"""Number of front feet, which come first."""
LONGEST_SHIFT, LONGEST = 1.5, 6.0
"""Times after which nothing more is expected of it, and of all [s]."""
LIFTED, PUSHED, PRESSED, SUNK, TOUCHED, STUCK = 0.01, 0.008, 0.003, 0.0045, 0.005, 0.006
"""How high a foot is lifted first, how far below its tread it is drawn at most, and below where it is, how
far it sinks over an edge, how far it is held up by ground that it touches, and by how much it rises at the
end of its leg [m]."""
RISING, LOWERING, LEADING = 0.3, 0.25, 0.02
"""Speeds with which it is lifted and let down [m/s], and how far ahead of it its target is at most [m]."""
DRAWN, NEAR_EDGE, LEAST_TREAD = 0.4, 0.17, 0.65
"""Speeds with which it is drawn forward, and that from where the edge may be [m/s]; no tread is less deep, in
heights of the centre of mass."""
NEARLY, FOLLOWED, SMOOTH = 0.003, 0.2, 0.02
"""A tread's height is followed as long as it differs by no more [m], with this time constant [s]; that of the
foot's speed [s]."""
LATE = 0.025
"""Time that goes by until a foot that is over an edge has sunk [s]."""
BEFORE, BEHIND, HIGH, RETURN, NEAR = 0.06, 0.18, 0.02, 0.5, 0.02
"""A foot goes back to so far before its edge, or on behind it [m], so high above the tread [m], with this
speed [m/s], and is let down so near to that place [m]."""
FARTHEST = 1.4
"""The farthest that a foot is drawn ahead of the body, in heights of the centre of mass."""
UP = np.array([0.0, 0.0, 1.0])


def inwards(triangle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return normals (3, 2) into a (3, 2) triangle and offsets (3,) [m]: inside is normals @ x > offsets.

    Examples
    --------
    >>> normals, offsets = inwards(np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]))
    >>> (normals @ [0.5, 0.5] - offsets).round(3).tolist()
    [0.5, 0.707, 0.5]
    """
    sides = np.roll(triangle, -1, axis=0) - triangle
    normals = np.column_stack([-sides[:, 1], sides[:, 0]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    inner = ((triangle.mean(axis=0) - triangle) * normals).sum(axis=1)
    normals *= np.where(inner < 0.0, -1.0, 1.0)[:, None]
    return normals, (normals * triangle).sum(axis=1)


def moved_inside(triangle: FloatArray, place: FloatArray, margin: float) -> FloatArray:
    """Return the place (2,) near one (2,) that is so far within a triangle (3, 2), by projections [m]."""
    normals, offsets = inwards(triangle)
    out = place.copy()
    for _ in range(30):
        for normal, offset in zip(normals, offsets, strict=True):
            out += max(margin + offset - float(normal @ out), 0.0) * normal
    return out


def to_diagonal(place: FloatArray, feet: FloatArray, leading: int, middle: float = 0.0) -> FloatArray:
    """Return the way (2,) from a place (2,) to the line between the feet that carry first [m].

    Parameters
    ----------
    place
        Of the body [m].
    feet
        (4, >= 2) where feet stand [m].
    leading
        A foot of the diagonal that lifts first.
    middle
        Share of the line at each end that is left out [-].

    Examples
    --------
    >>> feet = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
    >>> to_diagonal(np.array([0.5, 0.5]), feet, 0).tolist()
    [-0.5, -0.5]
    """
    first, last = feet[[0, 3] if leading in (1, 2) else [1, 2], :2]
    way = last - first
    share = float(np.clip((place - first) @ way / (way @ way), middle, 1.0 - middle))
    return np.asarray(first + share * way - place)


class EdgeSearch:
    """Finds the first two edges of steps down, see the module; call `update` in each step.

    Parameters
    ----------
    along
        (2,) unit vector down the steps, across their edges.
    edges
        Between which places along it the first edge is [m].
    depth, height
        Of the first step, and of the centre of mass above the ground [m].
    radius
        Of the feet [m].

    Attributes
    ----------
    shift
        (2,) velocity with which the body should move, world axes [m/s].
    probe
        What one of the feet should do, None while all stand.
    edges
        (2,) places of the two edges along the way; nan where one was beyond reach [m].
    leading
        A foot of the diagonal that should lift first when the walk goes on.
    done, failed
        Whether both have been looked for, and whether the first one cannot be found: all feet stand then.
    """

    def __init__(
        self, along: FloatArray, edges: tuple[float, float], depth: float, height: float, radius: float
    ) -> None:
        self.along = np.array(along, dtype=np.float64)
        self._before, self._edge = edges[0], 0.5 * (edges[0] + edges[1])
        self._depth, self._height, self._radius = depth, height, radius
        self._root = math.sqrt(GRAVITY * height)
        self._way = np.array([*self.along, 0.0])
        self.edges = np.full(2, math.nan)
        self._looked, self._beyond = np.zeros(2, dtype=bool), np.zeros(4, dtype=bool)
        self.shift, self.done, self.failed, self.leading = np.zeros(2), False, False, 0
        self.probe: FootProbe | None = None
        self._stage: Callable[[], None] = self._shift
        self._foot, self._began, self._time, self._elapsed = -1, math.nan, math.nan, 0.0
        self._joined = False
        self._since = math.nan

    def update(
        self, time: float, com: FloatArray, flow: FloatArray, ground: FloatArray, soles: FloatArray,
        carrying: BoolArray,
    ) -> None:  # fmt: skip
        """Go on with the search.

        Parameters
        ----------
        time
            Now [s].
        com, flow
            (>= 2,) centre of mass [m] and velocity of the body [m/s], world axes.
        ground, soles
            (4, 3) where feet stand, and the lowest points of the feet [m].
        carrying
            (4,) which feet carry.
        """
        if self.done or self.failed:
            return
        if math.isnan(self._began):
            self._began = self._since = self._time = time
        self._elapsed, self._time = time - self._time, time
        self._rest = com[:2] + flow[:2] * math.sqrt(self._height / GRAVITY)  # a pendulum comes to rest there
        self._flow, self._ground, self._soles, self._carrying = flow, ground, soles, carrying
        if self._looked.all() and self.probe is None:
            self._stand(com[:2])
            return
        if self.probe is None and not self._look(ground):
            self.failed = True
            return
        off = self._move_for(self._foot)
        self._go(off)
        self._far = float(off @ self.along)
        normals, offsets = inwards(self._triangle(self._foot))
        self._inside = min(float((normals @ place - offsets).min()) for place in (self._rest, com[:2]))
        self._stage()

    def _group(self, foot: int) -> int:
        """Return which edge a foot finds."""
        return int(self._beyond[foot])

    def _triangle(self, foot: int) -> FloatArray:
        """Return where the other feet stand, (3, 2) [m]."""
        return np.delete(self._ground[:, :2], foot, axis=0)

    def _wanted(self, foot: int) -> float:
        """Return how far along the way the body should be for a foot to reach its edge [m]."""
        share = FRONT_AHEAD if self._beyond[foot] else FRONT_BEFORE if foot < FRONT else HIND_AHEAD
        return self._edge + share * self._height

    def _move_for(self, foot: int) -> FloatArray:
        """Return how far (2,) the body should go on from where it comes to rest, for a foot [m]."""
        forward = max(self._wanted(foot) - float(self._rest @ self.along), 0.0) * self.along
        return (
            moved_inside(self._triangle(foot), self._rest + forward, 1.3 * MARGIN * self._height) - self._rest
        )

    def _look(self, ground: FloatArray) -> bool:
        """Choose a foot that is drawn next, as feet stand, (4, 3) [m]: one may have slid off the edge.

        Return whether there is one.
        """
        beyond = ground[:, 2] < ground[:, 2].max() - 0.5 * self._depth
        if self._foot >= 0 and (beyond == self._beyond).all():
            return True
        self._beyond = beyond
        moves = np.array([self._move_for(k) for k in range(len(ground))])
        wanted = np.array([self._wanted(k) for k in range(len(ground))])
        short = np.maximum(wanted - (self._rest + moves) @ self.along, 0.0)
        near = np.hypot(*moves.T) / (USUAL_SHIFT * self._root) + short / SHORT
        lasts = near - ground[:, :2] @ self.along / (0.5 * DRAWN)
        groups = [
            np.flatnonzero(beyond == group).tolist()
            for group in (False, True)
            if not self._looked[int(group)]
        ]
        soonest = [min(feet, key=lasts.__getitem__) for feet in groups if feet]  # of each edge's
        self._foot = int(min(soonest, key=near.__getitem__, default=-1))
        return bool(soonest)

    def _go(self, off: FloatArray) -> None:
        """Let the body go where it should be, (2,) from where it comes to rest [m]."""
        speed = math.hypot(*off) / SHIFT_TIME
        self.shift = off / SHIFT_TIME * min(1.0, SHIFT_SPEED * self._root / max(speed, 1e-9))

    def _stand(self, com: FloatArray) -> None:
        """Let the body stand over the feet that carry first when the walk goes on."""
        across = self._ground[:, :2] @ self.along
        self.leading = int(across[1] + across[2] < across[0] + across[3])  # the diagonal that is behind
        self._go(to_diagonal(self._rest, self._ground, self.leading, MIDDLE))
        off = math.hypot(*to_diagonal(com, self._ground, self.leading, MIDDLE))
        self.done = off < NEARLY_OVER * self._height and math.hypot(*self._flow[:2]) < CALM * self._root
        self.done |= self._time - self._since > LONGEST_SHIFT

    def _enter(self, stage: Callable[[], None]) -> None:
        """Go on with another stage."""
        self._stage, self._since = stage, self._time

    def _shift(self) -> None:
        """Wait until the other feet can carry the body."""
        calm = math.hypot(*self._flow[:2]) < CALM * self._root
        ready = self._inside > MARGIN * self._height and self._far < REACHED * self._height
        if self._carrying.all() and calm and ready:
            self._target = self._soles[self._foot].copy()
            self._origin, self._tread = float(self._target[:2] @ self.along), float(self._target[2])
            self._enter(self._lift)
            self._move(RISING * UP)
        elif self._time - self._since > LONGEST_SHIFT:
            self.failed = True

    def _move(self, velocity: FloatArray, down: bool = False) -> None:
        """Tell the foot where to be, and (3,) how fast [m/s]."""
        self.probe = FootProbe(self._foot, self._target.copy(), velocity, down)

    def _lift(self) -> None:
        """Lift the foot."""
        self._target += RISING * self._elapsed * UP
        self._move(RISING * UP)
        if self._target[2] > self._tread + LIFTED:
            self._enter(self._lower)

    def _lower(self) -> None:
        """Let it down until it touches its tread again."""
        self._target -= LOWERING * self._elapsed * UP
        self._move(-LOWERING * UP)
        if self._soles[self._foot, 2] - self._target[2] > TOUCHED:
            self._tread = self._level()
            self._speed, self._was = 0.0, float(self._soles[self._foot, :2] @ self.along)
            self._enter(self._draw)
        elif self._target[2] < self._tread - HIGH:
            self._return(self._origin, 0.0)

    def _level(self) -> float:
        """Return the foot's height over that of the others: what the estimated height is off by is common."""
        return float(self._soles[self._foot, 2] - self._soles[self._carrying, 2].mean())

    def _draw(self) -> None:
        """Draw it forward until it sinks."""
        s, z, dt = float(self._soles[self._foot, :2] @ self.along), self._level(), self._elapsed
        self._speed += ((s - self._was) / max(dt, 1e-6) - self._speed) * min(dt / SMOOTH, 1.0)
        self._was = s
        speed = DRAWN if s < self._soonest() else NEAR_EDGE
        if abs(z - self._tread) < NEARLY:
            self._tread += (z - self._tread) * dt / FOLLOWED
        base = float(self._soles[self._carrying, 2].mean())
        before = float(self._target[:2] @ self.along)
        self._target += (min(before + speed * dt, s + LEADING) - before) * self._way
        self._target[2] = self._tread + base - PUSHED
        if self._joined:  # over long ways what friction lacks to one side adds up
            self._target[2] = max(self._target[2], z + base - PRESSED)
        self._move(speed * self._way)
        if z < self._tread - SUNK:
            rest_of = self._radius - (self._tread - z)
            behind = math.sqrt(max(self._radius**2 - rest_of**2, 0.0)) + LATE * max(self._speed, 0.0)
            self._find(s - behind, base)
        elif (
            z > self._tread + STUCK
            or s - float(self._rest @ self.along) > FARTHEST * self._height
            or self._late()
        ):
            self._return(min(s - BEFORE, max(self._origin, s - 0.5 * self._height)), base)

    def _soonest(self) -> float:
        """Return the least place of the foot's edge along the way [m]."""
        return float(
            self._before if self._group(self._foot) == 0 else self.edges[0] + LEAST_TREAD * self._height
        )

    def _late(self) -> bool:
        """Return whether it takes too long."""
        return self._time - self._began > LONGEST

    def _find(self, edge: float, base: float) -> None:
        """Take in where an edge is; `base` is the height of the other feet [m]."""
        foot = self._foot
        if self._beyond[foot] or foot >= FRONT:
            self.edges[self._group(foot)] = edge
            self._return(edge - BEFORE, base)
            return
        self._edge, self._before, self._began, self._joined = edge, edge - NEAR, self._time, True
        self._step_to(edge + BEHIND, base)  # a front foot joins the other one
        self._bottom -= self._depth

    def _return(self, place: float, base: float) -> None:
        """Let the foot go back to a place along the way; `base` is the height of the others [m]."""
        self._looked[self._group(self._foot)] = True
        self._step_to(place, base)

    def _step_to(self, place: float, base: float) -> None:
        """Let the foot step to a place along the way; `base` is the height of the others [m]."""
        self._place, self._tread = place, self._tread + base
        self._bottom = self._tread - HIGH
        self._enter(self._step)

    def _step(self) -> None:
        """Let it step before the edge, or behind it."""
        target, tread = self._target, self._tread
        far = self._place - float(target[:2] @ self.along)
        down = abs(far) < NEAR
        velocity = np.zeros(3)
        if target[2] < tread + 0.5 * HIGH and not down:
            velocity[2] = RETURN
        else:
            velocity += math.copysign(min(RETURN, abs(far) / 0.05), far) * self._way
            velocity[2] = -LOWERING if down else (tread + HIGH - target[2]) / 0.05
        self._target = target + velocity * self._elapsed
        self._target[2] = max(self._target[2], self._bottom)
        self._move(velocity, down)
        if self._carrying[self._foot]:
            self.probe, self._foot = None, -1
            self.failed = bool(self._looked[0] and math.isnan(self.edges[0])) or self._late()
            self.done = bool(self._looked.all()) and not (self.failed or self._joined)
            self._enter(self._shift)
