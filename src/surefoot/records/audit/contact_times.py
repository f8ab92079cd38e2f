"""When feet touched: touchdowns, lift-offs and strides from the feet's sensors.

A foot's reading in the air (its offset) and its usual peak set two thresholds; a phase shorter than the
debounce is none. A foot whose readings do not tell air from ground is refused, with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray, of_kind
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError, count_of, unknown_name
from surefoot.base.numerics.phases import debounced
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.motion import foot_forces
from surefoot.records.audit.run_limits import ContactTimeLimits
from surefoot.records.log import Log


@dataclass(frozen=True)
class FootTimes:
    """One foot's contacts.

    Attributes
    ----------
    name
        Of the foot.
    touchdowns, lift_offs
        (k,), (m,) instants at which the reading crossed the thresholds [s].
    strides
        (s, 2) begin and end of whole strides, touchdown to touchdown; without pauses [s].
    stride_period
        Median of the strides; NaN for none [s].
    duty_factor
        Share of the strides' time on the ground; NaN for none.
    offset, peak
        Reading in the air, and its usual peak.
    refused
        Why contacts are not known, empty if they are.
    """

    name: str
    touchdowns: FloatArray = field(default_factory=lambda: np.zeros(0))
    lift_offs: FloatArray = field(default_factory=lambda: np.zeros(0))
    strides: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    stride_period: float = np.nan
    duty_factor: float = np.nan
    offset: float = np.nan
    peak: float = np.nan
    refused: str = ""


@dataclass(frozen=True, repr=False)
class ContactTimes(Drawn):
    """The contacts of all feet.

    Attributes
    ----------
    channel
        What they were read from: ``foot_sensors`` or ``forces``.
    feet
        One for each foot.
    contacts
        (T, n) which feet touch; false for a refused foot.
    """

    channel: str
    feet: tuple[FootTimes, ...]
    contacts: BoolArray

    def __repr__(self) -> str:
        return f"ContactTimes({self.channel!r}, {len(self.feet)} feet, {len(self.contacts)} rows)"

    def __str__(self) -> str:
        told = [foot for foot in self.feet if not foot.refused]
        strides = [
            f"{foot.name} {foot.stride_period:.2f} s, {100.0 * foot.duty_factor:.0f} %"
            for foot in told if np.isfinite(foot.stride_period)
        ]  # fmt: skip
        some = "; strides and time on the ground: " + ", ".join(strides[:4]) if strides else ""
        more = f" and {len(strides) - 4} more" if len(strides) > 4 else ""
        downs = sum(len(foot.touchdowns) for foot in told)
        refused = f"; refused: {len(self.feet) - len(told)}" if len(told) < len(self.feet) else ""
        feet = count_of(len(self.feet), "foot").replace("foots", "feet")
        return f"{count_of(downs, 'touchdown')} of {feet}, from {self.channel}{some}{more}{refused}."

    def __getitem__(self, name: str) -> FootTimes:
        for foot in self.feet:
            if foot.name == name:
                return foot
        raise ProblemError(unknown_name("foot", name, [foot.name for foot in self.feet]))


def contact_times(log: Log, limits: AuditLimits = LIMITS) -> ContactTimes:
    """Return when the feet touched, from ``foot_sensors`` or else ``forces``.

    Parameters
    ----------
    log
        With either channel; the fact ``feet`` names them.
    limits
        With those of touchdowns and lift-offs.

    Raises
    ------
    ProblemError
        If the log has neither channel, fewer than two rows, or a time that does not grow.
    """
    of_kind("log", log, Log)
    time, channel, readings = _load_readings(log)
    names = [str(f) for f in log.facts.get("feet", ())] or [f"foot {k}" for k in range(readings.shape[1])]
    contacts = np.zeros(readings.shape, dtype=bool)
    feet = tuple(
        _foot(name, time, readings[:, k], contacts[:, k], limits.times) for k, name in enumerate(names)
    )
    return ContactTimes(channel, feet, contacts)


def _load_readings(log: Log) -> tuple[FloatArray, str, FloatArray]:
    """Return times [s], the channel's name and (T, n) readings."""
    time = np.asarray(log["time"], dtype=np.float64)
    if len(time) < 2 or not (np.diff(time) > 0.0).all():
        raise ProblemError("contact times need two rows or more, and a time that grows from row to row")
    if "foot_sensors" in log:
        return time, "foot_sensors", np.asarray(log["foot_sensors"], dtype=np.float64)
    if "forces" not in log:
        raise ProblemError(
            f"contact times need the channel foot_sensors or forces; it has: {', '.join(log.arrays)}"
        )
    return time, "forces", foot_forces(log)[..., 2]


