"""The phases of a walking foot, the record that holds its state, and the one table of transitions.

    STANCE ──── the schedule's swing begins ───────────────> SWING
    STANCE ──── no touch for `LOST_TIME` ──────────────────> SEARCHING
    STANCE ──── its touchdown is found to be false ────────> SWING, or SEARCHING by the rule above
    SWING ───── touch after the share `EARLY` ─────────────> STANCE
    SWING ───── an edge is struck, once a swing ───────────> RESTARTED
    SWING ───── the window is over without touch ──────────> SEARCHING
    RESTARTED ─ touch after the share `EARLY` ─────────────> STANCE
    RESTARTED ─ its window is over ────────────────────────> SEARCHING, or SWING while the schedule's lasts
    SEARCHING ─ touch ─────────────────────────────────────> STANCE
    SEARCHING ─ the schedule's next swing begins ──────────> SWING

`advance_feet` is this table, and nothing else writes `phase`, but for a leap, in which all feet lift at once
(`lift_foot`). The picture is in docs/walking.md.
"""

from __future__ import annotations

import math
from enum import IntEnum
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import BOOLEAN, INTEGER, MATRIX, REAL, VECTOR, entry_point, kernel
from surefoot.motion.walking.feet_settings import FOOT_PHASES
from surefoot.motion.walking.gait_clock import GaitClock
from surefoot.motion.walking.swing import DOWN, LIFT_LATER, swing_motion

FootArray: TypeAlias = NDArray[np.void]
"""(n,) records of `FOOT`, one a foot."""
EARLY, LOST_TIME, RETRY = FOOT_PHASES.early, FOOT_PHASES.release_time, FOOT_PHASES.retry
"""Settings, as compiled code folds them."""
RESTART_LIFT = LIFT_LATER[-1]
"""Share of a restarted swing in which the foot only lifts [-]: an edge is before it."""


class FootPhase(IntEnum):
    """What a foot does now."""

    STANCE = 0
    SWING = 1
    RESTARTED = 2
    SEARCHING = 3


STANCE, SWING, RESTARTED, SEARCHING = (int(phase) for phase in FootPhase)
FOOT = np.dtype(
    [
        ("phase", "i8"), ("planned", "i8"), ("share", "f8"), ("duration", "f8"), ("touched_at", "f8"),
        ("lifted_at", "f8"), ("restart", "f8", 2), ("search_from", "f8"), ("start", "f8", 3),
        ("target", "f8", 3), ("previous_target", "f8", 3), ("ground", "f8", 3), ("frame", "f8", (3, 3)),
        ("apex", "f8"), ("lift_first", "f8"), ("sink_from", "f8"), ("lift_rotation", "f8", (3, 3)),
        ("land_rotation", "f8", (3, 3)),
    ],
    align=True,
)  # fmt: skip
"""The state of a foot.

==================  ========================================================================================
phase, planned      `FootPhase`; 1 while the schedule wants the foot on the ground
share, duration     of its swing, the time since lift-off over its duration [-]; that duration [s]
touched_at          time of the schedule at which it last touched the ground [s]
lifted_at           time of the schedule at which its last swing began [s]
restart             begin and end of its restarted swing, time since the gait's start [s]; -inf for none
search_from         begin of its search for the ground, time since the gait's start [s]
start, target       lift-off, and touchdown to come or last one: the centre of the foot [m]
previous_target     target that it had when it landed, for a touchdown that is found to be false [m]
ground, frame       contact point where it last stood [m], and rotation_world_contact of its ground
apex, lift_first    of its path (`swing_motion`): greatest height [m], share of the swing to lift first
sink_from           share of the swing from which it only sinks [-]
lift_rotation       of a sole: rotation of its frame when it lifted, and the one in which it lands; those of
land_rotation       point feet are zero
==================  ========================================================================================
"""


