"""What a walking robot believes about the ground that nobody has told it: from a range sensor, or from touch.

A belief is a `Terrain` that learns: whoever plans footholds, swings or the body's pose on it does not see the
difference. All of it lives in the estimated frame, in which the robot knows its own place.

========  =====================================================================================
exact     the controller is given the true terrain
map       `MappedGround`: a height map from a range sensor, corrected where feet stand
blind     `FeltGround`: a plane through the last footholds (`TouchedGround`), and steps that feet feel
========  =====================================================================================
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray
from surefoot.control.caution import Caution
from surefoot.control.controller import RobotState
from surefoot.control.step_detection import StepWatch
from surefoot.errors import ProblemError, unknown_name
from surefoot.estimation.elevation_kernels import flight_heights
from surefoot.estimation.elevation_map import ElevationMap, MapSettings
from surefoot.spatial import rotation_from_quaternion
from surefoot.terrain import Terrain

KNOWLEDGE = ("exact", "map", "blind")
"""What a controller may know about the terrain."""
REMEMBERED = 0.3
"""How long the robot remembers where its base was, for scans that come late [s]."""
LANDINGS = 3
"""How many landings of each foot the plane under the feet goes through."""
FORGETTING = 0.7
"""Weight of a foot's landing against its next one."""
DAMPING = 1e-4
"""Pull of the plane's slopes to zero where footholds do not tell them [m²]."""
SMOOTH = 0.004
"""Distances of footholds from their plane that count as flat ground [m]."""
ROUGH_LIFT = 1.5
"""Height by which a blind foot is lifted more, over the footholds' deviation from their plane."""
BIAS_GAIN, LARGEST_BIAS = 0.3, 0.3
"""Share of the error of an expected height by which the next are corrected, and the most, in body heights."""
STUMBLE_TIME = 4.0
"""How long a stumble is remembered [s]."""
FLIGHT_NOISE = 0.004
"""By how much stairs may be off whose edges and feet have told where they are [m]."""
STRIKE_REACH, STRIKE_NOISE = 0.25, 2.0
"""A foot over seen ground strikes what is so near before it, in heights of the centre of mass, and no lower
than this many times the noise below its sole."""
SEEN_SPEED = 0.15
"""`GroundBelief.search_speed` on ground that has been seen: late feet are near it."""
HIGHEST_LIFT = 0.25
"""Most that feet are lifted more, in heights of the centre of mass."""
STUMBLE_LIFT = 0.2
"""By how much they are lifted more after a stumble, likewise."""


