"""What a walking robot believes about the ground that it does not know: a `Terrain` that learns.

Whoever plans footholds, swings or the body's pose on it does not see the difference. All of it lives in the
estimated frame, in which the robot knows its own place. It answers geometry, and how sure of it one may be.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections import deque
from typing import ClassVar, cast

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Terrain
from surefoot.motion.ground.ground_settings import GROUND_ESTIMATE
from surefoot.motion.state import RobotState

DAMPING = 1e-4
"""Pull of the plane's slopes to zero where footholds do not say them [m²]."""


class BeliefTerrain(Remembering, Terrain):
    """A terrain that learns from what the robot senses.

    Attributes
    ----------
    radius
        Of the feet [m].
    struck_at
        When a foot has last struck an edge [s].
    seen
        Whether a sensor sees the ground before feet touch it.
    finds_drops
        Whether it finds drops by touch, as `TouchedGround` does.
    """

    MEMORY: ClassVar[tuple[str, ...]] = (
        "radius",
        "struck_at",
        "_height",
        "_landings",
        "_stood",
        "_sought",
        "_spread",
        "_about",
        "_level",
        "_slope",
    )

    learns = True
    seen = False
    finds_drops = False
    radius: float = 0.0
    struck_at: float = -math.inf

    def start(self, state: RobotState, ground: FloatArray, height: float, radius: float) -> None:
        """Start as by `begin`, with (n, 3) contact points and feet of a radius [m]."""
        self.radius = radius
        self.begin(state, ground, height)

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
        self.struck_at = -math.inf
        self._spread = 0.0
        self._fit()

    def observe(
        self, state: RobotState, ground: FloatArray, stance: BoolArray, sought: BoolArray, soles: FloatArray
    ) -> None:
        """Learn from a step.

        Parameters
        ----------
        state
            What is sensed.
        ground
            (n, 3) where feet stand or last stood [m].
        stance, sought
            (n,) which feet carry, and which look for the ground below them.
        soles
            (n, 3) lowest points of the feet [m].
        """
        landed = stance & ~self._stood
        self._stood = stance.copy()
        for k in np.flatnonzero(landed).tolist():
            self._landings[k].append(ground[k].copy())
            self._learn_touchdown(ground[k])
        # where a foot looks for the ground, it is no higher than the foot
        self._sought = {k: soles[k] for k in np.flatnonzero(sought).tolist()}
        if landed.any() or sought.any():
            self._fit()

    def _only_now(self, ground: FloatArray) -> None:
        """Remember no landings but where the feet stand now, (n, 3) [m]."""
        self._landings: list[deque[FloatArray]] = [
            deque([g.copy()], maxlen=GROUND_ESTIMATE.landings) for g in ground
        ]

    @property
    def slope(self) -> FloatArray:
        """Slope along x and y of the plane through the last footholds (2,) [-]."""
        return self._slope

    @property
    def bumps(self) -> float:
        """How far the ground may stick out between places where it is known [m]."""
        return GROUND_ESTIMATE.bumps * max(self._spread - GROUND_ESTIMATE.smooth, 0.0)

    def stumbled(self, time: float) -> None:
        """Learn that a foot struck an edge at a time [s]."""
        self.struck_at = time

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
        ways = np.linspace(0.0, GROUND_ESTIMATE.strike_reach * self._height, 5)[:, None]
        return sole[:2] + ways * velocity[:2] / max(math.hypot(velocity[0], velocity[1]), 1e-6)

    def _fit(self) -> None:
        """Fit the plane under the feet."""
        places, weights = [], []
        for k, landings in enumerate(self._landings):
            known = [*landings, self._sought[k]] if k in self._sought else landings
            for age, place in enumerate(reversed(known)):
                places.append(place)
                weights.append(GROUND_ESTIMATE.forgetting**age)
        points, shares = np.array(places), np.array(weights)
        # Weighted least squares of heights over the footholds' middle: slopes are damped, since two feet or
        # feet in one line say nothing about the slope across, and from the middle that pull leaves the level
        # alone.
        about = points[:, :2].mean(axis=0)
        rows = np.column_stack([np.ones(len(points)), points[:, :2] - about])
        normal = (rows * shares[:, None]).T @ rows
        normal[1:, 1:] += DAMPING * np.eye(2)
        plane = np.linalg.solve(normal, rows.T @ (shares * points[:, 2]))
        off = points[:, 2] - rows @ plane
        # The weighted deviation, less three numbers fitted.
        self._spread = math.sqrt(float(shares @ off**2) / max(float(shares.sum()) - 3.0, 1.0))
        self._about, self._level, self._slope = about, float(plane[0]), plane[1:]
        self._use_plane()

    def _learn_touchdown(self, point: FloatArray) -> None:
        """Update the ground by a touchdown at a (3,) point [m]."""

    @abstractmethod
    def _use_plane(self) -> None:
        """Take a newly fitted plane: `_level` [m] at `_about`, `_slope`."""


def believed(terrain: Terrain) -> BeliefTerrain | None:
    """Return a terrain that learns as the belief that it is, None for one that is known."""
    return cast(BeliefTerrain, terrain) if terrain.learns else None
