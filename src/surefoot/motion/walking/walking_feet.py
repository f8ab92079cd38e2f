"""Which feet carry and where the others go: the gait's plan corrected by what the feet feel."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.live_arrays import Bound
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking import swing
from surefoot.motion.walking.foothold import choose_foothold
from surefoot.motion.walking.swing import DOWN, LIFT_FIRST, LIFT_LATER, apex_height, clear_lift
from surefoot.motion.walking.walking_kernels import (
    follow_phases,
    set_timing,
    swing_accelerations,
    swing_paths,
)

EARLY = 0.6
"""A foot that touches after this share of its swing has landed early; before, it only brushes the ground."""
LOST_TIME = 0.03
"""A foot in stance without contact for this long is looked for below [s]."""
FREEZE, FREEZE_ROUGH = 0.75, 0.4
"""After this share of the swing the target stays where it is; where the path must clear edges, earlier."""
LEAST_CLEARANCE = 0.3
"""Feet are lifted at least this share of the usual height, whatever is commanded."""
DESCENT = 0.12
"""Speed towards the ground at touchdown, as a share of sqrt(g h)."""
SEARCH = 0.3
"""Acceleration with which a late foot goes down from there, as a share of g."""
SEARCH_FAST, SEARCH_SPEED = 0.8, 0.4
"""The same on unknown ground, and the largest speed of the search there, as a share of sqrt(g h)."""
RETRY = 0.7
"""Least time for the rest of a swing that has been interrupted, as a share of the swing's duration."""
SAME_TREAD = 2.0
"""A foot in step with stairs takes the tread next to its last one if that is farther by no more, in radii."""
PATH_SAMPLES = 7
CHOSEN = 0.1
"""After this share of the swing a foot keeps to the tread that it is on its way to."""
FAST, EVEN, EVEN_UNTIL = 0.7, 0.5, 0.05
"""A swing over learned ground is as one over even ground if its speed, as a share of sqrt(g h), and its slope
come to more than this, and the ground is off a line by no more than its noise and this share of a radius; it
is decided up to this share of the swing."""
DOWN_NOISY, NOISY, RAISE = 0.85, 0.012, 0.7
"""On ground of this noise [m], the share of a swing after which a foot only sinks, and how much higher than
believed the ground is taken for, over its noise: so that it is met gently where it is higher, too."""


