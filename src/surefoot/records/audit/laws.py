"""The laws of contact as numbers, from measured forces, gaps and velocities alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.limits import LIMITS, AuditLimits, LawLimits
from surefoot.records.audit.slides import WORST, slide_on, slide_rules, start_slides
from surefoot.records.log import Log

LAWS = ("unilateral", "Coulomb", "dissipation")
"""The names of the three laws."""
_OF_SLIDES = {"forces", "velocities", "friction"}
"""Measurements without which no slide can be judged."""


@dataclass(frozen=True)
class LawFigures:
    """How far a motion went from the three laws; a number is NaN where its measurements are not finite.

    Attributes
    ----------
    penetration_max
        Deepest penetration [m].
    unilateral_min
        Least normal force; negative means that the ground pulled [N].
    cone_use_max
        Highest ||f_t|| / (mu f_n); one is the cone's surface. See `contact_use`.
    complementarity_max
        Largest f_n |gap| [N m]. Not judged: it grows with how hard a foot lands, where depth and gap do not.
    separation_max
        Widest gap across which a force acts, along the normal or across it [m].
    dissipation_max
        Largest friction power missing at an instant of a sliding contact,
        (mu f_n ||v_t|| + f_t . v_t) / (m g ||v_t||); zero when friction opposes the slip in full. Not judged:
        a foot that touches down is stopped with less than all its friction.
    free_slide_max
        Longest way that a contact slid in one stance as if without friction [m]: the friction's missing work
        over the friction, see `surefoot.records.audit.slides`.
    judged
        Which of `LAWS` were judged: none for a motion without contacts.
    not_finite
        What was not finite, one line for each measurement.
    sinking, stopping
        What the log's world declares of its softness [m]: how deep its contacts give way, and the way on
        which they hold a sliding foot. They count as lawful, here as in an audit.
    """

    penetration_max: float
    unilateral_min: float
    cone_use_max: float
    complementarity_max: float
    separation_max: float
    dissipation_max: float
    free_slide_max: float = math.nan
    judged: tuple[str, ...] = LAWS
    not_finite: tuple[str, ...] = ()
    sinking: float = 0.0
    stopping: float = 0.0

    def add_softness(self, limits: AuditLimits = LIMITS) -> tuple[float, float]:
        """Return the lawful depth and way without friction, with what the world declares of both [m]."""
        return max(limits.laws.penetration, self.sinking), limits.laws.slide + self.stopping

    def broken(self, weight: float, limits: AuditLimits = LIMITS) -> list[str]:
        """Return one line per broken law, for a robot of the given weight m g [N], judged by limits.

        What is not finite is broken. Empty means that no law in `judged` was.
        """
        weight = real_number("weight", weight, low=0.0, high=1e300)
        if weight == 0.0:
            raise ProblemError("weight must be positive, got 0")
        out = list(self.not_finite)
        laws, (depth, way) = limits.laws, self.add_softness(limits)
        if self.penetration_max > depth:
            out.append(f"penetration of {1e3 * self.penetration_max:.2f} mm (limit {1e3 * depth:.3g})")
        if self.unilateral_min < -laws.pull * weight:
            out.append(f"a pull of {-self.unilateral_min:.3g} N")
        if self.cone_use_max > laws.cone:
            out.append(f"{self.cone_use_max:.3f} times the friction that the cone allows")
        if self.separation_max > depth:
            out.append(f"a force {1e3 * self.separation_max:.2f} mm off the ground (limit {1e3 * depth:.3g})")
        if self.free_slide_max > way:
            out.append(
                f"a slide of {1e3 * self.free_slide_max:.2f} mm without friction (limit {1e3 * way:.3g})"
            )
        return out


def contact_use(
    forces: FloatArray, mu: FloatArray, threshold: float, least: float = LIMITS.laws.least_friction
) -> FloatArray:
    """Return ||f_t|| / (mu f_n) of (T, p, 3) forces: (T, p).

    A normal force below `threshold` [N] counts as that much: a contact with hardly any is allowed the noise
    of its friction, and no more. `mu` is (T,) or (T, p), taken as `least` at least. NaN where a force is.
    """
    normal = np.maximum(forces[..., 2], max(threshold, np.finfo(np.float64).tiny))
    limit = np.maximum(_of_each(mu, normal.shape), least) * normal
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(np.hypot(forces[..., 0], forces[..., 1]) / limit)


def log_laws(log: Log, judged: AuditLimits = LIMITS) -> LawFigures:
    """Return the laws as numbers for a log, in bounded memory; limits say what is loaded, slides, or swings.

    Needs the channels forces, gaps, contact_velocities and mu, and the facts mass and dt. Measurements that
    are not finite are broken laws and no error, see `LawFigures.broken`.

    Raises
    ------
    ProblemError
        If the log lacks one of them, or has negative friction.
    """
    weight, dt = float(log.fact("mass")) * GRAVITY, log.fact("dt")
    limits, softest = judged.laws, judged.softness
    sinking, stopping, settling = (
        min(stated(log, name), getattr(softest, name)) for name in ("sinking", "stopping", "settling")
    )
    sinking = max(sinking, min(stated(log, "step_depth"), softest.sinking))
    worst, slides = np.full(6, -np.inf), start_slides(log["forces"].shape[1], limits)
    lost: dict[str, tuple[int, int, int]] = {}
    rows, depth, landed = 0, 0.0, -math.inf
    for piece in log.chunks():
        motion = _motion(piece)
        f, gap, v, mu = motion.values()
        for name, values in motion.items():
            _lose(lost, name, values, rows)
        if f.size:
            with np.errstate(invalid="ignore", over="ignore"):
                worst = np.maximum(worst, _figures(f, gap, v, mu, weight, limits))  # NaN stays
            rows += len(f)
        if not lost.keys() & _OF_SLIDES:
            slide_on(
                slides, f, v, mu, np.full(len(f), dt), limits.loaded * weight, weight, *slide_rules(limits)
            )
        deep, landed = swinging(np.asarray(piece["time"]), gap, v, settling, landed, limits=limits)
        over = -gap.min(axis=1, initial=0.0) / np.where(deep, limits.swing_depth, 1.0)
        depth = max(depth, float(over.max(initial=0.0)))
    if not rows:
        return LawFigures(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, judged=())
    deepest, pull, use, across, apart, power = worst.tolist()
    slide = math.nan if lost.keys() & _OF_SLIDES else float(slides[:, WORST].max())
    said = tuple(
        "{} not finite in {} places, first in row {} at contact {}".format(name, *lost[name])
        for name in motion
        if name in lost
    )
    if not said and not np.isfinite([*worst, slide]).all():
        said = ("forces, gaps or velocities too large to multiply",)
    soft = max(sinking, deepest) if depth <= sinking else sinking
    return LawFigures(deepest, -pull, use, across, apart, power, slide, LAWS, said, soft, stopping)


def stated(log: Log, name: str) -> float:
    """Return a fact of a log that is a number >= 0 and finite, in the fact's unit; 0 where the log has none.

    Raises
    ------
    ProblemError
        For a fact that is no such number.
    """
    value = float(log.fact(name)) if name in log.facts else 0.0
    if not (math.isfinite(value) and value >= 0.0):
        raise ProblemError(f"the fact {name} must be >= 0 and finite, got {value}")
    return value


def friction_of(rows: Any) -> FloatArray:
    """Return the friction in rows of a log [-]: of each contact (T, p) where they differ, else (T,)."""
    return np.asarray(rows["contact_friction"] if "contact_friction" in rows else rows["mu"])


def swinging(
    time: FloatArray,
    gaps: FloatArray,
    velocities: FloatArray,
    settling: float,
    before: float = -math.inf,
    limits: LawLimits = LIMITS.laws,
) -> tuple[BoolArray, float]:
    """Return in which rows soft contacts may swing, (T,), and when one of them last landed hard [s].

    On a body that lands corner after corner each landing drives the others in, and slides them on.

    Parameters
    ----------
    time, gaps, velocities
        (T,) [s], (T, p) [m] and (T, p, 3) contact frames [m/s].
    settling
        How long they may from a hard touchdown on [s].
    before
        When the last one was before these rows [s].
    limits
        With the speed of a hard touchdown.
    """
    landed = ((gaps <= 0.0) & (velocities[..., 2] < -limits.hard_touchdown)).any(axis=1)
    last = np.maximum.accumulate(np.append(before, np.where(landed, time, -math.inf)))
    return np.asarray((time - last[1:] <= settling) & (settling > 0.0)), float(last[-1])


def _of_each(mu: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return friction (T,) or (T, p) for every contact at every time: (T, p)."""
    return np.broadcast_to(mu[:, None] if np.ndim(mu) == 1 else mu, shape)


