"""Stance, swing targets and phases of the feet: the gait schedule corrected by contact detection."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import alike
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Terrain
from surefoot.motion.gaits.contact_schedule import ContactSchedule
from surefoot.motion.walking import swing
from surefoot.motion.walking.feet_settings import FEET
from surefoot.motion.walking.foot_phases import (
    SEARCHING,
    FeetContact,
    FootArray,
    advance_feet,
    aim_foot,
    copied_feet,
    feet_in_stance,
    lift_foot,
    swing_accelerations,
    swing_paths,
)
from surefoot.motion.walking.foothold import choose_foothold
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.swing import DOWN, LIFT_FIRST, apex_height, clear_lift

PATH_SAMPLES = 7


class SwingRequest(NamedTuple):
    """How feet in the air should go in a step.

    Attributes
    ----------
    clearance
        Height of the swing over the ground [m].
    heading
        (2,) along which feet are moved off edges; None for each one's own way.
    stride
        (2,) from one stand to the next in step with stairs: it chooses the tread [m]; None elsewhere.
    """

    clearance: float
    heading: FloatArray | None = None
    stride: FloatArray | None = None


class Feet:
    """The feet of a walk: one array of records, and what is read of it in every step, a row per foot.

    Parameters
    ----------
    foot
        (n,) records of `FOOT`, which nobody changes any more.
    same
        Feet whose stance, `planned`, targets and ground are the same, so that they need not be read again.
    but
        The foot whose target and frame differ from theirs; None for none.

    Attributes
    ----------
    foot
        As given.
    stance, planned
        (n,) which feet push now, and which the gait wants on the ground.
    target
        (n, 3) where feet in the air will touch (centre of the foot), or last did [m].
    ground, frames
        (n, 3) contact point where each foot last stood [m], (n, 3, 3) rotation_world_contact of its ground.
    """

    __slots__ = ("foot", "frames", "ground", "planned", "stance", "target")
    stance: BoolArray
    planned: BoolArray
    target: FloatArray
    ground: FloatArray
    frames: FloatArray

    def __init__(self, foot: FootArray, same: Feet | None = None, but: int | None = None) -> None:
        self.foot = foot
        if same is not None:  # reading the records takes longer than the step that made them
            self.stance, self.planned, self.target = same.stance, same.planned, same.target
            self.ground, self.frames = same.ground, same.frames
            if but is not None:
                self.target, self.frames = same.target.copy(), same.frames.copy()
                self.target[but], self.frames[but] = foot[but]["target"], foot[but]["frame"]
            return
        self.stance = np.logical_not(foot["phase"])  # STANCE is 0
        self.planned = foot["planned"].astype(np.bool_)
        self.target = foot["target"].copy()
        self.ground = foot["ground"]
        self.frames = foot["frame"].copy()

    def __eq__(self, other: object) -> bool:
        """Return whether other feet are the same to the last bit."""
        return isinstance(other, Feet) and alike(self.foot, other.foot)

    __hash__ = None  # type: ignore[assignment]

    def _asdict(self) -> dict[str, Any]:
        """Return what other feet are made of to be the same."""
        return {"foot": self.foot}

    def __reduce__(self) -> tuple[type, tuple[FootArray]]:
        """Return what makes a copy."""
        return Feet, (self.foot.copy(),)

    @property
    def searching(self) -> BoolArray:
        """(n,) which feet should be on the ground but have not found it."""
        return np.asarray(self.foot["phase"] == SEARCHING)

    @property
    def overdue(self) -> BoolArray:
        """(n,) which feet should stand by now and do not."""
        return self.planned & ~self.stance


class FeetModel:
    """What does not change about the feet of a walk, and the steps of their state.

    No method changes the feet that it is given: each returns those that it has made of them.

    Parameters
    ----------
    terrain
        The ground that is planned on.
    radii
        (n,) of the feet [m].
    clearance, descent
        Usual height of a swing [m], and speed towards the ground at its end [m/s].

    Attributes
    ----------
    reach
        Largest distance of a foothold from its nominal place where the ground is rough [m].
    """

    def __init__(self, terrain: Terrain, radii: FloatArray, clearance: float, descent: float) -> None:
        self.terrain, self.radii, self.descent, self.reach = terrain, radii, descent, 1.2 * clearance
        self._margin = float(2.0 * radii.mean())  # to edges [m]

    def standing(self, centres: FloatArray) -> Feet:
        """Return feet that stand at (n, 3) centres [m]."""
        frames = np.array([self.terrain.frame(c[:2]) for c in centres])
        return Feet(feet_in_stance(centres, frames, self.radii, self.lift_first))

    @property
    def lift_first(self) -> float:
        """Share of a swing that begins in which its foot only lifts, see `FOOT`."""
        return swing.EVEN if self.terrain.planar else LIFT_FIRST

    def soles(self, feet: Feet, centres: FloatArray) -> FloatArray:
        """Return the lowest points of feet at (n, 3) centres, along the ground's normals: (n, 3) [m]."""
        return np.asarray(centres - self.radii[:, None] * feet.foot["frame"][:, :, 2])

    def advance(
        self, feet: Feet, schedule: ContactSchedule, clock: GaitClock, contact: FeetContact,
        centres: FloatArray, careful: bool = False,
    ) -> tuple[Feet, bool]:  # fmt: skip
        """Return the feet at a time of a schedule, and whether one has lifted, landed or lost the ground.

        Parameters
        ----------
        feet
            As they were.
        schedule, clock
            When feet should stand, and the time on it.
        contact
            What the feet feel.
        centres
            (n, 3) where they are [m].
        careful
            See `advance_feet`.
        """
        foot, changed, landed, as_before = advance_feet(
            feet.foot, schedule.phases(clock.time), clock, contact, centres, careful, self.lift_first
        )  # fmt: skip
        if as_before:
            return Feet(foot, feet), changed
        for k in range(len(centres)) if landed else ():
            if landed >> k & 1:
                self._stand(foot[k], self.radii[k], centres[k])
        return Feet(foot), changed

    @staticmethod
    def hurried(feet: Feet, before: float, rate: float) -> Feet:
        """Return feet whose swings go at a rate in place of the one before, see `GaitClock`."""
        if rate == before:
            return feet
        foot = copied_feet(feet.foot)
        foot["duration"] *= before / rate
        return Feet(foot)

    def leap(self, feet: Feet, clock: GaitClock, air: float, centres: FloatArray) -> Feet:
        """Return feet that all leave the ground at once, from (n, 3) `centres` [m], for `air` [s]."""
        foot = copied_feet(feet.foot)
        for k, centre in enumerate(centres):
            lift_foot(foot, k, clock.time, air / clock.rate, centre, self.lift_first)
        return Feet(foot)

    @staticmethod
    def following(feet: Feet, schedule: ContactSchedule, time: float) -> Feet:
        """Return feet that follow another schedule from a time on: who stands waits for the next swing."""
        foot = copied_feet(feet.foot)
        foot["lifted_at"] = schedule.phases(time)[:, 1]
        return Feet(foot)

    @staticmethod
    def slow_search(feet: Feet, clock: GaitClock, before: float, fastest: float, ahead: FloatArray) -> Feet:
        """Return feet of which those that search go down at another speed from now on, without a jump.

        Parameters
        ----------
        feet, clock
            Now.
        before, fastest
            Largest speed of the search until now and from now on [m/s].
        ahead
            (2,) how much farther along x and y of the world they come down than before [m].
        """
        search, foot = FEET.search_fast * GRAVITY, copied_feet(feet.foot)
        for k in np.flatnonzero(feet.searching).tolist():
            late = clock.time + clock.behind - float(foot[k]["search_from"])
            rush, was = (min(late, speed / search) for speed in (fastest, before))
            foot[k]["target"][2] += search * (rush * (late - 0.5 * rush) - was * (late - 0.5 * was))
            foot[k]["target"][:2] += ahead
        return Feet(foot)

    @staticmethod
    def lowered(feet: Feet, which: BoolArray, soles: FloatArray) -> Feet:
        """Return feet of which (n,) some take the ground to be at their (n, 3) lowest points [m]."""
        foot = copied_feet(feet.foot)
        foot["ground"][which] = soles[which]
        return Feet(foot)

    def _stand(self, foot: Any, radius: float, centre: FloatArray) -> None:
        """Write the ground under a foot that has landed at its (3,) centre [m]."""
        if not self.terrain.planar:
            foot["frame"] = self.terrain.frame(centre[:2])
        foot["ground"] = centre - radius * foot["frame"][:, 2]

    def aimed(
        self, feet: Feet, k: int, place: FloatArray, request: SwingRequest, latest: float | None = None
    ) -> Feet:
        """Return feet of which one in the air goes to a (2,) nominal place [m], moved to good ground.

        Up to the share `latest` of the swing it is taken as it is, for a caller that leads the foot there.
        """
        foot, radius, terrain = feet.foot[k], float(self.radii[k]), self.terrain
        share, start, target = float(foot["share"]), foot["start"], feet.target[k].copy()
        if share > (latest or (FEET.freeze if terrain.planar else FEET.freeze_rough)):
            return feet
        if share > FEET.freeze_rough and latest is None:  # ever less can be changed without a rush
            trust = (FEET.freeze - share) / (FEET.freeze - FEET.freeze_rough)
            place = target[:2] + trust * (place - target[:2])
        way = place - start[:2] if request.heading is None else request.heading
        before = None if request.stride is None else start[:2] + request.stride
        if share > FEET.chosen:
            before = target[:2].copy()
        more = math.inf if share > FEET.chosen else FEET.same_tread * radius
        xy = choose_foothold(terrain, place, self.reach, self._margin, way, before, more)
        # the sphere touches the tangent plane: its centre is radius / n_z above the ground on the vertical
        noise, upwards = (
            terrain.noise_at(xy),
            feet.frames[k, 2, 2] if terrain.planar else terrain.normal(xy)[2],
        )
        sink_from = DOWN - (DOWN - FEET.down_noisy) * min(noise / FEET.noisy, 1.0)
        target[:2], target[2] = xy, float(terrain.height(xy)) + (FEET.raised * noise + radius / upwards)
        frame = feet.frames[k] if terrain.planar else np.ascontiguousarray(terrain.frame(xy))
        if terrain.planar or self._even(foot, target, radius, noise):
            lift_first = swing.EVEN
            target[2] -= FEET.raised * noise  # a late foot costs more than an early one
            # the bump is put on the line between both ends, which is as steep as the plane
            apex = 0.5 * float(start[2] + target[2]) + request.clearance
        else:
            apex = float(apex_height(start, target, self._below(start, target, radius), request.clearance))
            lift_first = clear_lift(start, target, apex, terrain, radius, 0.5 * radius)
        return Feet(aim_foot(feet.foot, k, target, frame, apex, lift_first, sink_from), feet, k)

    def _below(self, start: FloatArray, target: FloatArray, radius: float) -> FloatArray:
        """Return the least heights of a foot over the ground on its way: (PATH_SAMPLES,) [m]."""
        path = start[:2] + np.linspace(0.0, 1.0, PATH_SAMPLES)[:, None] * (target[:2] - start[:2])
        return np.asarray(self.terrain.height(path) + radius)

    def _even(self, foot: Any, target: FloatArray, radius: float, noise: float) -> bool:
        """Return whether a fast swing goes over ground that is even but for some noise [m].

        A leg that trails behind a fast body is stretched if its foot has to lift first.
        """
        if foot["share"] > FEET.even_until or not self.terrain.learns:
            return bool(foot["lift_first"] < 0.0)
        start = foot["start"]
        way = max(float(np.linalg.norm(target[:2] - start[:2])), 1e-9)
        line = np.linspace(start[2], target[2], PATH_SAMPLES)
        hurry = way / (self.descent / FEET.descent * foot["duration"]) + abs(line[-1] - line[0]) / way
        off = np.abs(self._below(start, target, radius) - line).max()
        return bool(hurry > FEET.fast and off < FEET.even * radius + noise)

    def accelerations(
        self, feet: Feet, clock: GaitClock, fastest: float | None, centres: FloatArray,
        twists: FloatArray, gain: tuple[float, float],
    ) -> FloatArray:  # fmt: skip
        """Return the reference accelerations of the feet in the air, else zero: (n, 6) [m/s², rad/s²].

        Parameters
        ----------
        feet, clock
            Now.
        fastest
            Largest speed of the search on ground that is not known [m/s]; None on known ground.
        centres, twists
            (n, 3), (n, 6) where the feet are and how they move, world axes [m], [m/s, rad/s].
        gain
            Stiffness [1/s²] and damping [1/s] of the feedback.
        """
        return swing_accelerations(
            feet.foot, clock.time + clock.behind, self.descent, *_search(fastest), centres, twists, *gain
        )

    def motions(self, feet: Feet, clock: GaitClock, fastest: float | None = None) -> FloatArray:
        """Return reference place [m], velocity and acceleration of feet in the air, else zero: (n, 3, 3).

        Parameters as for `accelerations`.
        """
        return swing_paths(feet.foot, clock.time + clock.behind, self.descent, *_search(fastest))


def _search(fastest: float | None) -> tuple[float, float]:
    """Return acceleration [m/s²] and largest speed [m/s] of the search, given it where ground is unknown."""
    if fastest is None:
        return FEET.search * GRAVITY, math.inf
    return FEET.search_fast * GRAVITY, fastest
