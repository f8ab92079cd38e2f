"""A trot in step with stairs: each stride takes a whole tread, or a whole part of one.

A foot that goes up by a step of 12 cm in the 0.18 s that a trot's swing takes needs more joint speed than a
motor has, and strides of another length than the tread put feet down on edges in turn. A cycle that lasts as
long as the body needs for a tread mends both: the swing has twice the time, and every foot finds its place on
every tread again. So long a time on two feet is too long for a trot: the diagonal's feet move an eighth of
the cycle apart, which leaves three feet down for a part of it.
"""

from __future__ import annotations

import math

from surefoot.control.gait import Gait
from surefoot.control.walking_body import VelocityCommand
from surefoot.terrain import Terrain

DUTY = 0.6
"""Share of the cycle that each foot carries."""
OFFSETS = (-0.0625, 0.4375, 0.5625, 0.0625)
"""When feet touch down, front to back and left before right: between a trot's and a walk's."""
LONGEST = 2.2
"""Longest cycle over the trot's own; slower bodies take more strides for a tread."""
SHORTEST = 1.2
"""Least that is worth it, likewise: a faster body keeps to the trot."""
LOW = 0.22
"""Steps lower than this share of the height of the centre of mass need nothing."""


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
    >>> from surefoot.terrain import read_terrain
    >>> stairs = read_terrain("stairs:0.12,0.3", "terrain")
    >>> round(stair_gait(stairs, VelocityCommand.constant(0.4), 0.3, 0.4, 4).period, 6)
    0.75
    """
    speed = float(abs(command.values[:, 0]).max(initial=0.0))
    if feet != 4 or terrain.highest_step < LOW * height or terrain.steepness <= 0.0 or speed == 0.0:
        return None
    tread = terrain.highest_step / terrain.steepness
    strides = max(math.ceil(tread / (speed * LONGEST * period) - 1e-9), 1)
    cycle = tread / (speed * strides)
    if cycle < SHORTEST * period:
        return None
    return Gait.from_phases("trot", cycle, DUTY, [share % 1.0 for share in OFFSETS])
