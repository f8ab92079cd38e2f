"""Ground known by touch alone: a plane, and steps up once a foot has struck a riser, or a drop.

A foot that strikes a riser shows where the first edge is, the next one that stands behind it how high a step
is, and the next riser how deep the treads are [1]_. From then on the steps are known as seen ones are: every
stand and every strike corrects where they are, and a foot that finds the ground one step too low has found
their end. A foot that finds no ground where it should be, down to below steps that matter, has found a drop
(`Ledge`). What a robot does about all this is said in `surefoot.control.behaviours.steps_by_touch`.

References
----------
.. [1] M. Focchi et al., "Heuristic planning for rough terrain locomotion in presence of external disturbances
   and variable perception quality", in Advances in Robotics Research, Springer 2020 (a step reflex, without
   what is made of it here).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray
from surefoot.estimation.ground_belief import LOW, Sensed, TouchedGround
from surefoot.estimation.ledge import Ledge
from surefoot.estimation.touched_flight import TouchedFlight
from surefoot.spatial import base_velocity, heading_of

GUESSED_RISE, GUESSED_TREAD = 0.45, 0.9
"""What a step and a tread are taken for before they are known, in heights of the centre of mass."""
DEEPEST_TREAD = 1.5
"""A tread that turns out to be deeper ends the steps, likewise."""
IGNORED = 4.0
"""After steps that turned out to be low ones nothing is made of risers for so long [s]."""
MISSES = 4
"""Steps are none after so many stands in turn that fit nothing."""
FORWARD = 0.7
"""A strike shows a riser across the heading if this share of its speed is along the heading."""
UNMOVED = 0.1
"""A slower body does not show which way a drop lies [m/s]."""
DROP_NOISE, STEPS_NOISE = 0.02, 0.004
"""By how much the ground about a drop may be off, and steps whose edges and heights are known [m]."""


class TouchedSteps(TouchedGround):
    """What feet have found, see the module.

    Attributes
    ----------
    flight
        The steps up, None where there are none.
    drop
        The edge at which the ground falls off, None where there is none.
    reached
        The farthest along the steps that a foot has touched, to its radius [m].
    """

    finds_steps = True

    def __init__(self) -> None:
        super().__init__()
        self.flight: TouchedFlight | None = None
        self.drop: Ledge | None = None
        self.reached = -math.inf

    def __repr__(self) -> str:
        return "TouchedSteps()"

    def begin(self, state: Sensed, ground: FloatArray, height: float) -> None:
        """See `BeliefTerrain.begin`."""
        self._forget()
        self._heading, self._time = np.array([1.0, 0.0]), state.time
        self._struck: tuple[FloatArray, FloatArray] | None = None
        self._ignored_until = -math.inf
        self._expected: dict[int, float] = {}
        self._slid: set[int] = set()
        super().begin(state, ground, height)

    def _forget(self) -> None:
        """Believe in a plane again."""
        self.flight, self.drop, self.reached = None, None, -math.inf

    @property
    def unsure(self) -> bool:
        """See `BeliefTerrain.unsure`: until the second riser is known, and near a drop."""
        return self.drop is not None or (self.flight is not None and not self.flight.tread_known)

    @property
    def edges_known(self) -> bool:
        """See `BeliefTerrain.edges_known`."""
        return self.flight is not None or self.drop is not None

    def may_strike(self, sole: FloatArray, velocity: FloatArray) -> bool:
        """See `BeliefTerrain.may_strike`: of known steps only a riser that is higher than the foot."""
        flight = self.flight
        if self.drop is not None or (flight is not None and flight.tread_known):
            ahead = self.height(self._path_ahead(sole, velocity))
            if float(ahead.max()) < sole[2] + 0.5 * self.radius:
                return False
        self._struck = sole.copy(), velocity.copy()
        return True

    def stumbled(self, time: float) -> None:
        """See `BeliefTerrain.stumbled`: what was struck is a riser."""
        super().stumbled(time)
        struck, self._struck = self._struck, None
        if struck is None or time < self._ignored_until:
            return
        sole, velocity = struck
        if self.drop is not None:
            self.drop.struck(float(sole[:2] @ self.drop.along))
            return
        if self.flight is None:
            way = float(velocity[:2] @ self._heading)
            if abs(way) < FORWARD * math.hypot(velocity[0], velocity[1]):
                return
            along, level = math.copysign(1.0, way) * self._heading, float(self.height(sole[:2]))
            edge = float(sole[:2] @ along) + self.radius
            guesses = GUESSED_RISE * self._height, GUESSED_TREAD * self._height
            self.flight, self.reached = TouchedFlight(along, edge, level, *guesses), edge
        else:
            self.flight.strike(float(sole[:2] @ self.flight.along) + self.radius)

    def observe(
        self, state: Sensed, ground: FloatArray, stance: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """See `BeliefTerrain.observe`."""
        self._heading = heading_of(state.q[3:7])
        if self.flight is None and (self._expected or sought.any()):
            self._look_down(base_velocity(state.q, state.v), ground, stance, sought, soles)
        super().observe(state, ground, stance, sought, soles)
        drop, flight = self.drop, self.flight
        if drop is not None and (drop.left(ground) or (stance.all() and not drop.found)):
            self._forget()
        if flight is not None:
            flight.pass_time(state.time - self._time)
            place = float(state.q[:2] @ flight.along)
            if flight.ended and place - flight.edge(flight.last) > DEEPEST_TREAD * self._height:
                self._forget()
        self._time = state.time

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
                moved = flow[:2] if math.hypot(flow[0], flow[1]) > UNMOVED else sole[:2] - ground[k, :2]
                along = self._way(moved)
                before = float((ground[stance, :2] @ along).max(initial=-math.inf))
                last, beyond = float(ground[k, :2] @ along), float(sole[:2] @ along)
                if k in self._slid:  # off the edge: it stood on it
                    last, beyond = last - self.radius, last
                depth = level - float(sole[2])
                self.drop = Ledge(along, max(before, last), beyond, level, depth, self._height, self.radius)

    @property
    def axes(self) -> FloatArray:
        """The body's axes forward and left in the ground's plane, (2, 2) by rows."""
        return np.array([self._heading, [-self._heading[1], self._heading[0]]])

    def _way(self, moved: FloatArray) -> FloatArray:
        """Return the body's axis (2,) nearest to a way (2,) [m]."""
        axis = max(self.axes, key=lambda a: abs(float(moved @ a)))
        return np.asarray(math.copysign(1.0, float(moved @ axis)) * axis)

    def _touched(self, point: FloatArray) -> None:
        """Learn where a foot stands."""
        if self.drop is not None:
            self.drop.stand(float(point[:2] @ self.drop.along), float(point[2]))
            if not self.drop.shallow:
                return
            self._forget()
        flight = self.flight
        if flight is None:
            super()._touched(point)
            return
        s = float(point[:2] @ flight.along)
        flight.stand(s, float(point[2]))
        if s > flight.edge(0):
            self.reached = max(self.reached, s + self.radius)
        low = flight.rise_known and flight.rise < LOW * self._height
        if low:
            self._ignored_until = self._time + IGNORED
        deep = not flight.tread_known and self.reached - flight.edge(0) > DEEPEST_TREAD * self._height
        if low or deep or flight.misses >= MISSES:
            self._forget()

    @property
    def steepness(self) -> float:
        """Rise over tread of the steps [-]."""
        if self.drop is not None:
            return self.drop.depth / (GUESSED_TREAD * self._height)
        return 0.0 if self.flight is None else self.flight.rise / self.flight.tread

    @property
    def highest_step(self) -> float:
        """Height of the steps [m]."""
        if self.drop is not None:
            return self.drop.depth
        return 0.0 if self.flight is None else self.flight.rise

    def steps_until(self, place: FloatArray, along: FloatArray) -> float:
        """See `Terrain.steps_until`: the last edge that is believed in."""
        flight = self.flight
        if flight is None:
            return -math.inf
        s = float(place @ flight.along)
        return flight.edge(flight.last) - s if along @ flight.along >= 0.0 else s - flight.edge(0)

    def noise_at(self, xy: FloatArray) -> float:
        """See `Terrain.noise_at`."""
        if self.drop is not None:
            return DROP_NOISE
        return 0.0 if self.flight is None else STEPS_NOISE

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the expected height under (..., 2) places [m]: (...)."""
        if self.drop is not None:
            return self.drop.height(np.asarray(xy, dtype=np.float64) @ self.drop.along)
        if self.flight is None:
            return super().height(xy)
        return self.flight.height(np.asarray(xy, dtype=np.float64) @ self.flight.along)

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the slope [-] at (..., 2) places [m]: (..., 2)."""
        plane = self.flight is None and self.drop is None
        return super().gradient(xy) if plane else np.zeros(np.shape(xy))
