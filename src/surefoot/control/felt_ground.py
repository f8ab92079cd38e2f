"""Ground that feet alone have felt: a plane, and steps up once a foot has struck a riser.

A foot that strikes a riser tells where the first edge is. The body slows down, and the next foot is lifted
higher than steps are likely to be and let down gently behind the edge, which tells their height. On that
tread the front feet feel their way ahead in short swings, slow enough to meet the next riser softly, which
tells how deep the treads are [1]_. From then on the steps are known as seen ones are: the body waits until
its gait is in step with them, every stand and every strike corrects where they are, and a foot that finds
the ground one step too low has found their end.

A foot that finds no ground where it should be, down to below steps that matter, stops the walk (`FeltDrop`).

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
from surefoot.control.controller import RobotState
from surefoot.control.felt_drop import FeltDrop
from surefoot.control.stair_gait import LOW
from surefoot.control.swing import DOWN_LAST, LIFT_FIRST, minimum_jerk
from surefoot.control.terrain_knowledge import FLIGHT_NOISE, SEEN_SPEED, TouchedGround
from surefoot.control.walking_feet import SEARCH_SPEED
from surefoot.estimation.felt_flight import FeltFlight
from surefoot.spatial import base_velocity, heading_of

GUESSED_RISE, GUESSED_TREAD = 0.45, 0.9
"""What a step and a tread are taken for before they have been felt, in heights of the centre of mass."""
LEAST_TREAD, DEEPEST_TREAD = 0.6, 1.5
"""No tread is taken to be less deep, and one that turns out to be deeper ends the steps, likewise."""
IGNORED = 4.0
"""After steps that turned out to be low ones nothing is made of risers for so long [s]."""
MISSES = 4
"""Steps are none after so many stands in turn that fit nothing."""
FORWARD = 0.7
"""A strike tells of a riser across the heading if this share of its speed is along the heading."""
FEELING, CATCHING_UP, BEHIND = 0.1, 0.3, 1.15
"""Shares of its speed with which the body goes on while feet feel for steps: as long as it is so near behind
the farthest foot, in heights of the centre of mass, and farther behind."""
RETREAT = 0.3
"""Share of its speed with which the body leaves a drop."""
UNMOVED = 0.1
"""A slower body does not tell which way a drop lies [m/s]."""
LEAD = 1.8
"""`lead` of a foot that falls into a drop."""
GENTLE_SPEED = 0.03
"""`search_speed` at a drop."""
DROP_NOISE = 0.02
"""By how much the ground about a drop may be off [m]."""
SOFT = 0.42
"""Speed at which a foot may strike what it feels for [m/s]: in a millisecond it goes half of what counts as
touching."""
REACH = 0.75
"""How far beyond its place a foot feels for a riser, in heights of the centre of mass."""
FARTHEST = 0.1
"""The farthest that it goes beyond ground that is known in one swing [m]."""
MOVING = DOWN_LAST - LIFT_FIRST
"""Share of a swing in which the foot moves along the ground."""
GONE, SPEEDS = np.array([minimum_jerk(share)[:2] for share in np.linspace(0.0, 1.0, 101)]).T
FASTEST = np.maximum.accumulate(SPEEDS[::-1])[::-1]
"""Share of its way that a swing has gone, its speed there, and the highest speed from there on."""


def soft_way(known: float, most: float) -> float:
    """Return how far beyond a free way of `known` [m] a foot may swing to meet a riser softly [m].

    Parameters
    ----------
    known
        Way on which nothing stands in its way [m].
    most
        Highest speed of a strike times the duration of the swing [m].

    Examples
    --------
    >>> [round(soft_way(known, 0.1), 3) for known in (0.0, 0.05)]
    [0.044, 0.01]
    """
    ways = known + np.linspace(0.0, FARTHEST, 101)
    fastest = np.interp(known / np.maximum(ways, 1e-9), GONE, FASTEST)
    return float(ways[ways * fastest <= MOVING * most].max(initial=known)) - known


class FeltGround(TouchedGround):
    """What feet have felt, see the module.

    Attributes
    ----------
    flight
        The steps up, None where there are none.
    drop
        The edge at which the ground falls off, None where there is none.
    """

    def __init__(self) -> None:
        super().__init__()
        self.flight: FeltFlight | None = None
        self.drop: FeltDrop | None = None
        self._said: str | None = None

    def __repr__(self) -> str:
        return "FeltGround()"

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """See `GroundBelief.begin`."""
        self._forget()
        self._heading, self._time = np.array([1.0, 0.0]), state.time
        self._struck: tuple[FloatArray, FloatArray] | None = None
        self._ignored_until = -math.inf
        self._expected: dict[int, float] = {}
        self._slid: set[int] = set()
        self._asked = False
        if self._said in self.notes:
            self.notes.remove(self._said)
        self._said = None
        super().begin(state, ground, height)

    def _forget(self) -> None:
        """Believe in a plane again."""
        self.flight, self.drop, self.unsure, self.pace = None, None, False, 1.0
        self.search_speed, self._felt_to = SEARCH_SPEED, -math.inf
        self.careful = self.standing = False
        self.leading = 0

    def may_strike(self, sole: FloatArray, velocity: FloatArray) -> bool:
        """See `GroundBelief.may_strike`: of known steps only a riser that is higher than the foot."""
        flight = self.flight
        if self.drop is not None or (flight is not None and flight.tread_known):
            ahead = self.height(self._path_ahead(sole, velocity))
            if float(ahead.max()) < sole[2] + 0.5 * self.radius:
                return False
        self._struck = sole.copy(), velocity.copy()
        return True

    def stumbled(self, time: float) -> None:
        """See `GroundBelief.stumbled`: what was struck is a riser."""
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
            self.flight, self._felt_to = FeltFlight(along, edge, level, *guesses), edge
        else:
            self.flight.strike(float(sole[:2] @ self.flight.along) + self.radius)
        self.unsure, self.search_speed = not self.flight.tread_known, SEEN_SPEED

    def observe(
        self, state: RobotState, ground: FloatArray, carrying: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """See `GroundBelief.observe`."""
        self._heading = heading_of(state.q[3:7])
        falling = self.flight is None and (self._expected or sought.any())
        flow = base_velocity(state.q, state.v) if falling or self.drop is not None else np.zeros(3)
        if falling:
            self._look_down(flow, ground, carrying, sought, soles)
        super().observe(state, ground, carrying, sought, soles)
        if self.drop is not None:
            self._mind(self.drop, state, flow, ground, carrying)
        flight = self.flight
        if flight is not None:
            self.lift = 0.0  # feet are lifted over edges that are known
            flight.pass_time(state.time - self._time)
            place = float(state.q[:2] @ flight.along)
            near = self._felt_to - place < BEHIND * self._height
            self.pace = FEELING if near else CATCHING_UP
            if flight.ended and place - flight.edge(flight.last) > DEEPEST_TREAD * self._height:
                self._forget()
        self._time = state.time

    def _look_down(
        self, flow: FloatArray, ground: FloatArray, carrying: BoolArray, sought: BoolArray, soles: FloatArray
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
            elif FeltDrop.begins(level - sole[2], self._height):
                moved = flow[:2] if math.hypot(flow[0], flow[1]) > UNMOVED else sole[:2] - ground[k, :2]
                along = self._way(moved)
                before = float((ground[carrying, :2] @ along).max(initial=-math.inf))
                last, beyond = float(ground[k, :2] @ along), float(sole[:2] @ along)
                if k in self._slid:  # off the edge: it stood on it
                    last, beyond = last - self.radius, last
                told = max(before, last), beyond, level, level - float(sole[2])
                self.drop = FeltDrop(along, *told, self._height, self.radius)
                self.unsure = True

    def _axes(self) -> FloatArray:
        """Return the body's axes forward and left in the ground's plane, (2, 2) by rows."""
        return np.array([self._heading, [-self._heading[1], self._heading[0]]])

    def _way(self, moved: FloatArray) -> FloatArray:
        """Return the body's axis (2,) nearest to a way (2,) [m]."""
        axis = max(self._axes(), key=lambda a: abs(float(moved @ a)))
        return np.asarray(math.copysign(1.0, float(moved @ axis)) * axis)

    def _mind(
        self, drop: FeltDrop, state: RobotState, flow: FloatArray, ground: FloatArray, carrying: BoolArray
    ) -> None:
        """Say why the body stops before a drop, and forget it once it is shallow or far."""
        if drop.left(ground) or (carrying.all() and not drop.found):
            self._forget()
            return
        self.pace, self.lift = RETREAT, 0.0
        self.search_speed, self.careful = GENTLE_SPEED, True
        self.lead = 0.0 if drop.found else LEAD
        drop.rest(state.q[:2], flow[:2], ground, carrying, self._asked)
        self.standing, self.leading = drop.standing, drop.leading
        if drop.told and self._said is None:
            self._said = drop.note(state.time)
            self.notes.append(self._said)

    def allowed(self, command: FloatArray) -> FloatArray:
        """See `GroundBelief.allowed`: nothing leads on towards a drop."""
        if self.drop is None:
            return command
        turned = self._axes()
        slowed, turn = self.drop.slowed(command[:2] @ turned), 0.0 if self.drop.astride else command[2]
        self._asked = bool(slowed.any() or turn != 0.0)
        if self.drop.standing:
            slowed, turn = self.drop.shift() / self.pace, 0.0
        return np.array([*(turned @ slowed), turn])

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
            self._felt_to = max(self._felt_to, s + self.radius)
        self.unsure = not flight.tread_known
        low = flight.rise_known and flight.rise < LOW * self._height
        if low:
            self._ignored_until = self._time + IGNORED
        deep = self.unsure and self._felt_to - flight.edge(0) > DEEPEST_TREAD * self._height
        if low or deep or flight.misses >= MISSES:
            self._forget()

    def feel_ahead(self, place: FloatArray, start: FloatArray, duration: float) -> FloatArray:
        """See `GroundBelief.feel_ahead`: onto the first tread, and from there on to the next riser."""
        flight, drop = self.flight, self.drop
        if drop is not None:
            s = float(place @ drop.along)
            return np.asarray(place + (drop.nearest(s, float(start[:2] @ drop.along)) - s) * drop.along)
        if flight is None or not self.unsure or not flight.rise_known:
            return place
        s, begun = float(place @ flight.along), float(start[:2] @ flight.along)
        if begun < flight.edge(0):
            aim = min(s, flight.edge(0) + LEAST_TREAD * self._height - 2.0 * self.radius)
        else:
            known = max(self._felt_to - self.radius - begun, 0.0)
            aim = begun + known + soft_way(known, SOFT * duration)
            aim = min(aim, s + REACH * self._height)
        return np.asarray(place + (aim - s) * flight.along)

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
        return 0.0 if self.flight is None else FLIGHT_NOISE

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
