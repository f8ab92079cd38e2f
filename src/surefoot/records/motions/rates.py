"""The rate of a motion: what its file says, what its velocities say, and how fast it falls in the air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, positive_number
from surefoot.base.errors import ProblemError
from surefoot.base.libraries import import_pinocchio
from surefoot.base.spatial import GRAVITY
from surefoot.records.motions.fields import MotionFields

if TYPE_CHECKING:
    from surefoot.mechanics import Robot

COMMON = (24.0, 25.0, 30.0, 50.0, 60.0, 100.0, 120.0, 200.0, 240.0)
"""Rates that motions usually have [Hz]."""
HIGH = 0.04
"""Height of all feet above the floor near by from which the robot is in the air [m]."""
UPRIGHT = 0.6
"""Height of the base above the floor near by over its nominal one, below which other links may bear it."""
NEAR = 60
"""Frames before and after one whose lowest foot is the floor near by."""
SHORTEST = 5
"""Frames of an airborne phase from which its fall is measured."""
CURVED = 0.1
"""Deviation of the height of the centre of mass from a parabola over its rise, a share, in free fall."""
FRAMES = 4000
"""Frames that are searched for airborne phases."""
AGREEMENT = 0.05
"""Deviation of an airborne phase's rate from the middle one, and of that from a usual rate, up to which it
is guessed.