class FeetContact(NamedTuple):
    """Contact of the feet at a step, as it is classified.

    Attributes
    ----------
    touching
        (n,) which feet feel the ground.
    struck
        (n,) which feet in the air have struck an edge.
    false
        (n,) which feet have been taken to stand by a false touchdown.
    """

    touching: BoolArray
    struck: BoolArray
    false: BoolArray

    @staticmethod
    def of(sensed: BoolArray) -> FeetContact:
        """Return the contact of feet that touch the ground where they sense anything, (n,)."""
        none = _none(len(sensed))
        return FeetContact(np.ascontiguousarray(sensed, dtype=np.bool_), none, none)


@cache
def _none(feet: int) -> BoolArray:
    """Return a mask of none of so many feet, which is not to be written to."""
    mask = np.zeros(feet, dtype=np.bool_)
    mask.setflags(write=False)
    return mask


def feet_in_stance(
    centres: FloatArray, frames: FloatArray, radii: FloatArray, lift_first: float
) -> FootArray:
    """Return feet that stand, at (n, 3) centres [m] on ground with (n, 3, 3) frames; radii (n,) [m]."""
    feet = np.zeros(len(centres), dtype=FOOT)
    feet["phase"], feet["planned"], feet["duration"] = STANCE, 1, 1.0
    feet["lifted_at"], feet["restart"] = -np.inf, -np.inf
    feet["start"] = feet["target"] = feet["previous_target"] = centres
    feet["frame"], feet["apex"] = frames, centres[:, 2]
    feet["ground"] = centres - radii[:, None] * frames[:, :, 2]
    feet["lift_first"], feet["sink_from"] = lift_first, DOWN
    return feet


def copied_feet(feet: FootArray) -> FootArray:
    """Return a copy of feet: as plain numbers, for NumPy copies records field by field, and slowly."""
    return feet.view(np.float64).copy().view(FOOT)


@kernel
def lift_foot(
    feet: Any, k: int, begin: float, duration: float, centre: FloatArray, lift_first: float
) -> None:
    """Begin a swing of foot k at a time of the schedule [s], for a duration [s], from its (3,) centre [m]."""
    foot = feet[k]
    foot.phase, foot.lifted_at, foot.duration, foot.lift_first = SWING, begin, duration, lift_first
    for i in range(3):
        foot.start[i] = centre[i]
    foot.restart[0] = foot.restart[1] = -math.inf


@kernel
def _land(feet: Any, k: int, centre: FloatArray) -> int:
    """Let foot k stand at its (3,) centre [m]; return its bit."""
    foot = feet[k]
    foot.phase = STANCE
    for i in range(3):
        foot.previous_target[i], foot.target[i] = foot.target[i], centre[i]
    return 1 << k


