"""Ground that a range sensor sees: a height map, corrected where feet stand, and the stairs in it."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.motion.ground.elevation_kernels import stair_heights
from surefoot.motion.ground.elevation_map import ElevationMap
from surefoot.motion.ground.ground_belief import BeliefTerrain
from surefoot.motion.ground.ground_settings import MAPPED_GROUND
from surefoot.motion.ground.stair_detection import StairWatch
from surefoot.motion.state import RobotState


class MappedGround(BeliefTerrain):
    """A height map of what a range sensor has seen and feet have touched.

    Attributes
    ----------
    map
        `ElevationMap`.
    watch
        For stairs.
    noise
        See there.
    """

    MEMORY = ("map", "watch", "_poses", "_seen_at")

    seen = True

    def __init__(self) -> None:
        self.map = ElevationMap()
        self.noise = self.map.noise
        self._poses: deque[tuple[float, FloatArray]] = deque()
        self.watch = StairWatch()
        self.map.see(np.zeros((1, 3)), np.ones(1))  # compiled now, not in the first step with a scan

    def __repr__(self) -> str:
        return f"MappedGround({self.map!r})"

    def begin(self, state: RobotState, ground: FloatArray, height: float) -> None:
        """See `BeliefTerrain.begin`."""
        self.map.begin(ground[:, :2].mean(axis=0), 0.0, np.zeros(2))
        self._poses.clear()
        self.watch.reset()
        self._seen_at = state.time
        super().begin(state, ground, height)
        for point in ground:
            self.map.touch(point)
        self.map.refresh()

    def observe(
        self, state: RobotState, ground: FloatArray, stance: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """See `BeliefTerrain.observe`; a scan goes where the base was believed to be when it was taken."""
        self._poses.append((state.time, state.q[:7].copy()))
        while self._poses[0][0] < state.time - MAPPED_GROUND.remembered:
            self._poses.popleft()
        super().observe(state, ground, stance, sought, soles)
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
        """See `BeliefTerrain.above`."""
        out = np.zeros(len(soles))
        for k in np.flatnonzero(asked).tolist():
            if math.isfinite(self.map.variance(soles[k, :2])):
                out[k] = (soles[k, 2] - float(self.height(soles[k, :2]))) / self.noise
        return out

    def may_strike(self, sole: FloatArray, velocity: FloatArray) -> bool:
        """See `BeliefTerrain.may_strike`: not where the ground before the foot is known to be low."""
        path = self._path_ahead(sole, velocity)
        known = bool(self.map.known(path).all())
        return not known or float(self.height(path).max()) > sole[2] - MAPPED_GROUND.strike_noise * self.noise

    @property
    def bumps(self) -> float:
        """See `BeliefTerrain.bumps`: none, feet are lifted over what is seen [m]."""
        return 0.0

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
        return MAPPED_GROUND.stair_noise

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
        heights, own = stair_heights(seen.ravel(), self.map.known(flat), flat, flight)
        return heights.reshape(seen.shape), own.reshape(seen.shape)

    def _learn_touchdown(self, point: FloatArray) -> None:
        self.map.touch(point)
        self.watch.touch(point)

    def _use_plane(self) -> None:
        self.map.guess(self._about, self._level, self._slope)