def _motion(rows: Log) -> dict[str, FloatArray]:
    """Return forces (T, p, 3), gaps (T, p), velocities (T, p, 3) and friction (T, p) in rows of a log."""
    mu = friction_of(rows)
    if (mu < 0.0).any():
        raise ProblemError(f"mu must be >= 0, got {mu.min():g}")
    friction = _of_each(mu, rows["forces"].shape[:2])
    given = {"forces": rows["forces"], "gaps": rows["gaps"], "velocities": rows["contact_velocities"]}
    whole = {**given, "friction": friction}
    return {name: np.ascontiguousarray(array, dtype=np.float64) for name, array in whole.items()}


def _lose(lost: dict[str, tuple[int, int, int]], name: str, values: FloatArray, first: int) -> None:
    """Count what is not finite in rows from `first` on, and remember the first row and contact of it."""
    bad = ~np.isfinite(values)
    if bad.any():
        row, contact = (int(k) for k in np.argwhere(bad)[0][:2])
        count, row, contact = lost.get(name, (0, first + row, contact))
        lost[name] = count + int(bad.sum()), row, contact


def _figures(
    f: FloatArray, gap: FloatArray, v: FloatArray, mu: FloatArray, weight: float, limits: LawLimits
) -> tuple[float, ...]:
    """Return the first six of `LawFigures` for some rows, the least normal force with its sign turned."""
    threshold = limits.loaded * weight
    return (
        max(0.0, -float(gap.min())) if np.isfinite(gap).all() else math.nan,
        -float(f[..., 2].min()),
        float(contact_use(f, mu, threshold, limits.least_friction).max()),
        float(np.abs(f[..., 2] * gap).max()),
        _apart(f, gap, threshold),
        _power_missing(f, v, mu, threshold, limits.sliding_speed) / weight,
    )


def _apart(f: FloatArray, gap: FloatArray, threshold: float) -> float:
    """Return the widest gap across which a force acts, NaN where that is unknown [m]."""
    pushed = np.maximum(np.abs(f[..., 2]), np.hypot(f[..., 0], f[..., 1]))
    unknown = ~(np.isfinite(pushed) & np.isfinite(gap))
    return float(np.where(unknown, np.nan, np.where(pushed > threshold, np.maximum(gap, 0.0), 0.0)).max())


def _power_missing(
    f: FloatArray, v: FloatArray, mu: FloatArray, threshold: float, sliding_speed: float
) -> float:
    """Return the most friction missing against the slip of a loaded contact at an instant [N]."""
    speed = np.hypot(v[..., 0], v[..., 1])
    # Maximum dissipation: along the slip the force is -mu f_n.
    along = (f[..., 0] * v[..., 0] + f[..., 1] * v[..., 1]) / np.maximum(speed, 1e-12)
    missing = mu * f[..., 2] + along
    unknown = ~np.isfinite(missing)
    sliding = (speed > sliding_speed) & (f[..., 2] > threshold)
    return float(np.where(unknown, np.nan, np.where(sliding, missing, 0.0)).max())
