"""The laws of contact as numbers, from measured forces, gaps and velocities alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.audit.slides import WORST, slide_on, start_slides
from surefoot.errors import ProblemError
from surefoot.log import Log
from surefoot.spatial import GRAVITY

PENETRATION_LIMIT = 1e-3
"""Deepest penetration that still counts as touching, and widest gap across which a force may act [m]."""
SLIDE_LIMIT = 1e-3
"""Longest way of a contact without friction that still counts as sticking [m]."""
SWING_DEPTH = 1.6
"""A contact on a body that tumbles sinks deeper than on its own, by less than this factor (1.5 was seen)."""
HARD_TOUCHDOWN = 0.7
"""Speed into the ground from which a landing sets a soft contact swinging [m/s]: a fall from 25 mm."""
PULL_LIMIT = 1e-3
"""Largest pull that counts as rounding, as a share of m g."""
CONE_LIMIT = 1.0 + 1e-3
"""Highest use of the friction cone that counts as inside."""
LOADED_SHARE = 1e-3
"""A contact counts as loaded above this share of m g; below it the use of its cone is noise."""
LEAST_FRICTION = 1e-4
"""Friction below this counts as this much: simulators know no exact zero."""
SLIDING_SPEED = 1e-2
"""Speed from which a contact counts as sliding at an instant [m/s]."""
SOFTEST = {
    "sinking": (0.05, "m"), "creep": (0.1, "m/s"), "stopping": (0.1, "m"), "settling": (0.1, "s"),
}  # fmt: skip
"""A world that declares more than this may hide anything: nothing is lawful there."""
_MEASURED = ("forces", "gaps", "velocities", "friction")
LAWS = ("unilateral", "Coulomb", "dissipation")
"""The names of the three laws."""


@dataclass(frozen=True)
class Laws:
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
        over the friction, see `surefoot.audit.slides`; NaN when the time between the measurements was not
        given.
    judged
        Which of `LAWS` were judged: none for a motion without contacts, two without a time step.
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
    judged: tuple[str, ...] = LAWS[:2]
    not_finite: tuple[str, ...] = ()
    sinking: float = 0.0
    stopping: float = 0.0

    def broken(self, weight: float) -> list[str]:
        """Return one line per broken law, for a robot of the given weight m g [N].

        What is not finite is broken. Empty means that no law in `judged` was.
        """
        weight = _weight(weight)
        out = list(self.not_finite)
        depth, way = max(PENETRATION_LIMIT, self.sinking), SLIDE_LIMIT + self.stopping
        if self.penetration_max > depth:
            out.append(f"penetration of {1e3 * self.penetration_max:.2f} mm (limit {1e3 * depth:.3g})")
        if self.unilateral_min < -PULL_LIMIT * weight:
            out.append(f"a pull of {-self.unilateral_min:.3g} N")
        if self.cone_use_max > CONE_LIMIT:
            out.append(f"{self.cone_use_max:.3f} times the friction that the cone allows")
        if self.separation_max > depth:
            out.append(f"a force {1e3 * self.separation_max:.2f} mm off the ground (limit {1e3 * depth:.3g})")
        if "dissipation" in self.judged and self.free_slide_max > way:
            out.append(
                f"a slide of {1e3 * self.free_slide_max:.2f} mm without friction (limit {1e3 * way:.3g})"
            )
        return out


def contact_use(forces: ArrayLike, mu: ArrayLike, threshold: float) -> FloatArray:
    """Return ||f_t|| / (mu f_n) of (T, p, 3) forces: (T, p).

    A normal force below `threshold` [N] counts as that much: a contact with hardly any is allowed the noise
    of its friction, and no more. `mu` is a number, (T,) or (T, p), taken as `LEAST_FRICTION` at least. NaN
    where a force is.
    """
    f = _motion("forces", forces, 3)
    friction = _friction(mu, f.shape[:2])
    least = max(real_number("threshold", threshold), np.finfo(np.float64).tiny)
    limit = np.maximum(friction, LEAST_FRICTION) * np.maximum(f[..., 2], least)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.asarray(np.hypot(f[..., 0], f[..., 1]) / limit)


def check_laws(
    forces: ArrayLike,
    gaps: ArrayLike,
    velocities: ArrayLike,
    mu: ArrayLike,
    weight: float,
    dt: ArrayLike | None = None,
) -> Laws:
    """Return the laws as numbers for a motion.

    Parameters
    ----------
    forces
        (T, p, 3) measured contact forces on the robot, contact frames [N].
    gaps
        (T, p) distances to the ground [m].
    velocities
        (T, p, 3) velocities of the feet's material at the contacts [m/s].
    mu
        Friction of the ground: a number, (T,) or (T, p), >= 0.
    weight
        m g of the robot [N]; says what is small.
    dt
        Time from each measurement to the next: a number or (T,), > 0 [s]. Without it the third law, that of
        maximum dissipation, is not judged.

    Raises
    ------
    ProblemError
        For shapes that do not fit, negative friction, a weight or step that is not positive. Measurements
        that are not finite are broken laws and no error, see `Laws.broken`.
    """
    check = _Check(_weight(weight), dt is not None)
    check.add(forces, gaps, velocities, mu, dt)
    return check.laws()


def log_laws(log: Log) -> Laws:
    """Return the laws as numbers for a log, in bounded memory: those of `check_laws` for all of it.

    Needs the channels forces, gaps, contact_velocities and mu, and the facts mass and dt.

    Raises
    ------
    ProblemError
        If the log lacks one of them, or they do not fit.
    """
    dt = log.fact("dt")
    check = _Check(log.fact("mass") * GRAVITY, True)
    sinking, stopping, settling = (
        min(stated(log, name), SOFTEST[name][0]) for name in ("sinking", "stopping", "settling")
    )
    depth, landed = 0.0, -math.inf
    for piece in log.chunks():
        gaps, velocities = piece["gaps"], piece["contact_velocities"]
        check.add(piece["forces"], gaps, velocities, friction_of(piece), dt)
        deep, landed = swinging(np.asarray(piece["time"]), gaps, velocities, settling, landed)
        depth = max(
            depth, float((-gaps.min(axis=1, initial=0.0) / np.where(deep, SWING_DEPTH, 1.0)).max(initial=0.0))
        )
    laws = check.laws()
    if depth <= sinking:
        sinking = max(sinking, laws.penetration_max)
    return replace(laws, sinking=sinking, stopping=stopping)


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
    time: FloatArray, gaps: FloatArray, velocities: FloatArray, settling: float, before: float = -math.inf
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
    """
    landed = ((gaps <= 0.0) & (velocities[..., 2] < -HARD_TOUCHDOWN)).any(axis=1)
    last = np.maximum.accumulate(np.append(before, np.where(landed, time, -math.inf)))
    return np.asarray((time - last[1:] <= settling) & (settling > 0.0)), float(last[-1])