At 0.1 and two phases, two of the 40 motions of LAFAN1 were guessed to have 60 Hz instead of 30: where
lengths were scaled and times were not, falls tell a wrong rate.
"""
FEWEST = 3
"""Airborne phases from which a rate is guessed, or doubted."""
CONTRADICTION = 0.3
"""Deviation of the fall from gravity, a share, from which the rate is doubtful."""


@dataclass(frozen=True)
class Falls:
    """Airborne phases: how the centre of mass falls.

    Attributes
    ----------
    accelerations
        (k,) downwards, per frame squared [m].
    frames
        (k,) lengths.
    """

    accelerations: FloatArray
    frames: IntArray

    @property
    def rate(self) -> float:
        """Rate at which the middle one falls as gravity has it [Hz]; NaN without any."""
        if len(self.accelerations) == 0:
            return float("nan")
        return float(np.sqrt(GRAVITY / np.median(self.accelerations)))


def falls_of(robot: Robot, q: FloatArray) -> Falls:
    """Return the airborne phases of a motion: all feet above the floor near by, and the centre of mass falls.

    Parameters
    ----------
    robot, q
        The robot and its (T, nq) configurations.
    """
    none = Falls(np.empty(0), np.empty(0, dtype=np.int64))
    if not robot.floating or not robot.feet or len(q) < SHORTEST + 2:
        return none
    pinocchio, data = import_pinocchio(), robot.model.createData()
    rows = q[:FRAMES]
    low = np.array([min(robot.sphere_bottoms(row)) for row in rows])
    floor = np.array([low[max(k - NEAR, 0) : k + NEAR].min() for k in range(len(low))])
    upright = rows[:, 2] > floor + UPRIGHT * robot.nominal[2]
    edges = np.flatnonzero(np.diff(((low > floor + HIGH) & upright).astype(int), prepend=0, append=0))
    found = list[tuple[float, int]]()
    for begin, end in edges.reshape(-1, 2):
        if end - begin < SHORTEST or begin == 0 or end == len(rows):
            continue
        inner = rows[begin + 1 : end - 1] if end - begin > SHORTEST + 2 else rows[begin:end]
        heights = np.array([pinocchio.centerOfMass(robot.model, data, row)[2] for row in inner])
        count = len(heights)
        fit = np.polynomial.polynomial.polyfit(np.arange(count), heights, 2)
        left = heights - np.polynomial.polynomial.polyval(np.arange(count), fit)
        bend = -2.0 * float(fit[2])  # a parabola of this bend rises by bend count² / 8
        if bend > 1e-4 and float(np.sqrt((left**2).mean())) < CURVED * bend * count**2 / 8.0:
            found.append((bend, int(end - begin)))
    return (
        Falls(np.array([one for one, _ in found]), np.array([n for _, n in found], dtype=np.int64))
        if found
        else none
    )


def rate_by_speeds(fields: MotionFields) -> float | None:
    """Return the rate at which the file's joint velocities are its angles' differences [Hz], None without."""
    if fields.speeds is None:
        return None
    steps = np.diff(fields.joints, axis=0)
    speeds = 0.5 * (fields.speeds[1:] + fields.speeds[:-1])
    size = float((steps**2).sum())
    if size < 1e-8:
        return None
    rate = float((steps * speeds).sum()) / size
    left = float(((speeds - rate * steps) ** 2).sum())
    return rate if rate > 0.0 and left < 0.25 * float((speeds**2).sum()) else None


def find_rate(
    robot: Robot, fields: MotionFields, q: FloatArray, given: float | None
) -> tuple[float, list[str]]:
    """Return the rate of a motion [Hz], and what is told of it.

    Parameters
    ----------
    robot, fields, q
        The robot, what the file has, and its (T, nq) configurations.
    given
        What a user gives [Hz], None for nothing.

    Raises
    ------
    ProblemError
        Where nothing says it, with what to give.
    """
    notes = list[str]()
    said = fields.rate
    if fields.times is not None:
        by_times = (len(fields.times) - 1) / float(fields.times[-1] - fields.times[0])
        if said is not None and abs(said / by_times - 1.0) > 0.02:
            notes.append(
                f"doubt: rate: the file says {said:.6g} Hz, its times {by_times:.6g}; the times are used"
            )
        said = by_times
    speeds = rate_by_speeds(fields)
    if given is not None:
        rate = positive_number("fps", given, "Hz")
        if said is not None and abs(said / rate - 1.0) > 0.02:
            notes.append(f"doubt: rate: fps={rate:.6g} was given, the file says {said:.6g} Hz")
    elif said is not None:
        rate = said
    elif speeds is not None:
        rate = _common(speeds, 0.05)
        notes.append(f"rate: guessed as {rate:.6g} Hz by the file's velocities, which give {speeds:.4g}")
    else:
        rate = _by_falls(falls_of(robot, q), notes)
        return rate, notes
    if speeds is not None and abs(speeds / rate - 1.0) > 0.2:
        notes.append(f"doubt: rate: {rate:.6g} Hz, by the file's velocities {speeds:.4g}")
    _doubt_by_falls(falls_of(robot, q), rate, notes)
    return rate, notes


def _common(rate: float, within: float) -> float:
    """Return the usual rate next to one, or that rate where none is near."""
    near = min(COMMON, key=lambda one: abs(np.log(one / rate)))
    return near if abs(near / rate - 1.0) < within else rate


def _by_falls(falls: Falls, notes: list[str]) -> float:
    """Return the rate by gravity, or refuse where airborne phases are few or tell no usual rate."""
    count = len(falls.accelerations)
    if count == 0:
        raise ProblemError("nothing in it says the rate: give fps=, frames per second")
    phases = f"its {count} airborne phase{'s' if count > 1 else ''}"
    fall = f"{phases} would fall as gravity has it at {falls.rate:.3g} Hz"
    apart = np.abs(np.sqrt(GRAVITY / falls.accelerations) / falls.rate - 1.0).max()
    near = _common(falls.rate, AGREEMENT)
    if count < FEWEST or apart > AGREEMENT or near not in COMMON:
        raise ProblemError(f"nothing in it says the rate: give fps=, frames per second; {fall}")
    notes.append(f"doubt: rate: guessed as {near:g} Hz, {fall}")
    return near


def _doubt_by_falls(falls: Falls, rate: float, notes: list[str]) -> None:
    """Tell where airborne phases do not fall as gravity has it at the rate."""
    count = len(falls.accelerations)
    fall = float(np.median(falls.accelerations)) * rate**2 if count else GRAVITY
    if count >= FEWEST and abs(fall / GRAVITY - 1.0) > CONTRADICTION:
        notes.append(
            f"doubt: rate: at {rate:.6g} Hz its {count} airborne phases fall at {fall:.2g} m/s² (median), at "
            f"{falls.rate:.3g} Hz as gravity has it"
        )
