"""What rows of contacts are held against in one compiled pass, see `proof_of_rows`: columns, limits, laws."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.audit.slides import slide_rules

F, V, GAP, MU, TURN, CREEP = range(6)
"""Columns of a table of rows: where force and velocity begin (three each, contact axes), gap, friction, turn
of the pyramid (-1 for round cones), the creep of soft friction times its rate of braking."""
(WEIGHT, THRESHOLD, DEEP, APART, PULL, CONE, LEAST, SLIDE, CREEPS, DRIVES, LATE, BRAKES, RETURNS, SHARE,
 SPIKE, FALL, SINKS, LANDING, RECOIL, SLACK, SWINGS) = range(21)  # fmt: skip
"""Limits that the pass is given, see `limits_of`."""
MARGIN = 1.0 - 1e-9
"""Of a limit: sums in another order differ by less."""
PULLS, DEPTHS, CONES, GAPS, SLIDES, TOUCHES, THROWS = 1, 2, 4, 8, 16, 32, 64
"""Bits of laws."""
ALL_LAWS = 127
NAMES: dict[int, tuple[str, ...]] = {
    PULLS: ("pull",), DEPTHS: ("penetration",), CONES: ("friction",), GAPS: ("distance",),
    SLIDES: ("work", "dissipation"), TOUCHES: ("restitution",), THROWS: ("throw",),
}  # fmt: skip
"""The names of theirs."""


class RowLimits(NamedTuple):
    """What rows are held against.

    Attributes
    ----------
    numbers
        (21,) limits.
    how
        Window [rows], whether velocities are means, and whether rows are close enough to judge touches.
    slides
        Of `slide_rules`.
    """

    numbers: FloatArray
    how: tuple[int, bool, bool]
    slides: tuple[float, float, float]


def limits_of(
    limits: AuditLimits, weight: float, gravity: float, dt: float, means: bool,
    softness: tuple[float, float, float], recoil: float,
) -> RowLimits:  # fmt: skip
    """Return the limits of rows `dt` apart [s] of a robot of a weight [N] in a world of some softness.

    `gravity` is that of the world [m/s²].
    `softness` are sinking, creep and stopping as the log's facts declare them [m], [m/s], [m]; `recoil` is
    the fact of that name [1/s], infinite where nothing is known of it.
    """
    sinking, creep, stopping = softness
    laws, checks, rebound = limits.laws, limits.checks, limits.rebound
    deep, stops = max(laws.penetration, sinking), min(stopping, limits.softness.stopping)
    numbers = np.array(
        [
            weight, laws.loaded * weight, deep, deep, laws.pull * weight, laws.cone, laws.least_friction,
            laws.slide + stops, min(creep, limits.records.creep), checks.drive_share,
            checks.drive_share * (laws.slide + 2.0 * stops) * weight, checks.brake_share,
            rebound.way * weight, rebound.share, checks.spike * weight, gravity * dt**2, float(sinking > 0.0),
            limits.episodes.landing / (GRAVITY * dt), recoil, laws.sliding_speed + GRAVITY * dt,
            max(deep, laws.swing_depth * sinking),
        ]
    )  # fmt: skip
    window = max(1, round(checks.slide_window / dt))
    return RowLimits(numbers, (window, means, dt <= rebound.longest_row), slide_rules(laws))
