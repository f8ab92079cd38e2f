"""Where a biped steps: first as the divergent motion at touchdown asks, later as the command does."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking.biped.pendulum import PendulumPreview
from surefoot.motion.walking.biped.soles import Soles
from surefoot.motion.walking.swing import swing_motion
from surefoot.motion.walking.walking_body import BodyPlan
from surefoot.motion.walking.walking_feet import Feet

LONGEST = 30.0
"""A stance that ends later than this from now has no end that matters [s]."""


@dataclass(frozen=True)
class Footstep:
    """A stance of one foot.

    Attributes
    ----------
    foot
        Its index.
    begin, end
        When it touches down and lifts off, on the schedule's clock [s]; infinite where it never does.
    place
        (2,) middle of the sole, world axes [m].
    yaw
        Where the toes point [rad].
    """

    foot: int
    begin: float
    end: float
    place: FloatArray
    yaw: float


@dataclass(frozen=True)
class StepGeometry:
    """What steps are like.

    Attributes
    ----------
    width
        Distance of the feet when walking straight on [m].
    narrowest, widest
        Bounds on the distance to the left or right of a foot from the other one [m].
    longest
        Bound on the distance ahead or behind [m].

    A step that is both wide and long ends within the ellipse of both bounds: on its diagonal the leg that
    is left behind would be straight, and its foot drag.
    """

    width: float
    narrowest: float
    widest: float
    longest: float

    def within_reach(self, place: FloatArray, support: FloatArray, yaw: float, side: float) -> FloatArray:
        """Return the (2,) place [m] moved so that the legs reach it and do not cross.

        Parameters
        ----------
        place, support
            (2,) where the foot should go, and the other foot [m].
        yaw
            Heading [rad].
        side
            1 for a left foot, -1 for a right one.
        """
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = float(place[0] - support[0]), float(place[1] - support[1])
        ahead, out = c * x + s * y, side * (c * y - s * x)
        # Ahead and outwards the reach is half an ellipse about the usual place beside the other foot; inwards
        # it ends where the feet would meet.
        room = self.widest - self.width
        far = math.hypot(ahead / self.longest, max(out - self.width, 0.0) / room)
        if far > 1.0:
            ahead, out = ahead / far, min(out, self.width + (out - self.width) / far)
        left = side * max(out, self.narrowest)
        return np.array([support[0] + c * ahead - s * left, support[1] + s * ahead + c * left])


def stances(schedule: ContactSchedule, foot: int, clock: float, ahead: float) -> list[tuple[float, float]]:
    """Return (begin, end) [s] of the stances of a foot that end after `clock` and begin within `ahead` [s].

    Before the schedule's time 0 all feet stand, since ever.
    """
    out, time, until = [], max(clock, 0.0), clock + ahead
    if clock < 0.0:
        on, _, end = schedule.phase(foot, 0.0)
        time = end if on else 0.0
        out.append((-math.inf, time))
        time += 1e-6
    while time < until:
        on, begin, end = schedule.phase(foot, time)
        if on:
            out.append((begin, end))
        if not end < clock + LONGEST:
            break
        time = end + 1e-6
    return out


def pressure_path(steps: list[Footstep], times: FloatArray) -> FloatArray:
    """Return where the centre of pressure should be at (t,) times [s]: (t, 2) [m].

    On the standing foot; on two feet it moves evenly to the one that stays longer; standing still it is
    between them. Where no foot stands it is where it last was.
    """
    # Shares of the load by footstep; the centre of pressure is their mean. In double support a share goes
    # linearly from one foot to the other, so that the path has no jump.
    share = np.zeros((len(times), len(steps)))
    for i, one in enumerate(steps):
        load = ((times >= one.begin) & (times < one.end)).astype(np.float64)
        for other in steps:
            begin, end = max(one.begin, other.begin), min(one.end, other.end)
            if other.foot == one.foot or begin >= end:
                continue
            both = (times >= begin) & (times < end)
            load[both] = _load(one, other, begin, end, times[both])
        share[:, i] = load
    total = share.sum(axis=1)
    places = np.array([one.place for one in steps])
    path: FloatArray = np.asarray(share @ places / np.maximum(total, 1e-9)[:, None])
    for k in np.flatnonzero(total < 1e-9):
        path[k] = path[k - 1] if k else places[0]
    return path


def _load(one: Footstep, other: Footstep, begin: float, end: float, times: FloatArray) -> FloatArray:
    """Return the share of the load on a foot while both stand."""
    if not math.isfinite(end):
        return np.full(len(times), 0.5)
    if math.isfinite(begin):
        moved = np.clip((times - begin) / (end - begin), 0.0, 1.0)
        first = 0.0 if one.begin > other.begin else 1.0
    else:  # standing, until the first foot lifts
        moved, first = np.zeros(len(times)), 0.5
    last = 1.0 if one.end > other.end else 0.0
    return np.asarray(first + moved * (last - first))


def touching(steps: list[Footstep], times: FloatArray, feet: int) -> tuple[BoolArray, list[list[int]]]:
    """Return which feet stand at (t,) times: (t, feet), and by which footstep: t lists, -1 for none."""
    on = np.zeros((len(times), feet), dtype=bool)
    which = [[-1] * feet for _ in times]
    for i, one in enumerate(steps):
        for t in np.flatnonzero((times >= one.begin) & (times < one.end)):
            on[t, one.foot] = True
            which[int(t)][one.foot] = i
    return on, which


@dataclass(frozen=True)
class StepPlanner:
    """Chooses footsteps for the wanted motion of a body; arrays have a row per foot.

    Attributes
    ----------
    gait
        When feet stand.
    geometry
        What steps are like.
    sides
        (2,) 1 for the left foot, -1 for the right one.
    capture
        Share of the divergence at touchdown that moves the coming foothold; the rest goes where the wanted
        body would put it.
    """

    gait: ContactSchedule
    geometry: StepGeometry
    sides: FloatArray
    capture: float

    @property
    def step_time(self) -> float:
        """Time from touchdown to touchdown [s]."""
        return 0.5 * self.gait.period

    def foothold(
        self, k: int, body: BodyPlan, left: float, place: FloatArray, support: FloatArray
    ) -> tuple[FloatArray, float]:
        """Return place (2,) [m] and heading [rad] of the landing of a foot.

        Parameters
        ----------
        k
            Which foot.
        body
            The wanted motion.
        left
            Time until touchdown [s].
        place
            (2,) where the divergent motion then asks it to be [m].
        support
            (2,) where the other foot stands [m].
        """
        yaw, middle, _ = body.places(np.array([left]))
        heading, side, g = float(yaw[0]), float(self.sides[k]), self.geometry
        # Feet meet the ground half a stride before the body and half a step's width beside its path; toes
        # point where the body heads in the middle of the stance. Then the divergent motion's share, see
        # `capture`.
        stride = body.velocity[:2] * self.step_time
        nominal = middle[0, :2] + _turn(heading) @ (0.5 * stride + np.array([0.0, 0.5 * side * g.width]))
        wanted = (1.0 - self.capture) * nominal + self.capture * place
        toes = heading + 0.5 * self.step_time * float(body.velocity[2])
        return g.within_reach(wanted, support, heading, side), toes

    def ahead(
        self, feet: Feet, toes: list[float], body: BodyPlan, clock: float, time: float, pace: float = 1.0
    ) -> list[Footstep]:
        """Return the stances of now and of the `time` ahead [s], those of now first.

        `toes` are the headings of the feet [rad], `clock` is the gait's time [s], which goes on `pace` times
        as fast as time. After the coming foothold steps follow the wanted velocity.
        """
        later, steps = [], []
        on, ground, target = feet.stance, feet.ground, feet.target
        for k in range(2):
            spans = stances(self.gait, k, clock, time * pace)
            if pace != 1.0:  # from the gait's clock to time
                spans = [(clock + (a - clock) / pace, clock + (b - clock) / pace) for a, b in spans]
            if on[k]:
                if not spans or spans[0][0] > clock:  # landed early
                    spans = [(clock, spans[0][1] if spans else math.inf), *spans[1:]]
                steps.append(Footstep(k, *spans[0], ground[k, :2], toes[k]))
                spans = spans[1:]
            # a foot that stands for ever by the gait, and is in the air, comes down now
            later += [(begin if math.isfinite(begin) else clock, end, k) for begin, end in spans]
        flying = {k for k in range(2) if not on[k]}
        last = max(steps, key=lambda one: one.begin, default=None)
        stride, rate = body.velocity[:2] * self.step_time, float(body.velocity[2])
        for begin, end, k in sorted(later):
            yaw = body.yaw + rate * (begin - clock)
            if k in flying or last is None:
                flying.discard(k)
                place = target[k, :2]
            else:
                place = last.place + _turn(yaw) @ (
                    stride + np.array([0.0, self.sides[k] * self.geometry.width])
                )
            last = Footstep(k, begin, end, place, yaw + 0.5 * self.step_time * rate)
            steps.append(last)
        return steps

    def corners(
        self, soles: Soles, feet: Feet, corners: FloatArray, steps: list[Footstep], times: FloatArray
    ) -> tuple[BoolArray, FloatArray]:
        """Return which corners of the soles stand at (t,) times [s]: (t, p), and where: (t, p, 3) [m].

        The first of the times is now: there the feet stand as they do, on (p, 3) corners [m].
        """
        foot = soles.point_foot
        on, which = touching(steps, times, 2)
        on[0] = feet.stance
        standing = int(feet.stance.sum())  # so many of the steps are those of now
        spots = [
            corners[foot == one.foot] if i < standing else soles.spread(one.foot, one.place, one.yaw)
            for i, one in enumerate(steps)
        ]
        places = np.tile(corners, (len(times), 1, 1))
        for t, row in enumerate(which):
            for k, i in enumerate(row):
                if i >= 0:
                    places[t, foot == k] = spots[i]
        return np.asarray(on[:, foot]), places


def foot_speeds(
    feet: Feet, descent: float, steps: list[Footstep], times: FloatArray, clearance: float
) -> FloatArray:
    """Return the velocities of the feet at (t,) times of the gait's clock [s]: (t, 2, 3) [m/s], world axes.

    Standing feet rest; flying ones go to their next footstep, later ones `clearance` [m] high.
    """
    on = feet.stance
    out = np.zeros((len(times), 2, 3))
    for k in range(2):
        own = [one for one in steps if one.foot == k]
        foot = feet.foot[k]
        lifted, start = times[0], foot["start"]
        if not on[k]:
            lifted = times[0] - float(foot["share"] * foot["duration"])
        for one in own:
            flight = one.begin - lifted
            goal = foot["target"] if one is own[0] else np.array([*one.place, start[2]])
            apex = float(foot["apex"]) if one is own[0] else max(start[2], goal[2]) + clearance
            if math.isfinite(flight) and flight > 1e-3:
                for t in np.flatnonzero((times >= lifted) & (times < one.begin)):
                    share = (float(times[t]) - lifted) / flight
                    out[t, k] = swing_motion(start, goal, apex, share, flight, descent)[1]
            lifted, start = one.end, goal
    return out


def landing_offsets(
    preview: PendulumPreview, steps: list[Footstep], clock: float, pressure: FloatArray
) -> FloatArray:
    """Return where the divergent motion is over the next landing of each foot then: (2, 2) [m].

    `pressure` (k, 2) [m] is the centre of pressure ahead of the time of the gait's `clock` [s].
    """
    ahead, offsets = preview.divergent(pressure), np.zeros((2, 2))
    for one in reversed(steps):
        at = (one.begin - clock) / preview.dt  # between two steps of the preview: linear
        if 0.0 < at < preview.steps:
            i = int(at)
            offsets[one.foot] = ahead[i] + (at - i) * (ahead[i + 1] - ahead[i]) - one.place
    return offsets


def _turn(yaw: float) -> FloatArray:
    """Return the (2, 2) rotation by an angle [rad]."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s], [s, c]])
