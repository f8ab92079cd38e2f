"""A trot in step with stairs: each stride takes a whole tread, or a whole part of one.

A foot that goes up by a step of 12 cm in the 0.18 s that a trot's swing takes needs more joint speed than a
motor has, and strides of another length than the tread put feet down on edges in turn. A cycle that lasts as
long as the body needs for a tread mends both: the swing has twice the time, and every foot finds its place on
every tread again. So long a time on two feet is too long for a trot: the diagonal's feet move an eighth of
the cycle apart, which leaves three feet down for a part of it.

Between a stride that takes a tread and two that do lie speeds at which the one cycle is too long and the
other too short: there the body is slowed until the shorter one is long enough.
"""

from __future__ import annotations

import math

from surefoot.mechanics import Terrain
from surefoot.motion.gaits.gait import Gait
from surefoot.motion.ground.ground_settings import GROUND_ESTIMATE
from surefoot.motion.walking.pace_settings import STAIR_GAIT
from surefoot.motion.walking.walking_body import VelocityCommand

OFFSETS = (-0.0625, 0.4375, 0.5625, 0.0625)
"""When feet touch down, front to back and left before right: between a trot's and a walk's."""


def stair_gait(
    terrain: Terrain, command: VelocityCommand, height: float, period: float, feet: int
) -> Gait | None:
    """Return the trot in step with known stairs for the fastest forward speed of a command.

    Parameters
    ----------
    terrain
        As believed.
    command
        To walk at, within limits.
    height
        Of the centre of mass above the ground [m].
    period
        Of the trot [s].
    feet
        Number of them.

    Returns
    -------
    None where the trot's own timing is as good: on other ground than stairs, for low steps, for a body that
    stands, or one so fast that its strides are too long for treads.

    Examples
    --------
    >>> from surefoot.mechanics.terrain import read_terrain
    >>> stairs = read_terrain("stairs:0.12,0.3", "terrain")
    >>> round(stair_gait(stairs, VelocityCommand.constant(0.4), 0.3, 0.4, 4).period, 6)
    0.75
    """
    speed = float(abs(command.values[:, 0]).max(initial=0.0))
    if feet != 4 or speed == 0.0 or not _high(terrain, height):
        return None
    cycle, shortest = _cycles(terrain, speed, height, period)
    if cycle < (1.0 - 1e-9) * shortest:
        return None
    return Gait.from_phases("trot", cycle, STAIR_GAIT.duty, [share % 1.0 for share in OFFSETS])


def speed_in_step(terrain: Terrain, speed: float, height: float, period: float) -> float:
    """Return the largest forward speed [m/s], up to a given one, that suits whole numbers of strides a tread.

    Parameters
    ----------
    terrain
        As believed.
    speed
        The given one [m/s].
    height
        Of the centre of mass above the ground [m].
    period
        Of the trot [s].

    Examples
    --------
    >>> from surefoot.mechanics.terrain import read_terrain
    >>> stairs = read_terrain("stairs:0.12,0.3", "terrain")
    >>> [round(speed_in_step(stairs, v, 0.3, 0.4), 3) for v in (0.15, 0.3, 0.4)]
    [0.125, 0.188, 0.4]
    """
    if speed <= 0.0 or not _high(terrain, height):
        return speed
    cycle, shortest = _cycles(terrain, speed, height, period)
    return speed * min(cycle / shortest, 1.0)


def _high(terrain: Terrain, height: float) -> bool:
    """Return whether a ground is stairs with steps high enough to matter."""
    return (
        STAIR_GAIT.used and terrain.steepness > 0.0 and terrain.highest_step >= GROUND_ESTIMATE.low * height
    )


def _cycles(terrain: Terrain, speed: float, height: float, period: float) -> tuple[float, float]:
    """Return the longest cycle that is not too long, and the shortest in which feet can be lifted [s]."""
    tread = terrain.highest_step / terrain.steepness
    strides = math.ceil(
        max(tread / (speed * STAIR_GAIT.longest_cycle * period), tread / (STAIR_GAIT.longest_stride * height))
        - 1e-9
    )
    least, grows = STAIR_GAIT.single if strides == 1 else STAIR_GAIT.several
    shortest = period * min(max(least + grows * terrain.highest_step / height, 1.0), STAIR_GAIT.longest_cycle)
    return tread / (speed * strides), shortest
