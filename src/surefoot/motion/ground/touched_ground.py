"""Ground known by touch alone: the plane through the last footholds, and a drop that a foot has found.

A foot that finds no ground where it should be, down to below steps that matter, has found a drop (`Ledge`).
All that touch shows of it are stands: up to the farthest one before it the ground is level, the least far
one beyond it lies lower, and the edge is somewhere between. What a robot does about it is said in
`behaviours.stop_at_drop`. Steps up are ground like any other, which the plane follows late.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import base_velocity, heading_of
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.ground.ground_settings import GROUND_ESTIMATE, TOUCHED_GROUND
from surefoot.motion.state import RobotState


class Ledge:
    """An edge behind which the ground is lower, along a direction.

    Parameters
    ----------
    along
        (2,) unit vector towards the drop, across its edge.
    before, beyond
        Where along it feet stand, and where one found nothing [m].
    level, depth
        Height of the ground before the drop, and how much lower a foot has been so far [m].
    height
        Of the centre of mass above the ground [m].
    radius
        Of the feet [m].

    Attributes
    ----------
    along, level
        As given.
    depth
        Of the drop [m].
    found
        Whether a foot has stood on the ground beyond it.

    Examples
    --------
    >>> ledge = Ledge(np.array([1.0, 0.0]), 0.5, 0.6, 0.0, 0.07, 0.3, 0.02)
    >>> ledge.stand(0.6, -0.12)
    >>> ledge.shallow, ledge.height([0.4, 0.7]).tolist()
    (False, [0.0, -0.12])
    """

    def __init__(
        self, along: FloatArray, before: float, beyond: float, level: float, depth: float, height: float,
        radius: float,
    ) -> None:  # fmt: skip
        self.along, self.level, self.depth = np.array(along, dtype=np.float64), level, depth
        self._before, self._beyond, self._farthest = before, max(beyond, before), -math.inf
        self._height, self._radius = height, radius
        self.found = False

    @staticmethod
    def begins(depth: float, height: float) -> bool:
        """Return whether a foot that is so deep below the ground it expected [m] may be over a drop."""
        return depth > GROUND_ESTIMATE.low * height

    @property
    def edge(self) -> float:
        """Place of the edge along the way [m]."""
        return 0.5 * (self._before + self._beyond)

    @property
    def shallow(self) -> bool:
        """Whether the ground beyond has been found, and is no lower than after a small step."""
        return self.found and self.depth < TOUCHED_GROUND.drop * self._height

    @property
    def certain(self) -> bool:
        """Whether it is certain that the drop is not a small step."""
        return self.depth > TOUCHED_GROUND.drop * self._height and (
            self.found or self.depth > TOUCHED_GROUND.bottomless * self._height
        )

    def deeper(self, along: float, height: float) -> None:
        """Learn that a foot at a place has gone down to a height without finding ground [m]."""
        if not self.found:
            self.depth = max(self.depth, self.level - height)
            self._beyond = max(min(self._beyond, along), self._before)

    def stand(self, along: float, height: float) -> None:
        """Learn that a foot stands at a place along the way and at a height [m]."""
        below = self.level - height
        if not self.found and below > 0.5 * self.depth:
            self.depth, self.found = below, True
        if abs(below) < TOUCHED_GROUND.like * self.depth:
            self._before = max(self._before, min(along, self._beyond))
        elif self.found and abs(below - self.depth) < TOUCHED_GROUND.like * self.depth:
            self._beyond = max(min(self._beyond, along), self._before)
            self._farthest = max(self._farthest, along)

    def height(self, along: ArrayLike) -> FloatArray:
        """Return the height of the ground at (...) places along the way [m]: (...)."""
        return np.where(np.asarray(along, dtype=np.float64) < self.edge, self.level, self.level - self.depth)

    def nearest(self, place: FloatArray) -> FloatArray:
        """Return the (2,) place nearest to one at which a foot may stand: where feet have stood [m]."""
        along = float(place @ self.along)
        top = self._before - 0.5 * self._radius
        sure = self._beyond + TOUCHED_GROUND.sure_tread * self._height - 2.0 * self._radius
        below = min(max(along, self._beyond, self.edge + TOUCHED_GROUND.reach), max(self._farthest, sure))
        goal = along if along <= top else top if along - top < below - along else below
        return place + (goal - along) * self.along


class TouchedGround(BeliefTerrain):
    """What feet have found, see the module.

    Attributes
    ----------
    drop
        The edge at which the ground falls off, None where there is none.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> ground = TouchedGround()
    >>> feet = np.array([[0.2, 0.1, 0.02], [0.2, -0.1, 0.02], [-0.2, 0.1, -0.02], [-0.2, -0.1, -0.02]])
    >>> ground.begin(SimpleNamespace(q=np.zeros(7), v=np.zeros(6), time=0.0, scan=None), feet, 0.3)
    >>> ground.height([0.4, 0.0]).round(3), ground.gradient([0.4, 0.0]).round(3) + 0.0
    (np.float64(0.04), array([0.1, 0. ]))
    """

    MEMORY = ("drop", "_heading", "_expected", "_slid")

    finds_drops = TOUCHED_GROUND.finds_drops

    def __init__(self) -> None:
        self._about, self._level, self._slope = np.zeros(2), 0.0, np.zeros(2)
        self.drop: Ledge | None = None

    def __repr__(self) -> str:
        return "TouchedGround()"

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """See `BeliefTerrain.begin`."""
        self.drop = None
        self._heading = np.array([1.0, 0.0])
        self._expected: dict[int, float] = {}
        self._slid: set[int] = set()
        super().begin(state, ground, height)

    @property
    def unsure(self) -> bool:
        """See `BeliefTerrain.unsure`: near a drop."""
        return self.drop is not None

    def observe(
        self, state: RobotState, ground: FloatArray, stance: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """See `BeliefTerrain.observe`."""
        self._heading = heading_of(state.q[3:7])
        if self.finds_drops and (self._expected or sought.any()):
            self._look_down(base_velocity(state.q, state.v), ground, stance, sought, soles)
        super().observe(state, ground, stance, sought, soles)
        if self.drop is not None and stance.all() and not self.drop.found:
            self.drop = None

    def _look_down(
        self, flow: FloatArray, ground: FloatArray, stance: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """Learn from feet that go on down where the ground should be.

        `flow` (3,) is the body's velocity [m/s], the rest as for `observe`.
        """
        late = np.flatnonzero(sought).tolist()
        self._expected = {k: self._expected.get(k, float(self.height(soles[k, :2]))) for k in late}
        self._slid = {k for k in late if self._stood[k] or k in self._slid}
        for k in late:
            sole, level = soles[k], self._expected[k]
            if self.drop is not None:
                self.drop.deeper(float(sole[:2] @ self.drop.along), float(sole[2]))
            elif Ledge.begins(level - sole[2], self._height):
                moved = (
                    flow[:2]
                    if math.hypot(flow[0], flow[1]) > TOUCHED_GROUND.unmoved
                    else sole[:2] - ground[k, :2]
                )
                along = self._way(moved)
                before = float((ground[stance, :2] @ along).max(initial=-math.inf))
                last, beyond = float(ground[k, :2] @ along), float(sole[:2] @ along)
                if k in self._slid:  # off the edge: it stood on it
                    last, beyond = last - self.radius, last
                depth = level - float(sole[2])
                self.drop = Ledge(along, max(before, last), beyond, level, depth, self._height, self.radius)

    def _way(self, moved: FloatArray) -> FloatArray:
        """Return the body's axis (2,) nearest to a way (2,) [m]."""
        axes = np.array([self._heading, [-self._heading[1], self._heading[0]]])
        axis = max(axes, key=lambda a: abs(float(moved @ a)))
        return np.asarray(math.copysign(1.0, float(moved @ axis)) * axis)

    def _learn_touchdown(self, point: FloatArray) -> None:
        """Learn where a foot stands: on the ground about a drop, which may be none."""
        if self.drop is not None:
            self.drop.stand(float(point[:2] @ self.drop.along), float(point[2]))
            if self.drop.shallow:
                self.drop = None

    def _use_plane(self) -> None:
        """See `BeliefTerrain`; the plane is read as it is."""

    @property
    def steepness(self) -> float:
        """Of a drop [-]."""
        return 0.0 if self.drop is None else self.drop.depth / (TOUCHED_GROUND.steep_tread * self._height)

    @property
    def highest_step(self) -> float:
        """Depth of a drop [m]."""
        return 0.0 if self.drop is None else self.drop.depth

    def steps_until(self, place: FloatArray, along: FloatArray) -> float:
        """See `Terrain.steps_until`: no edge of steps is known."""
        return -math.inf

    def noise_at(self, xy: FloatArray) -> float:
        """See `Terrain.noise_at`."""
        return 0.0 if self.drop is None else TOUCHED_GROUND.noise

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the expected height under (..., 2) places [m]: (...)."""
        places = np.asarray(xy, dtype=np.float64)
        if self.drop is not None:
            return self.drop.height(places @ self.drop.along)
        above = (places - self._about) @ self._slope
        return np.asarray(self._level + above)

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope [-] at (..., 2) places [m]: (..., 2)."""
        slope = self._slope if self.drop is None else np.zeros(2)
        return np.broadcast_to(slope, np.shape(xy)).copy()