class GroundBelief(Caution, Terrain):
    """A terrain that learns from what the robot senses.

    Attributes
    ----------
    lift
        Height by which feet should be lifted more than over known ground [m].
    radius
        Of the feet [m].
    """

    learns = True
    lift: float = 0.0
    radius: float = 0.0

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """Start from where the robot stands.

        Parameters
        ----------
        state
            First state.
        ground
            (n, 3) contact points of the feet [m].
        height
            Of the centre of mass above them [m].
        """
        self._height = height
        self._only_now(ground)
        self._stood = np.ones(len(ground), dtype=bool)
        self._sought: dict[int, FloatArray] = {}
        self._stumbled = -math.inf
        self._spread = 0.0
        self.lift = 0.0
        self._fit()

    def observe(
        self, state: RobotState, ground: FloatArray, carrying: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """Learn from a step.

        Parameters
        ----------
        state
            What is sensed.
        ground
            (n, 3) where feet stand or last stood [m].
        carrying, sought
            (n,) which feet carry, and which look for the ground below them.
        soles
            (n, 3) lowest points of the feet [m].
        """
        landed = carrying & ~self._stood
        self._stood = carrying.copy()
        for k in np.flatnonzero(landed).tolist():
            self._landings[k].append(ground[k].copy())
            self._touched(ground[k])
        # where a foot looks for the ground, it is no higher than the foot
        self._sought = {k: soles[k] for k in np.flatnonzero(sought).tolist()}
        if landed.any() or sought.any():
            self._fit()
        calm = max(0.0, 1.0 - (state.time - self._stumbled) / STUMBLE_TIME)
        rough = ROUGH_LIFT * max(self._spread - SMOOTH, 0.0)
        stumble = STUMBLE_LIFT * self._height * min(2.0 * calm, 1.0)
        self.lift = min(max(rough, stumble), HIGHEST_LIFT * self._height)

    def _only_now(self, ground: FloatArray) -> None:
        """Remember no landings but where the feet stand now, (n, 3) [m]."""
        self._landings: list[deque[FloatArray]] = [deque([g.copy()], maxlen=LANDINGS) for g in ground]

    @property
    def slope(self) -> FloatArray:
        """Slope along x and y of the plane through the last footholds (2,) [-]."""
        return self._slope

    def stumbled(self, time: float) -> None:
        """Learn that a foot struck an edge at a time [s]."""
        self._stumbled = time

    def feel_ahead(self, place: FloatArray, start: FloatArray, duration: float) -> FloatArray:
        """Return where (2,) a foot lands to feel for steps [m], by its place (2,), start (>= 2,) and time."""
        return place

    def above(self, soles: FloatArray, asked: BoolArray) -> FloatArray:
        """Return how far (n, 3) soles are above the ground, of those `asked`, over what may be noise: (n,).

        Zero where nothing is known.
        """
        return np.zeros(len(soles))

    def may_strike(self, sole: FloatArray, velocity: FloatArray) -> bool:
        """Return whether there may be an edge before a foot: (3,) sole [m] and velocity [m/s]."""
        return True

    def _path_ahead(self, sole: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return places (5, 2) before a foot whose sole (3,) moves at a velocity (>= 2,) [m], [m/s]."""
        ways = np.linspace(0.0, STRIKE_REACH * self._height, 5)[:, None]
        return sole[:2] + ways * velocity[:2] / max(math.hypot(velocity[0], velocity[1]), 1e-6)

    def _fit(self) -> None:
        """Fit the plane under the feet."""
        places, weights = [], []
        for k, landings in enumerate(self._landings):
            known = [*landings, self._sought[k]] if k in self._sought else landings
            for age, place in enumerate(reversed(known)):
                places.append(place)
                weights.append(FORGETTING**age)
        points, shares = np.array(places), np.array(weights)
        about = points[:, :2].mean(axis=0)
        rows = np.column_stack([np.ones(len(points)), points[:, :2] - about])
        normal = (rows * shares[:, None]).T @ rows
        normal[1:, 1:] += DAMPING * np.eye(2)
        plane = np.linalg.solve(normal, rows.T @ (shares * points[:, 2]))
        off = points[:, 2] - rows @ plane
        self._spread = math.sqrt(float(shares @ off**2) / max(float(shares.sum()) - 3.0, 1.0))
        self._about, self._level, self._slope = about, float(plane[0]), plane[1:]
        self._fitted()

    def _touched(self, point: FloatArray) -> None:
        """Learn that a foot has landed at a (3,) point [m]."""

    @abstractmethod
    def _fitted(self) -> None:
        """Use a new plane: `_level` [m] at `_about`, `_slope`."""


class TouchedGround(GroundBelief):
    """The plane through the last footholds, by touch alone.

    Examples
    --------
    >>> ground = TouchedGround()
    >>> feet = np.array([[0.2, 0.1, 0.02], [0.2, -0.1, 0.02], [-0.2, 0.1, -0.02], [-0.2, -0.1, -0.02]])
    >>> ground.begin(RobotState(np.zeros(7), np.zeros(6)), feet, 0.3)
    >>> ground.height([0.4, 0.0]).round(3), ground.gradient([0.4, 0.0]).round(3) + 0.0
    (np.float64(0.04), array([0.1, 0. ]))
    """

    def __init__(self) -> None:
        super().__init__()
        self._about, self._level, self._slope = np.zeros(2), 0.0, np.zeros(2)
        self._bias = 0.0

    def __repr__(self) -> str:
        return "TouchedGround()"

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """See `GroundBelief.begin`."""
        self._bias = 0.0
        super().begin(state, ground, height)

    def _start_over(self, ground: FloatArray) -> None:
        """Believe in the plane through where the feet stand now, (n, 3) [m]."""
        self._bias = 0.0
        self._only_now(ground)
        self._fit()

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the expected height under (..., 2) places [m]: (...)."""
        above = (np.asarray(xy, dtype=np.float64) - self._about) @ self._slope
        return np.asarray(self._level + self._bias + above)

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the plane's slope [-] at (..., 2) places [m]: (..., 2)."""
        return np.broadcast_to(self._slope, np.shape(xy)).copy()

    def _touched(self, point: FloatArray) -> None:
        """Learn how far the ground lies above what was expected: the plane comes late onto stairs."""
        error = float(point[2] - self.height(point[:2]))
        most = LARGEST_BIAS * self._height
        self._bias = min(max(self._bias + BIAS_GAIN * error, -most), most)

    def _fitted(self) -> None:
        """See `GroundBelief`; the plane is read as it is."""


class MappedGround(GroundBelief):
    """A height map of what a range sensor has seen and feet have touched.

    Parameters
    ----------
    settings
        Of the map; None for the defaults.

    Attributes
    ----------
    map
        `ElevationMap`.
    watch
        For stairs.
    noise
        See there.
    """

    search_speed = SEEN_SPEED

    def __init__(self, settings: MapSettings | None = None) -> None:
        super().__init__()
        self.map = ElevationMap(settings)
        self.noise = self.map.noise
        self._poses: deque[tuple[float, FloatArray]] = deque()
        self.watch = StepWatch()
        self.map.see(np.zeros((1, 3)), np.ones(1))  # compiled now, not in the first step with a scan

    def __repr__(self) -> str:
        return f"MappedGround({self.map!r})"

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """See `GroundBelief.begin`."""
        self.map.begin(ground[:, :2].mean(axis=0), 0.0, np.zeros(2))
        self._poses.clear()
        self.watch.reset()
        self._seen_at = state.time
        super().begin(state, ground, height)
        for point in ground:
            self.map.touch(point)
        self.map.refresh()

    def observe(
        self, state: RobotState, ground: FloatArray, carrying: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """See `GroundBelief.observe`; a scan goes where the base was believed to be when it was taken."""
        self._poses.append((state.time, state.q[:7].copy()))
        while self._poses[0][0] < state.time - REMEMBERED:
            self._poses.popleft()
        super().observe(state, ground, carrying, sought, soles)
        # a robot that sees edges lifts its feet over them, unless it has struck one
        if state.time - self._stumbled > STUMBLE_TIME:
            self.lift = 0.0
        scan = state.scan
        if scan is None or scan.time < self._poses[0][0] - 1e-9:
            return
        times = np.array([time for time, _ in self._poses])
        base = self._poses[int(np.argmin(np.abs(times - scan.time)))][1]
        turned = rotation_from_quaternion(base[3:7])
        points = base[:3] + scan.points @ turned.T
        self.map.move(state.q[:2])
        self.map.see(points, scan.variances, scan.time - self._seen_at)
        self._seen_at = scan.time
        if scan.origin is not None:
            self.watch.see(base[:3] + turned @ scan.origin, points, scan.time)
        R = rotation_from_quaternion(state.q[3:7])
        self.watch.look(self.map, state.q[:2], math.atan2(R[1, 0], R[0, 0]), state.time)

    def above(self, soles: FloatArray, asked: BoolArray) -> FloatArray:
        """See `GroundBelief.above`."""
        out = np.zeros(len(soles))
        for k in np.flatnonzero(asked).tolist():
            if math.isfinite(self.map.variance(soles[k, :2])):
                out[k] = (soles[k, 2] - float(self.height(soles[k, :2]))) / self.noise
        return out

    def may_strike(self, sole: FloatArray, velocity: FloatArray) -> bool:
        """See `GroundBelief.may_strike`: not where the ground before the foot is known to be low."""
        path = self._path_ahead(sole, velocity)
        known = bool(self.map.known(path).all())
        return not known or float(self.height(path).max()) > sole[2] - STRIKE_NOISE * self.noise

    @property
    def steepness(self) -> float:
        """Rise over tread of the stairs that are seen [-]."""
        steps = self.watch.steps
        return 0.0 if steps is None else abs(steps.rise) / steps.tread

    @property
    def highest_step(self) -> float:
        """Height of their steps [m]."""
        steps = self.watch.steps
        return 0.0 if steps is None else abs(steps.rise)

    def steps_until(self, place: FloatArray, along: FloatArray) -> float:
        """See `Terrain.steps_until`: the last edge of stairs that have been fitted."""
        flight = self.watch.flight
        if flight is None:
            return -math.inf
        s, way = float(place @ flight[:2]) - flight[3], float(along @ flight[:2])
        return float(flight[9] * flight[4] - s) if way >= 0.0 else float(s - flight[8] * flight[4])

    def noise_at(self, xy: FloatArray) -> float:
        """Return by how much the ground may be off at a (2,) place: less on stairs that are known [m]."""
        if self.watch.flight is None or not self._read(xy)[1].all():
            return self.noise
        return FLIGHT_NOISE

    def height(self, xy: ArrayLike) -> FloatArray:
        """Return the believed height under (..., 2) places [m]: (...)."""
        return self._read(np.asarray(xy, dtype=np.float64))[0]

    def gradient(self, xy: ArrayLike) -> FloatArray:
        """Return the believed slope [-] at (..., 2) places [m]: (..., 2)."""
        places = np.asarray(xy, dtype=np.float64)
        if self.watch.flight is None:
            return self.map.gradient(places)
        own = self._read(places)[1][..., None]
        return np.zeros(places.shape) if own.all() else np.where(own, 0.0, self.map.gradient(places))

    def _read(self, places: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return heights (...) at (..., 2) places [m], and where they are those of stairs that are known."""
        seen, flight = self.map.height(places), self.watch.flight
        if flight is None:
            return seen, np.zeros(seen.shape, dtype=bool)
        flat = np.ascontiguousarray(places).reshape(-1, 2)
        heights, own = flight_heights(seen.ravel(), self.map.known(flat), flat, flight)
        return heights.reshape(seen.shape), own.reshape(seen.shape)

    def _touched(self, point: FloatArray) -> None:
        self.map.touch(point)
        self.watch.touch(point)

    def _fitted(self) -> None:
        self.map.guess(self._about, self._level, self._slope)


def believed_ground(knowledge: str, terrain: Terrain) -> Terrain:
    """Return what a controller plans on that has a certain knowledge of the true terrain.

    Raises
    ------
    ProblemError
        For an unknown name; the message lists `KNOWLEDGE`.

    Examples
    --------
    >>> from surefoot.terrain import FlatTerrain
    >>> believed_ground("blind", FlatTerrain())
    FeltGround()
    """
    if knowledge not in KNOWLEDGE:
        raise ProblemError(unknown_name("terrain knowledge", knowledge, KNOWLEDGE))
    if knowledge == "exact":
        return terrain
    if knowledge == "map":
        return MappedGround()
    from surefoot.control.felt_ground import FeltGround  # which is built on what is above

    return FeltGround()