def _foot(
    name: str, time: FloatArray, reading: FloatArray, touch: BoolArray, limits: ContactTimeLimits
) -> FootTimes:
    """Return one foot's contacts; `touch` (T,) is written."""
    if not np.isfinite(reading).all():
        return FootTimes(name, refused=f"{int((~np.isfinite(reading)).sum())} readings are not finite")
    offset, peak = _levels(reading, limits)
    refused = _refusal(reading, offset, peak, limits)
    if refused:
        return FootTimes(name, offset=offset, peak=peak, refused=refused)
    up, down = (offset + share * (peak - offset) for share in (limits.touchdown, limits.lift_off))
    touch[:] = debounced(time, _hysteresis(reading, up, down), limits.debounce)
    change = np.flatnonzero(np.diff(touch.astype(np.int8)))
    rising = change[touch[change + 1]]
    falling = change[~touch[change + 1]]
    touchdowns, lift_offs = _crossing(time, reading, rising, up), _crossing(time, reading, falling, down)
    strides = _strides(time, touchdowns, limits)
    period = np.diff(strides, axis=1)
    duty = np.nan
    if len(strides):
        on = sum(_overlap(touchdowns, lift_offs, begin, end) for begin, end in strides)
        duty = float(on / period.sum())
    middle = float(np.median(period)) if len(strides) else np.nan
    return FootTimes(name, touchdowns, lift_offs, strides, middle, duty, offset, peak)


def _levels(reading: FloatArray, limits: ContactTimeLimits) -> tuple[float, float]:
    """Return a foot's offset, the middle of its lowest readings, and its usual peak."""
    low, peak = np.percentile(reading, [5.0, 95.0])
    near = reading[reading <= low + limits.flat * (peak - low)]
    return float(np.median(near)), float(peak)


def _refusal(reading: FloatArray, offset: float, peak: float, limits: ContactTimeLimits) -> str:
    """Return why readings do not tell air from ground, empty if they do."""
    size = peak - offset
    steps = np.abs(np.diff(reading))
    noise = 1.4826 * float(np.median(steps)) / np.sqrt(2.0)
    if size <= 0.0:
        return f"the reading is {offset:g} almost always"
    if size < limits.noise_ratio * noise:
        return f"its peak of {size:.3g} is less than {limits.noise_ratio:g} times its noise of {noise:.3g}"
    share = float((np.abs(reading - offset) <= limits.flat * size).mean())
    if share < limits.flat_share:
        return f"it has no level of its own in the air: {100 * share:.0f} % of the rows are near {offset:.3g}"
    return ""


def _hysteresis(reading: FloatArray, up: float, down: float) -> BoolArray:
    """Return whether the last threshold that was crossed is the upper one: (T,)."""
    mark = np.where(reading > up, 1, np.where(reading < down, 0, -1))
    mark[0] = mark[0] if mark[0] >= 0 else 0
    known = np.maximum.accumulate(np.where(mark >= 0, np.arange(len(mark)), 0))
    return np.asarray(mark[known] == 1)


def _crossing(time: FloatArray, reading: FloatArray, before: IntArray, level: float) -> FloatArray:
    """Return when the reading crossed a level between rows `before` and the next ones [s]."""
    a, b = reading[before], reading[before + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(a == b, 0.5, (level - a) / (b - a))
    return np.asarray(time[before] + np.clip(share, 0.0, 1.0) * (time[before + 1] - time[before]))


def _strides(time: FloatArray, touchdowns: FloatArray, limits: ContactTimeLimits) -> FloatArray:
    """Return (s, 2) strides without pauses and without holes in the time."""
    if len(touchdowns) < 2:
        return np.zeros((0, 2))
    strides = np.column_stack([touchdowns[:-1], touchdowns[1:]])
    period = np.diff(strides, axis=1)[:, 0]
    steps = np.diff(time)
    holes = time[:-1][steps > max(limits.debounce, limits.hole * float(np.median(steps)))]
    whole = np.searchsorted(holes, strides[:, 0]) == np.searchsorted(holes, strides[:, 1])
    return np.asarray(strides[whole & (period <= limits.longest * np.median(period))])


def _overlap(touchdowns: FloatArray, lift_offs: FloatArray, begin: float, end: float) -> float:
    """Return how long a foot touched within a stride that begins with a touchdown [s]."""
    inside = lift_offs[(lift_offs > begin) & (lift_offs <= end)]
    starts = touchdowns[(touchdowns >= begin) & (touchdowns < end)]
    return float(sum(off - on for on, off in zip(starts, inside, strict=False)))
