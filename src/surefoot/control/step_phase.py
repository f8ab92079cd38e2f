"""How far on a body in step with stairs should be, for all its feet to fall between edges.

In step with stairs each foot finds the same part of a tread again, and the feet of one gait find different
parts. A body a little further on has all of them at better places or at worse ones. The place with the least
moves of the feet (`step_windows`) is looked for within half a tread, since between two good ones lies a
worse; the body takes it up by going a little faster or slower, from some strides before the first edge.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.adaptive_gait import AdaptiveGait
from surefoot.control.gait import Gait
from surefoot.control.step_windows import FINE, LOOK, nearest_shift, step_windows
from surefoot.control.walking_body import BodyPlan
from surefoot.control.walking_kernels import turned_arms
from surefoot.terrain import Terrain

STRIDES = 3
"""So many strides ahead of the next one are looked at, on ground that is known."""
PACE, CHANGE = 0.75, 0.15
"""Time in which the body takes up its place [s], and the largest share of its speed that this may cost."""
IN_STEP = 0.1
"""A stride that is so far from a tread, as a share of it, is out of step."""
EASE, KEEP = 0.05, 1.0
"""What a move of the body costs, and one away from what was best before, against the same move of a foot."""


class StepPhase:
    """Finds by how much a body should be further on, see the module.

    Parameters
    ----------
    terrain
        As believed.
    schedule
        The gait.
    offsets
        (n, >= 2) where the feet belong about the centre of mass, heading axes [m].
    margin
        Distance to keep from edges [m].

    Attributes
    ----------
    lead
        How much further on the body should be [m].
    share
        Of its speed with which the body goes on now, see `pace`.
    """

    def __init__(
        self, terrain: Terrain, schedule: Gait | AdaptiveGait, offsets: FloatArray, margin: float
    ) -> None:
        self.terrain, self.schedule, self.offsets, self.margin = terrain, schedule, offsets, margin
        self._strides = 0 if terrain.learns else STRIDES
        self._ahead = np.arange(-0.5 * LOOK, 0.5 * LOOK + FINE, 2.0 * FINE)
        self.reset()

    def reset(self) -> None:
        """Forget what has been seen."""
        self._costs = np.zeros((len(self.offsets), len(self._ahead)))
        self._next = 0
        self.lead, self.share = 0.0, 1.0

    def look(self, body: BodyPlan, clock: float) -> None:
        """Look at where one foot, another each time, will be on its next treads.

        Parameters
        ----------
        body
            Where the body should be, and how it should move.
        clock
            Time of the schedule [s].
        """
        flow = body.flow() / self.share
        stride = self.schedule.period * flow
        length = math.hypot(float(stride[0]), float(stride[1]))
        if not self._in_step(length):
            self.lead = 0.0
            return
        k = self._next = (self._next + 1) % len(self.offsets)
        arm = turned_arms(self.offsets[k : k + 1], np.array([body.yaw]))[0, 0]
        place = body.position[:2] + arm + (self._touchdown(k, clock) + 0.5 * self.schedule.stance_time) * flow
        costs = self._costs[k]
        costs[:] = 0.0
        ways = np.arange(-LOOK, LOOK + self._strides * length, FINE)
        windows = step_windows(self.terrain, place, stride / length, self.margin, ways)
        if windows is not None:
            moved = self._ahead + length * np.arange(self._strides + 1)[:, None]
            costs += np.square(nearest_shift(windows, moved.ravel()).reshape(moved.shape)).sum(axis=0)
        total = self._costs.sum(axis=0)
        total += EASE * np.square(self._ahead) + KEEP * np.square(self._ahead - self.lead)
        self.lead = float(self._ahead[int(total.argmin())])

    def pace(self, speed: float, dt: float) -> float:
        """Return the share of its speed [m/s] with which the body goes on for `dt` [s]."""
        if speed <= 0.0:
            return 1.0
        most = CHANGE * speed
        change = min(max(self.lead / PACE, -most), most)
        self.lead -= change * dt
        self.share = 1.0 + change / speed
        return self.share

    def _in_step(self, length: float) -> bool:
        """Return whether a stride of a length [m] takes a tread: shorter ones find several parts of each."""
        terrain = self.terrain
        if length < 1e-3 or terrain.highest_step <= 0.0 or terrain.steepness <= 0.0:
            return False
        return abs(terrain.highest_step / (terrain.steepness * length) - 1.0) < IN_STEP

    def _touchdown(self, k: int, clock: float) -> float:
        """Return the time to the next touchdown of foot k [s]."""
        planned, _, end = self.schedule.phase(k, clock)
        if planned:
            end = self.schedule.phase(k, end + 1e-6)[2]
        return end - clock