@kernel
def _advance(
    before: Any, phases: FloatArray, clock: float, behind: float, rate: float, touching: BoolArray,
    struck: BoolArray, false: BoolArray, centres: FloatArray, careful: bool, lift_first: float,
) -> tuple[Any, bool, int, bool]:  # fmt: skip
    """Return what `advance_feet` does; the copy is made here, where it takes a tenth of the time."""
    feet = np.empty_like(before)
    for k in range(before.shape[0]):
        feet[k] = before[k]
    changed, landed, now, as_before = False, 0, clock + behind, True
    for k in range(feet.shape[0]):
        foot = feet[k]
        on, begin, end = phases[k, 0] > 0.0, phases[k, 1], phases[k, 2]
        if struck[k]:  # SWING -> RESTARTED
            rest = foot.duration if on else max(end - clock, RETRY * (end - begin))
            foot.restart[0], foot.restart[1] = now, now + rest
            foot.share, foot.duration, foot.lift_first = 0.0, rest, RESTART_LIFT
            for i in range(3):
                foot.start[i] = centres[k, i]
        if false[k] and foot.planned != 0:
            foot.touched_at = -math.inf  # STANCE -> SEARCHING, below
        elif false[k]:  # STANCE -> SWING
            foot.phase = SWING
            for i in range(3):
                foot.target[i] = foot.previous_target[i]
        if careful and foot.phase == SEARCHING and not on and begin > foot.lifted_at:  # SEARCHING -> SWING
            lift_foot(feet, k, begin, (end - begin) / rate, centres[k], lift_first)
        foot.planned = 1 if on else 0
        if touching[k]:
            foot.touched_at = clock
        if foot.phase != STANCE and now < foot.restart[1]:
            foot.phase = RESTARTED
            foot.share = (now - foot.restart[0]) / (foot.restart[1] - foot.restart[0])
            if touching[k] and foot.share > EARLY:  # RESTARTED -> STANCE
                changed, landed = True, landed | _land(feet, k, centres[k])
        elif not on:
            foot.share = (clock - begin) / (end - begin)
            if foot.phase == STANCE:
                if begin > foot.lifted_at:  # STANCE -> SWING
                    changed = True
                    lift_foot(feet, k, begin, (end - begin) / rate, centres[k], lift_first)
            else:
                foot.phase = SWING  # RESTARTED, SEARCHING -> SWING
                if touching[k] and foot.share > EARLY:  # SWING -> STANCE
                    changed, landed = True, landed | _land(feet, k, centres[k])
        elif foot.phase == STANCE:
            if clock - foot.touched_at > LOST_TIME:  # STANCE -> SEARCHING
                changed, foot.phase = True, SEARCHING
                for i in range(3):
                    foot.start[i] = foot.target[i] = centres[k, i]
                foot.apex, foot.share, foot.duration = centres[k, 2], 1.0, LOST_TIME
                foot.touched_at, foot.search_from = clock, now
        elif touching[k]:  # SWING, SEARCHING -> STANCE
            changed, landed = True, landed | _land(feet, k, centres[k])
        elif foot.phase != SEARCHING:  # SWING, RESTARTED -> SEARCHING
            foot.phase = SEARCHING
            foot.search_from = max(max(begin, foot.touched_at) + behind, foot.restart[1])
        stays = (foot.phase == STANCE) == (before[k].phase == STANCE) and foot.planned == before[k].planned
        as_before = as_before and stays and not false[k]
    return feet, changed, landed, as_before and not changed


@cache
def _record() -> Any:
    """Return the compiled type of an array of feet."""
    return numba.from_dtype(FOOT)[::1]


@cache
def _advancing() -> Any:
    """Return `_advance` past the look at its arguments, which takes long for records."""
    masks = BOOLEAN[::1]
    return entry_point(
        _advance, _record(), MATRIX, REAL, REAL, REAL, masks, masks, masks, MATRIX, BOOLEAN, REAL
    )


def advance_feet(
    feet: FootArray, phases: FloatArray, clock: GaitClock, contact: FeetContact, centres: FloatArray,
    careful: bool, lift_first: float,
) -> tuple[FootArray, bool, int, bool]:  # fmt: skip
    """Return the feet at a time, whether any has lifted, landed or lost the ground, and which have landed.

    Parameters
    ----------
    feet
        (n,) records of `FOOT`, as they were.
    phases
        (n, 3) see `ContactSchedule.phases`.
    clock
        The time on the schedule.
    contact
        What the feet feel.
    centres
        (n, 3) where the feet are [m].
    careful
        Whether a foot that still searches when its next swing begins lifts from where it is then.
    lift_first
        Of a swing that begins, see `FOOT`.

    Returns
    -------
    The feet, whether anything has changed, and which feet have landed, as a sum of 2^k; the ground of these
    is still that of their last stance. Last, whether stance, `planned`, targets and ground are all as they
    were, which saves a caller that has read them before from reading them again.
    """
    out: tuple[FootArray, bool, int, bool] = _advancing()(
        feet, phases, *clock, *contact, centres, careful, lift_first
    )
    return out


@kernel
def _aim(
    before: Any, k: int, target: FloatArray, frame: FloatArray, apex: float, lift_first: float,
    sink_from: float,
) -> Any:  # fmt: skip
    """Return what `aim_foot` does."""
    feet = np.empty_like(before)
    for i in range(before.shape[0]):
        feet[i] = before[i]
    foot = feet[k]
    foot.apex, foot.lift_first, foot.sink_from = apex, lift_first, sink_from
    for i in range(3):
        foot.target[i] = target[i]
        for j in range(3):
            foot.frame[i, j] = frame[i, j]
    return feet