class _Check:
    """The laws of a motion that comes piece by piece; a figure does not depend on where it is cut."""

    def __init__(self, weight: float, dissipation: bool) -> None:
        self.weight, self.threshold = weight, LOADED_SHARE * weight
        self.judged = LAWS if dissipation else LAWS[:2]
        self._rows, self._worst = 0, np.full(6, -np.inf)
        self._slides: FloatArray | None = None
        self._lost: dict[str, tuple[int, tuple[int, int]]] = {}
        self._slides_lost = False

    def add(
        self, forces: ArrayLike, gaps: ArrayLike, velocities: ArrayLike, mu: ArrayLike, dt: ArrayLike | None
    ) -> None:
        """Judge the next rows; see `check_laws`."""
        f = _motion("forces", forces, 3)
        shape, threshold = f.shape[:2], self.threshold
        gap, v = _numbers("gaps", gaps, shape), _numbers("velocities", velocities, f.shape)
        friction = _friction(mu, shape)
        step = None if dt is None else _steps(dt, shape[0])
        if f.size == 0:
            return
        given = {"forces": f, "gaps": gap, "velocities": v, "friction": friction}
        finite = {name: self._finite(name, array) for name, array in given.items()}
        with np.errstate(invalid="ignore", over="ignore"):
            figures = (
                max(0.0, -float(gap.min())) if finite["gaps"] else math.nan,
                -float(f[..., 2].min()),
                float(contact_use(f, friction, threshold).max()),
                float(np.abs(f[..., 2] * gap).max()),
                _apart(f, gap, threshold),
                _power_missing(f, v, friction, threshold) / self.weight,
            )
        self._worst = np.maximum(self._worst, figures)  # NaN stays
        self._rows += len(f)
        self._slides_lost |= not (finite["forces"] and finite["velocities"] and finite["friction"])
        if step is not None and not self._slides_lost:
            self._slides = start_slides(shape[1]) if self._slides is None else self._slides
            slide_on(self._slides, f, v, friction, step, threshold, self.weight)

    def _finite(self, name: str, values: FloatArray) -> bool:
        """Tell whether a measurement is finite, and remember where it is not."""
        bad = ~np.isfinite(values)
        if not bad.any():
            return True
        row, contact = (int(k) for k in np.argwhere(bad)[0][:2])
        count, first = self._lost.get(name, (0, (self._rows + row, contact)))
        self._lost[name] = count + int(bad.sum()), first
        return False

    def laws(self) -> Laws:
        """Return the laws of the rows so far."""
        if self._rows == 0:
            return Laws(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, judged=())
        slide = math.nan
        if self._slides is not None and not self._slides_lost:
            slide = float(self._slides[:, WORST].max())
        lost = tuple(
            f"{name} not finite in {count} places, first in row {row} at contact {contact}"
            for name, (count, (row, contact)) in ((n, self._lost[n]) for n in _MEASURED if n in self._lost)
        )
        worst = [-x if k == 1 else x for k, x in enumerate(self._worst.tolist())]  # the least normal force
        figures = worst if self.judged is not LAWS else [*worst, slide]
        if not lost and not all(map(math.isfinite, figures)):
            lost = ("forces, gaps or velocities too large to multiply",)
        depth, least, use, across, apart, power = worst
        return Laws(depth, least, use, across, apart, power, slide, self.judged, lost)