@dataclass
class Feet(Bound):
    """The feet's state machine; all arrays have one row per foot.

    Attributes
    ----------
    stance
        (n,) which feet push now.
    planned
        (n,) which feet the gait wants on the ground now.
    late
        (n,) which feet should be on the ground but have not found it.
    target
        (n, 3) where feet in the air will touch (centre of the foot), or last did.
    ground
        (n, 3) contact point where each foot last stood.
    frames
        (n, 3, 3) rotation_world_contact of each foot's ground.
    share
        (n,) time since lift-off over the swing's duration.
    again
        (n,) which feet have begun their swing anew, once each.
    wait
        Time by which the schedule has been held up so far [s].
    rate
        How many times as fast as time the schedule's clock goes, see `hurry`.
    fastest
        Largest speed with which a late foot is sent down on unknown ground [m/s]; None on known ground.
    heading
        (2,) along which feet are moved off edges; None for each one's own way.
    careful
        Whether feet that are still late when their next swing begins lift from where they are then.
    stride
        (2,) from one stand to the next in step with stairs: it chooses the tread [m]; None elsewhere.
    """

    schedule: ContactSchedule
    terrain: Terrain
    radii: FloatArray
    clearance: float
    descent: float
    centres: FloatArray
    wait: float = 0.0
    rate: float = 1.0
    fastest: float | None = None
    heading: FloatArray | None = None
    stride: FloatArray | None = None
    careful: bool = False

    def __post_init__(self) -> None:
        n = len(self.radii)
        self.stance: BoolArray = np.ones(n, dtype=bool)
        self.planned: BoolArray = np.ones(n, dtype=bool)
        self.late: BoolArray = np.zeros(n, dtype=bool)
        self.share = np.zeros(n)
        self._ends = np.array([self.centres, self.centres])
        self._timing = np.zeros((n, 6))
        self._bind()
        self.apex[:], self.duration[:] = self.centres[:, 2], 1.0
        self._aimed = self.target.copy()  # where a foot was on its way to before it landed
        self.frames = np.array([self.terrain.frame(c[:2]) for c in self.centres])
        self.ground = self.centres - self.radii[:, None] * self.frames[:, :, 2]
        self._lifted = np.full(n, -np.inf)
        self._sensed = np.zeros(n)
        self._retry = np.full((n, 2), -np.inf)  # when swings that were interrupted begin anew and end
        self.again: BoolArray = np.zeros(n, dtype=bool)
        self._late_from = np.zeros(n)
        self._lift_first[:] = swing.EVEN if self.terrain.planar else LIFT_FIRST
        self._timing[:, 5] = DOWN
        self._reach = 1.2 * self.clearance

    def _bind(self) -> None:
        """Find the parts of what swings are computed from."""
        self.start: FloatArray = self._ends[0]
        self.target: FloatArray = self._ends[1]
        self.apex: FloatArray = self._timing[:, 0]
        self.duration: FloatArray = self._timing[:, 2]
        self._lift_first: FloatArray = self._timing[:, 3]

    def update(self, time: float, sensed: BoolArray, centres: FloatArray) -> bool:
        """Move on to a time of the schedule; return whether a foot has lifted or landed.

        Parameters
        ----------
        time
            On the schedule's clock [s].
        sensed
            (n,) which feet feel the ground.
        centres
            (n, 3) where the feet are.
        """
        phases = self.schedule.phases(time)
        for k in np.flatnonzero(self.late & ~self.stance).tolist() if self.careful else ():
            on, begin, end = phases[k].tolist()
            if not on and begin > self._lifted[k]:
                self._lift(k, begin, end - begin, centres[k])
        events = follow_phases(
            phases, time, self.wait, sensed, EARLY, LOST_TIME, self.stance, self.planned, self.late,
            self.share, self._sensed, self._retry, self._lifted,
        )  # fmt: skip
        changed = False
        for k in range(len(sensed)) if events else ():
            if events >> k & 1:
                changed |= self._happens(k, time, bool(sensed[k]), centres[k], *phases[k, 1:].tolist())
        return changed

    def _happens(
        self, k: int, time: float, sensed: bool, centre: FloatArray, begin: float, end: float
    ) -> bool:
        """Let a foot lift, land, look for the ground or go on; return whether it has lifted or landed."""
        if self._again(k, time, sensed, centre):
            return bool(self.stance[k])
        if self.planned[k]:
            return self._on_ground(k, time, sensed, centre)
        if self.stance[k]:
            self._lift(k, begin, end - begin, centre)
        else:
            self._land(k, centre)
        return True

    def hurry(self, rate: float, dt: float) -> None:
        """Let clock and swings go at a multiple of time in the coming step of dt [s]."""
        if rate != self.rate:
            self.duration *= self.rate / rate
            self.rate = rate
        self.wait -= (rate - 1.0) * dt

    def leap(self, schedule: ContactSchedule, time: float, air: float, centres: FloatArray) -> None:
        """Let all feet, now at (n, 3) `centres` [m], leave the ground at once, for `air` [s].

        They follow another schedule, whose swings begin at this `time`, as for `update`.
        """
        self.schedule = schedule
        self._retry[:], self.late[:] = -np.inf, False
        for k, centre in enumerate(centres):
            self._lift(k, time, air, centre)

    def follow(self, schedule: ContactSchedule, time: float) -> None:
        """Follow another schedule from a time on, as for `update`; who stands waits for the next swing."""
        self.schedule = schedule
        self._lifted[:] = schedule.phases(time)[:, 1]

    def interrupt(self, k: int, time: float, centre: FloatArray) -> None:
        """Begin a swing anew from where the foot is, which has struck something; time as for `update`."""
        planned, begin, end = self.schedule.phase(k, time)
        now = time + self.wait
        rest = float(self.duration[k]) if planned else max(end - time, RETRY * (end - begin))
        self._retry[k] = now, now + rest
        self.start[k], self.share[k], self.duration[k] = centre, 0.0, rest
        self._lift_first[k], self.again[k] = LIFT_LATER[-1], True

    def take_back(self, k: int, centre: FloatArray) -> None:
        """Take back the landing of foot k, now at (3,) [m]: it swings on, or is looked for below."""
        if self.planned[k]:
            self._sensed[k] = -np.inf
        else:
            self.stance[k], self.target[k] = False, self._aimed[k]

    def slow_search(self, time: float, fastest: float, ahead: FloatArray) -> None:
        """Let late feet go down at another speed from now on, without a jump.

        Parameters
        ----------
        time
            As for `update` [s].
        fastest
            See `fastest`.
        ahead
            (2,) how much farther along x and y of the world they come down than before [m].
        """
        search, before = self._search_down()
        for k in np.flatnonzero(self.late & ~self.stance).tolist():
            late = time + self.wait - float(self._late_from[k])
            rush, was = (min(late, speed / search) for speed in (fastest, before))
            self.target[k, 2] += search * (rush * (late - 0.5 * rush) - was * (late - 0.5 * was))
            self.target[k, :2] += ahead
        self.fastest = fastest

    def _again(self, k: int, time: float, sensed: bool, centre: FloatArray) -> bool:
        """Go on with a swing that has begun anew; return whether there is one."""
        begin, end = self._retry[k]
        now = time + self.wait
        if self.stance[k] or now >= end:
            return False
        self.late[k], self.share[k] = False, (now - begin) / (end - begin)
        if sensed and self.share[k] > EARLY:
            self._land(k, centre)
        return True

    def overdue(self) -> BoolArray:
        """Return which feet should stand by now and do not: (n,)."""
        return self.planned & ~self.stance

    def _on_ground(self, k: int, time: float, sensed: bool, centre: FloatArray) -> bool:
        """Handle a foot that the gait wants on the ground."""
        if self.stance[k]:
            if time - self._sensed[k] <= LOST_TIME:
                return False
            self.stance[k], self.late[k] = False, True
            self.start[k], self.target[k] = centre, centre
            self.apex[k], self.share[k], self.duration[k] = centre[2], 1.0, LOST_TIME
            self._sensed[k] = time
            self._late_from[k] = time + self.wait
            return True
        if sensed:
            self._land(k, centre)
            return True
        if not self.late[k]:
            _, begin, _ = self.schedule.phase(k, time)
            begun = max(begin, float(self._sensed[k])) + self.wait
            self._late_from[k] = max(begun, float(self._retry[k, 1]))
        self.late[k] = True
        return False

    def _lift(self, k: int, begin: float, duration: float, centre: FloatArray) -> None:
        self.stance[k] = self.again[k] = False
        self._lifted[k], self.duration[k] = begin, duration / self.rate
        self._lift_first[k] = swing.EVEN if self.terrain.planar else LIFT_FIRST
        self.start[k] = centre

    def _land(self, k: int, centre: FloatArray) -> None:
        self.stance[k], self.late[k] = True, False
        self._aimed[k], self.target[k] = self.target[k], centre
        if not self.terrain.planar:
            self.frames[k] = self.terrain.frame(centre[:2])
        self.ground[k] = centre - self.radii[k] * self.frames[k, :, 2]

    def aim(self, k: int, place: FloatArray, latest: float | None = None) -> None:
        """Set the target of a foot in the air: (2,) nominal place [m], moved to good ground.

        Up to the share `latest` of the swing it is taken as it is, for a caller that leads the foot there.
        """
        share = float(self.share[k])
        if share > (latest or (FREEZE if self.terrain.planar else FREEZE_ROUGH)):
            return
        if share > FREEZE_ROUGH and latest is None:  # ever less can be changed without a rush
            trust = (FREEZE - share) / (FREEZE - FREEZE_ROUGH)
            place = self.target[k, :2] + trust * (place - self.target[k, :2])
        way = place - self.start[k, :2] if self.heading is None else self.heading
        before = None if self.stride is None else self.start[k, :2] + self.stride
        if share > CHOSEN:
            before = self.target[k, :2]
        more = math.inf if share > CHOSEN else SAME_TREAD * float(self.radii[k])
        margin = float(2.0 * self.radii.mean())
        xy = choose_foothold(self.terrain, place, self._reach, margin, way, before, more)
        normal = self.frames[k, :, 2] if self.terrain.planar else self.terrain.normal(xy)
        self.target[k, :2] = xy
        # the sphere touches the tangent plane: its centre is radius / n_z above the ground on the vertical
        noise = self.terrain.noise_at(xy)
        self._timing[k, 5] = DOWN - (DOWN - DOWN_NOISY) * min(noise / NOISY, 1.0)
        above = RAISE * noise + self.radii[k] / normal[2]
        self.target[k, 2] = float(self.terrain.height(xy)) + above
        if not self.terrain.planar:
            self.frames[k] = self.terrain.frame(xy)
        if self.terrain.planar or self._even(k, noise):
            self._lift_first[k] = swing.EVEN
            self.target[k, 2] -= RAISE * noise  # a late foot costs more than an early one
            # the bump is put on the line between both ends, which is as steep as the plane
            self.apex[k] = 0.5 * float(self.start[k, 2] + self.target[k, 2]) + self.clearance
        else:
            self.apex[k] = apex_height(self.start[k], self.target[k], self._below(k), self.clearance)
            self._lift_first[k] = clear_lift(
                self.start[k], self.target[k], float(self.apex[k]), self.terrain, float(self.radii[k]),
                0.5 * float(self.radii[k]),
            )  # fmt: skip

    def _below(self, k: int) -> FloatArray:
        """Return the least heights of a foot over the ground on its way: (PATH_SAMPLES,) [m]."""
        start, way = self.start[k, :2], self.target[k, :2] - self.start[k, :2]
        path = start + np.linspace(0.0, 1.0, PATH_SAMPLES)[:, None] * way
        return np.asarray(self.terrain.height(path) + self.radii[k])

    def _even(self, k: int, noise: float) -> bool:
        """Return whether a fast swing goes over ground that is even but for some noise [m].

        A leg that trails behind a fast body is stretched if its foot has to lift first.
        """
        if self.share[k] > EVEN_UNTIL or not self.terrain.learns:
            return bool(self._lift_first[k] < 0.0)
        way = max(float(np.linalg.norm(self.target[k, :2] - self.start[k, :2])), 1e-9)
        line = np.linspace(self.start[k, 2], self.target[k, 2], PATH_SAMPLES)
        hurry = way / (self.descent / DESCENT * self.duration[k]) + abs(line[-1] - line[0]) / way
        return bool(hurry > FAST and np.abs(self._below(k) - line).max() < EVEN * self.radii[k] + noise)

    def accelerations(
        self, time: float, centres: FloatArray, twists: FloatArray, gain: tuple[float, float]
    ) -> FloatArray:
        """Return the wanted accelerations of the feet in the air, zero for the others: (n, 6) [m/s², rad/s²].

        Parameters
        ----------
        time
            On the schedule's clock [s].
        centres, twists
            (n, 3), (n, 6) where the feet are and how they move, world axes [m], [m/s, rad/s].
        gain
            Stiffness [1/s²] and damping [1/s] of the feedback.
        """
        return swing_accelerations(
            ~self.stance, *self._paths(time), centres, twists, self.descent, *self._search_down(), *gain
        )

    def motions(self, time: float) -> FloatArray:
        """Return wanted place [m], velocity and acceleration of feet in the air, else zero: (n, 3, 3)."""
        return swing_paths(~self.stance, *self._paths(time), self.descent, *self._search_down())

    def _search_down(self) -> tuple[float, float]:
        """Return acceleration [m/s²] and largest speed [m/s] with which late feet are sent down."""
        if self.fastest is None:
            return SEARCH * GRAVITY, math.inf
        return SEARCH_FAST * GRAVITY, self.fastest

    def _paths(self, time: float) -> tuple[FloatArray, FloatArray]:
        """Return ends and timing of the swings at a time, see `swing_paths`."""
        set_timing(self._timing, self.share, self.late, self._late_from, time + self.wait)
        return self._ends, self._timing
