"""How far on a body in step with stairs should be, for all its feet to fall between edges.

In step with stairs each foot finds the same part of a tread again, and the feet of one gait find different
parts. A body a little further on has all of them at better places or at worse ones. The place with the least
moves of the feet (`step_windows`) is looked for within half a tread, since between two good ones lies a
worse; the body takes it up by going a little faster or slower, from some strides before the first edge. A
body that has slowed down until its gait is in step with stairs sets off again at the phase of the gait at
which there is nothing to take up.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.foothold import FINE, LOOK, nearest_shift, step_windows
from surefoot.motion.walking.pace_settings import STAIR_PHASE
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_kernels import turned_arms


class StepPhase(Remembering):
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
    waiting
        Whether a slow body should wait before it sets off onto stairs.
    stride
        (2,) way of each foot from stand to stand on stairs that have been seen [m]; None elsewhere.
    """

    MEMORY = ("_costs", "_next", "lead", "share", "stride", "waiting", "_off", "_waits_from")

    def __init__(
        self, terrain: Terrain, schedule: ContactSchedule, offsets: FloatArray, margin: float
    ) -> None:
        self.terrain, self.schedule, self.offsets, self.margin = terrain, schedule, offsets, margin
        self._ahead = np.arange(-0.5 * LOOK, 0.5 * LOOK + FINE, 2.0 * FINE)
        self.reset()

    def reset(self) -> None:
        """Forget what has been seen."""
        self._costs = np.zeros((len(self.offsets), len(self._ahead)))
        self._next = 0
        self.lead, self.share = 0.0, 1.0
        self.stride: FloatArray | None = None
        self.waiting, self._off, self._waits_from = False, False, 0.0

    def look(self, body: BodyPlan, clock: float, unsure: bool = False) -> None:
        """Look at where one foot, another each time, will be on its next treads.

        Parameters
        ----------
        body
            Where the body should be, and how it should move.
        clock
            Time of the schedule [s].
        unsure
            Whether it is not yet known where steps are: then there is nothing to take up, and what waits
            has not begun to.
        """
        place, flow, period = body.position[:2], body.flow() / self.share, self.schedule.period
        self.stride = None
        if unsure or self.schedule.held:  # no foot will lift
            self.lead, self.waiting, self._off, self._waits_from = 0.0, False, False, clock
            return
        self.waiting = self._should_wait(place, flow, clock)
        if self.waiting or self._off:
            # a body that gains speed falls behind one that has it
            c, s = math.cos(body.yaw), math.sin(body.yaw)
            asked = self.schedule.asked[:2] @ [[c, s], [-s, c]]
            missing = asked - flow
            place = place - 0.5 * math.hypot(missing[0], missing[1]) / body.acceleration * missing
            flow, period = asked, self.schedule.coming_period
        stride = period * flow
        length = math.hypot(float(stride[0]), float(stride[1]))
        if not self._in_step(length):
            self.lead, self.waiting = 0.0, False
            return
        if (
            self._off
            and math.hypot(*(stride - period * body.flow() / self.share)) < STAIR_PHASE.in_step * length
        ):
            self.stride = stride
        if not self.waiting:
            self._next = (self._next + 1) % len(self.offsets)
            self._weigh(self._next, body.yaw, place, flow, stride, clock)
            self.lead = self._best(self.lead)
            return
        for k in range(len(self.offsets)):
            self._weigh(k, body.yaw, place, flow, stride, clock)
        lead = self._best(None)
        if (
            abs(lead) <= STAIR_PHASE.set_off
            or clock - self._waits_from > STAIR_PHASE.longest_wait * self.schedule.period
        ):
            self.waiting, self._off, self.lead = False, True, lead

    def _should_wait(self, place: FloatArray, flow: FloatArray, clock: float) -> bool:
        """Return whether a body that has slowed down before stairs should not yet set off."""
        schedule = self.schedule
        if not schedule.in_step:
            self._off = False
            return False
        if schedule.turning and not self._off:
            self._waits_from = clock
            return False
        if self.terrain.steps_until(place, flow) == -math.inf:
            self._off = True
        return not self._off

    def _weigh(
        self, k: int, yaw: float, position: FloatArray, flow: FloatArray, stride: FloatArray, clock: float
    ) -> None:
        """Find what it costs foot k to stand on its next treads, for each place of the body."""
        arm = turned_arms(self.offsets[k : k + 1], np.array([yaw]))[0, 0]
        place = position + arm + (self._touchdown(k, clock) + 0.5 * self.schedule.stance_time) * flow
        costs = self._costs[k]
        costs[:] = 0.0
        length = math.hypot(float(stride[0]), float(stride[1]))
        along, strides, known = stride / length, STAIR_PHASE.strides, math.inf
        if self.terrain.learns:
            known = self.terrain.steps_until(place, along)
            strides = STAIR_PHASE.strides_mapped if known > -math.inf else 0
        begin, end = -LOOK, LOOK + strides * length
        if math.isfinite(known):  # all edges back from the last one that has been seen
            begin, end = min(known, 0.0) - LOOK - length, min(end, known + STAIR_PHASE.last_tread * length)
        ways = np.arange(begin, end, FINE)
        windows = step_windows(self.terrain, place, along, self.margin, ways)
        if windows is not None:
            moved = self._ahead + length * np.arange(strides + 1)[:, None]
            if math.isfinite(known):  # beyond what has been seen stairs are taken to go on as they are
                moved -= length * np.maximum(np.ceil((moved - known) / length), 0.0)
            costs += np.square(nearest_shift(windows, moved.ravel()).reshape(moved.shape)).sum(axis=0)

    def _best(self, before: float | None) -> float:
        """Return how much further on the body should be, near what was best `before` if that is said [m]."""
        total, moved = self._costs.sum(axis=0), STAIR_PHASE.move_cost * np.square(self._ahead)
        total += (
            moved if before is None else moved + STAIR_PHASE.change_cost * np.square(self._ahead - before)
        )
        return float(self._ahead[int(total.argmin())])

    def unhurried(self, velocity: FloatArray, asked: FloatArray) -> FloatArray:
        """Return the velocity that strides should suit: the one asked for where only the pace differs.

        Parameters
        ----------
        velocity, asked
            (3,) of the body, and as commanded [m/s, m/s, rad/s].
        """
        if self.schedule.in_step:
            most = (1.0 + STAIR_PHASE.most_change) * math.hypot(float(asked[0]), float(asked[1]))
            if math.hypot(float(velocity[0]), float(velocity[1])) <= most:
                return asked
        return velocity / [self.share, self.share, 1.0]

    def pace(self, speed: float, dt: float) -> float:
        """Return the share of its speed [m/s] with which the body goes on for `dt` [s]."""
        if speed <= 0.0:
            return 1.0
        most = STAIR_PHASE.most_change * speed
        change = min(max(self.lead / STAIR_PHASE.pace_time, -most), most)
        self.lead -= change * dt
        self.share = 1.0 + change / speed
        return self.share

    def _in_step(self, length: float) -> bool:
        """Return whether a stride of a length [m] takes a tread: shorter ones find several parts of each."""
        terrain = self.terrain
        if length < 1e-3 or terrain.highest_step <= 0.0 or terrain.steepness <= 0.0:
            return False
        return abs(terrain.highest_step / (terrain.steepness * length) - 1.0) < STAIR_PHASE.in_step

    def _touchdown(self, k: int, clock: float) -> float:
        """Return the time to the next touchdown of foot k [s]."""
        planned, _, end = self.schedule.phase(k, clock)
        if planned:
            end = self.schedule.phase(k, end + 1e-6)[2]
        return end - clock