def _apart(f: FloatArray, gap: FloatArray, threshold: float) -> float:
    """Return the widest gap across which a force acts, NaN where that is unknown [m]."""
    pushed = np.maximum(np.abs(f[..., 2]), np.hypot(f[..., 0], f[..., 1]))
    unknown = ~(np.isfinite(pushed) & np.isfinite(gap))
    return float(np.where(unknown, np.nan, np.where(pushed > threshold, np.maximum(gap, 0.0), 0.0)).max())


def _power_missing(f: FloatArray, v: FloatArray, mu: FloatArray, threshold: float) -> float:
    """Return the most friction missing against the slip of a loaded contact at an instant [N]."""
    speed = np.hypot(v[..., 0], v[..., 1])
    along = (f[..., 0] * v[..., 0] + f[..., 1] * v[..., 1]) / np.maximum(speed, 1e-12)
    missing = mu * f[..., 2] + along
    unknown = ~np.isfinite(missing)
    sliding = (speed > SLIDING_SPEED) & (f[..., 2] > threshold)
    return float(np.where(unknown, np.nan, np.where(sliding, missing, 0.0)).max())


def _weight(weight: float) -> float:
    """Return a robot's weight, checked."""
    number = real_number("weight", weight, low=0.0, high=1e300)
    if number == 0.0:
        raise ProblemError("weight must be positive, got 0")
    return number


def _numbers(name: str, value: ArrayLike, shape: tuple[int, ...] | None = None) -> FloatArray:
    """Return a measurement as an array, NaN and infinity allowed, the shape checked."""
    try:
        if np.iscomplexobj(value):
            raise TypeError
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ProblemError(f"{name} must be numeric, got {value!r:.80}") from error
    if shape is not None and array.shape != shape:
        raise ProblemError(f"{name} must have shape {shape} to fit the forces, got {array.shape}")
    return array


def _motion(name: str, value: ArrayLike, width: int) -> FloatArray:
    """Return a measurement of shape (T, p, width)."""
    array = _numbers(name, value)
    if array.ndim != 3 or array.shape[2] != width:
        raise ProblemError(f"{name} must have shape (T, p, {width}), got {array.shape}")
    return array


def _friction(mu: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return friction for every contact at every time: (T, p)."""
    array = _numbers("mu", mu)
    steps, contacts = shape
    if array.shape not in ((), (steps,), (steps, contacts)):
        raise ProblemError(
            f"mu must be a number or have shape ({steps},) or ({steps}, {contacts}), got {array.shape}"
        )
    if (array < 0.0).any():
        raise ProblemError(f"mu must be >= 0, got {array.min():g}")
    column = array[:, None] if array.ndim == 1 else array
    return np.ascontiguousarray(np.broadcast_to(column, shape))


def _steps(dt: ArrayLike, count: int) -> FloatArray:
    """Return the time of every step: (T,) [s]."""
    array = _numbers("dt", dt)
    if array.shape not in ((), (count,)):
        raise ProblemError(f"dt must be a number or have shape ({count},), got {array.shape}")
    if not ((array > 0.0) & np.isfinite(array)).all():
        raise ProblemError("dt must be positive and finite")
    return np.ascontiguousarray(np.broadcast_to(array, (count,)))