@cache
def _aiming() -> Any:
    """Return `_aim` past the look at its arguments."""
    return entry_point(_aim, _record(), INTEGER, VECTOR, MATRIX, REAL, REAL, REAL)


def aim_foot(
    feet: FootArray, k: int, target: FloatArray, frame: FloatArray, apex: float, lift_first: float,
    sink_from: float,
) -> FootArray:  # fmt: skip
    """Return feet of which foot k swings to a (3,) target [m] on ground with a (3, 3) frame, see `FOOT`."""
    out: FootArray = _aiming()(feet, k, target, frame, apex, lift_first, sink_from)
    return out


@kernel
def _paths(feet: Any, now: float, descent: float, search: float, fastest: float) -> FloatArray:
    """Return the motion of feet in the air, see `swing_paths`."""
    out = np.zeros((feet.shape[0], 3, 3))
    for k in range(feet.shape[0]):
        foot = feet[k]
        if foot.phase == STANCE:
            continue
        path, share, late = out[k], foot.share, -1.0
        if foot.phase == SEARCHING:
            late = max(now - foot.search_from, 0.0)
            share = 1.0 + late / foot.duration
        path[:] = swing_motion(
            foot.start, foot.target, foot.apex, share, foot.duration, descent, foot.lift_first, foot.sink_from
        )
        # A searching foot goes below its target: down at the acceleration `search` until it is `fastest`,
        # then steadily, beside the swing's own descent.
        if late >= 0.0:
            rush = min(late, fastest / search)
            path[0, 2] -= search * rush * (late - 0.5 * rush)
            path[1, 2] -= search * rush
            if rush == late:
                path[2, 2] -= search
    return out


@kernel
def _accelerations(
    feet: Any, now: float, descent: float, search: float, fastest: float, centres: FloatArray,
    twists: FloatArray, stiffness: float, damping: float,
) -> FloatArray:  # fmt: skip
    """Return the accelerations of feet in the air, see `swing_accelerations`."""
    out = np.zeros((feet.shape[0], 6))
    paths = _paths(feet, now, descent, search, fastest)
    for k in range(feet.shape[0]):
        if feet[k].phase != STANCE:
            for i in range(3):
                miss, lag = paths[k, 0, i] - centres[k, i], paths[k, 1, i] - twists[k, i]
                out[k, i] = paths[k, 2, i] + stiffness * miss + damping * lag
    return out


@cache
def _path_kernel() -> Any:
    """Return `_paths` past the look at its arguments; a walk that never leaps does not load it."""
    return entry_point(_paths, _record(), REAL, REAL, REAL, REAL)


@cache
def _acceleration_kernel() -> Any:
    """Return `_accelerations` past the look at its arguments."""
    return entry_point(_accelerations, _record(), REAL, REAL, REAL, REAL, MATRIX, MATRIX, REAL, REAL)


def swing_paths(feet: FootArray, now: float, descent: float, search: float, fastest: float) -> FloatArray:
    """Return the reference place, velocity and acceleration of feet in the air: (n, 3, 3), zero in stance.

    Parameters
    ----------
    feet
        (n,) records of `FOOT`.
    now
        Time since the gait's start [s].
    descent, search, fastest
        Speed towards the ground at the end of a swing [m/s]; acceleration with which a searching foot goes
        down [m/s²], and largest speed that it gets so [m/s].
    """
    return np.asarray(_path_kernel()(feet, now, descent, search, fastest))


def swing_accelerations(
    feet: FootArray, now: float, descent: float, search: float, fastest: float, centres: FloatArray,
    twists: FloatArray, stiffness: float, damping: float,
) -> FloatArray:  # fmt: skip
    """Return the (n, 6) accelerations of feet in the air, with feedback on where they are and how they move.

    Parameters
    ----------
    feet, now, descent, search, fastest
        As for `swing_paths`.
    centres, twists
        (n, 3), (n, 6) measured, world axes [m], [m/s, rad/s].
    stiffness, damping
        Of the feedback [1/s²], [1/s].
    """
    return np.asarray(
        _acceleration_kernel()(feet, now, descent, search, fastest, centres, twists, stiffness, damping)
    )
