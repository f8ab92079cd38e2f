"""Causes that lie in motors and control: weak or saturated actuators, delay, chatter, out of reach."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.windows import sliding_mean
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.story.failure import fall
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.world_causes import model_changes, push

FAINT = 1e-3
"""Share of a joint's largest torque below which the digits of a log say nothing."""
COARSE = 0.004
"""In which steps delays are tried at first [s]."""
ENOUGH = 1000
"""Rows from which a delay is told; of a longer log every so many."""


def weak(s: Signals) -> Iterator[Sign]:
    """Yield actuators whose gain is cut, that give less than is asked for, or nothing from some time on."""
    cuts = [one for one in model_changes(s, "gain") if one[2] < s.limits.weaker]
    for time, name, factor in cuts:
        yield Sign(time, name, f"the gain of {name} falls to {factor:.0%}", 1.0 - factor)
    largest = largest_torques(s)
    if not len(largest):
        return
    for k, name in enumerate(s.joints):
        sign = _shortfall(s, k, name) or _torque_loss(s, k, name, float(largest[k]))
        if sign is not None and all(abs(sign.time - time) > s.limits.brief for time, _, _ in cuts):
            yield sign  # else it is told by its motor's name


def largest_torques(s: Signals) -> FloatArray:
    """Return what torques are measured by: (joints,) their limits, else the largest of all."""
    most = np.abs(s.torques).max(axis=0, initial=0.0)
    return np.where(np.isfinite(s.torque_limits), s.torque_limits, np.full(len(most), most.max(initial=0.0)))


def _shortfall(s: Signals, k: int, name: str) -> Sign | None:
    """Return where a joint gets less torque than is asked for though no limit of its own is met."""
    asked, given, limit = s.asked[:, k], s.torques[:, k], float(s.torque_limits[k])
    within = np.clip(asked, -limit, limit)
    size = np.abs(within)
    floor = FAINT * max(float(size.max(initial=0.0)), 1e-9)
    less = (size > floor) & (given * np.sign(within) < s.limits.weaker * size)
    row = s.first(less, s.rows(s.limits.brief))
    cut = min((time for time, _, _ in model_changes(s, "torque limit")), default=np.inf)
    if row is None or s.time[row] >= cut or less[row:].mean() < 0.5 * (size[row:] > floor).mean():
        return None
    share = float(np.sum(given[row:] * within[row:]) / max(float(np.sum(within[row:] ** 2)), 1e-12))
    return Sign(float(s.time[row]), name, f"{name} gives {share:.0%} of the torque that is asked for", 1.0)


def _torque_loss(s: Signals, k: int, name: str, largest: float) -> Sign | None:
    """Return where a joint that had a torque has none any more, to the last digit, until the end."""
    torque = s.torques[:, k]
    zero = np.abs(torque) <= 1e-9 * max(largest, 1e-9)
    if not zero[-1] or zero.all():
        return None
    row = int(len(zero) - np.argmin(zero[::-1]))
    # who gives nothing now and then may do so on purpose
    begun = int(s.loaded.any(axis=1).argmax())
    idle = float(zero[begun:row].mean()) if row > begun else 1.0
    if (len(zero) - row) * s.dt < 2.0 * s.limits.brief or idle > 1.0 - s.limits.weaker:
        return None
    carried = float(np.sqrt(np.mean(torque[:row] ** 2)))
    just_before = torque[max(row - s.rows(s.limits.brief), 0) : row]
    if np.abs(just_before).max() < FAINT * carried:
        return None  # it came to rest
    words = f"{name} carried {carried:.3g} N m and gives nothing any more"
    return Sign(float(s.time[row]), name, words, carried / max(largest, 1e-9))


def saturation(s: Signals) -> Iterator[Sign]:
    """Yield torques that stay at their limits for most of a time while more is asked for."""
    for time, name, factor in model_changes(s, "torque limit"):
        if factor < s.limits.weaker:
            words = f"the torque limit of {name} falls to {factor:.0%}"
            yield Sign(_first_short(s, time), name, words, 1.0)
    at = at_limit(s)
    for k, name in enumerate(s.joints):
        # what turns from limit to limit is chatter's
        held = (at[:, k] & (s.torques[:, k] > 0.0), at[:, k] & (s.torques[:, k] < 0.0))
        share = np.maximum(*(sliding_mean(x.astype(np.float64), s.rows(s.limits.window)) for x in held))
        row = s.first(share > s.limits.saturated)
        if row is not None:
            begun = row + int(at[row:, k].argmax())
            words = f"{name} stays at its limit of {np.abs(s.torques[:, k]).max():.3g} N m"
            yield Sign(float(s.time[begun]), name, words, float(at[:, k].mean()))


def _first_short(s: Signals, time: float) -> float:
    """Return when from a time on more is asked for than is given [s]; that time where it never is."""
    short = np.abs(s.asked - s.torques) > 0.02 * np.maximum(np.abs(s.asked), 1e-9)
    later = short.any(axis=1) & (s.time >= time)
    return float(s.time[int(later.argmax())]) if later.any() else time


def at_limit(s: Signals) -> BoolArray:
    """Return (T, joints) where torques are at their limits: those told, else a value never exceeded."""
    size = np.abs(s.torques)
    known = np.isfinite(s.torque_limits)
    most = size.max(axis=0, initial=0.0)
    flat = (size >= (1.0 - 1e-9) * np.maximum(most, 1e-12)) & (most > 0.0)
    # a limit that nobody told is a value met to the last digit again and again
    flat &= flat.mean(axis=0) > 0.01
    limit = np.where(known, s.torque_limits, np.inf)
    asked = np.abs(s.asked) > 1.02 * limit if "torques_commanded" in s else size >= 0.995 * limit
    return np.asarray(np.where(known, asked & (size >= 0.98 * limit), flat))


def delay(s: Signals) -> Iterator[Sign]:
    """Yield that torques answer the state of some time ago: explained far better with a lag than without."""
    q, v = s.joint_state
    longest = s.rows(s.limits.longest_lag)
    if not q.shape[1] or q.shape != s.torques.shape:
        return
    # what is asked for answers the state also while the motor is at its limit
    free = np.ones(q.shape, dtype=bool) if "torques_commanded" in s else ~at_limit(s)
    stands = np.asarray((s.loaded & s.ground_feet).any(axis=1))
    fell = fall(s)
    last = (
        np.inf if fell is None else fell.time + s.limits.still_led
    )  # what lies on the ground is driven into its stops
    if len(q) < 4 * longest:
        return
    ticks = s.ticks[(s.ticks >= longest) & (s.time[s.ticks] < last)]
    # what a robot does that is thrown by a push tells little of how it is controlled
    thrown = min((sign.time for sign in push(s)), default=np.inf)
    calm = ticks[s.time[ticks] < thrown]
    ticks = calm if len(calm) >= 4 * longest else ticks
    stride = max(1, (len(ticks) - 1) // ENOUGH)
    pairs = ticks[:-1][::stride], ticks[1:][::stride]

    def left(lag: int) -> float:
        return _open_share(s.asked, (q, v), s.base_state, stands, free, lag, pairs)

    without = left(0)
    if without < s.limits.lag_better:
        return
    step = max(1, s.rows(COARSE))
    # below a step every lag is tried: torques may turn from row to row
    near = min(sorted({*range(step), *range(0, longest + 1, step)}), key=left)
    best = min(range(max(near - step + 1, 0), min(near + step, longest + 1)), key=left)
    if not 2 * step <= best <= longest - 2 * step:
        return
    # a delay is one time: a little before and after it less is explained
    beside = min(left(best - 2 * step), left(best + 2 * step))
    gain = without - left(best)
    sharp = left(best) < beside - 0.5 * s.limits.lag_better
    told = left(best) < s.limits.left_open or gain > s.limits.far_better * s.limits.lag_better
    if sharp and told and best * s.dt >= s.limits.lag and gain > s.limits.lag_better:
        words = f"torques answer the state of {1e3 * best * s.dt:.0f} ms ago"
        yield Sign(float(s.time[0]), "body", words, 1.0 - left(best) / without)


def _open_share(
    torque: FloatArray,
    joints: tuple[FloatArray, FloatArray],
    base: FloatArray,
    stands: BoolArray,
    free: BoolArray,
    lag: int,
    pairs: tuple[IntArray, IntArray],
) -> float:
    """Return the share of torques' changes (T, joints) that those of the state of then leave open.

    Changes are those between pairs of rows, then is `lag` rows before. Each joint answers its own position
    and velocity and the state (T, n) of the base, by gains that are fitted over the rows that are `free`
    (T, joints): those of a robot that stands, and those of one in the air, between which controllers switch.
    """
    one, two = pairs
    total = explained = 0.0
    for mode in (False, True):
        alike = (stands[one - lag] == mode) & (stands[two - lag] == mode)
        a, b = one[alike], two[alike]
        own = np.stack([x[b - lag] - x[a - lag] for x in joints], axis=-1)
        common = np.broadcast_to((base[b - lag] - base[a - lag])[:, None], (*own.shape[:2], base.shape[1]))
        part = _explain_by_gains(torque[b] - torque[a], np.concatenate([own, common], axis=-1), free[b])
        total, explained = total + part[0], explained + part[1]
    return 1.0 - explained / total if total > 0.0 else 1.0


def _explain_by_gains(change: FloatArray, state: FloatArray, on: BoolArray) -> tuple[float, float]:
    """Return the sum of squares of changes (T, joints), and what gains on those of the state explain of it.

    Joints of which fewer than twenty rows are `on` (T, joints) count for nothing.
    """
    change = np.where(on, change, 0.0)
    state = np.where(on[..., None], state, 0.0)
    rows = np.ascontiguousarray(state.transpose(1, 2, 0))
    squares = rows @ rows.transpose(0, 2, 1)
    size = np.sqrt(np.einsum("jkk->jk", squares))
    size = np.where(size > 0.0, size, 1.0)
    squares = squares / (size[:, :, None] * size[:, None, :]) + 1e-9 * np.eye(rows.shape[1])
    product = (rows @ change.T[..., None])[..., 0] / size
    gains = np.linalg.solve(squares, product[..., None])[..., 0]
    good = on.sum(axis=0) >= 20
    total, told = np.einsum("tj,tj->j", change, change), np.einsum("jk,jk->j", gains, product)
    return float(total[good].sum()), float(told[good].sum())


def chatter(s: Signals) -> Iterator[Sign]:
    """Yield torques that turn nearly every row, by a good part of what they can give."""
    if not s.torques.shape[1] or len(s.time) < 4:
        return
    ticks = s.ticks
    asked = s.asked[ticks]
    step = np.diff(asked, axis=0, prepend=asked[:1])
    flips = np.zeros(step.shape, dtype=bool)
    flips[1:] = step[1:] * step[:-1] < 0.0
    largest = np.maximum(largest_torques(s), 1e-9)
    window = max(s.rows(0.5 * s.limits.window) // s.hold, 1)
    if s.hold > 1:  # what is held for long turns now and then by chance
        window = max(window, s.limits.least_ticks)
    turning = sliding_mean(flips.astype(np.float64), window)
    swing = np.sqrt(sliding_mean(step**2, window)) / largest
    on = (turning > (s.limits.flips if s.hold == 1 else s.limits.held_flips)) & (swing > s.limits.swing)
    for k, name in enumerate(s.joints):
        at = s.first(on[:, k], window)
        if at is not None:
            row, share, size = int(ticks[at]), turning[at, k], swing[at, k]
            words = f"the torque of {name} turns in {share:.0%} of rows, by {size:.0%} of its largest"
            yield Sign(float(s.time[row]), name, words, float(turning[:, k].mean()))


def too_fast(s: Signals) -> Iterator[Sign]:
    """Yield commanded speeds that no legs of this height follow."""
    if "command" in s and s.height > 0.0:
        speed = np.hypot(*s.numbers("command")[:, :2].T)
        fastest = s.limits.froude * float(np.sqrt(GRAVITY * s.height))
        row = s.first(speed > fastest)
        if row is not None:
            words = f"{speed[row]:.2f} m/s is commanded, legs of this height do {fastest:.2f} at most"
            yield Sign(float(s.time[row]), "body", words, 1.0)


def at_stops(s: Signals) -> Iterator[Sign]:
    """Yield joints that are driven into their stops, by more than half of what they can."""
    ranges = s.log.facts.get("model_joint_ranges")
    q, _ = s.joint_state
    if ranges is None or q.shape != s.torques.shape or not q.shape[1]:
        return
    low, high = np.asarray(ranges, dtype=np.float64).T
    slack = 0.01 * np.where(np.isfinite(high - low), high - low, 0.0)
    least = 0.5 * np.maximum(largest_torques(s), 1e-9)
    into = ((q > high - slack) & (s.asked > least)) | ((q < low + slack) & (s.asked < -least))
    for k, name in enumerate(s.joints):
        row = s.first(into[:, k], s.rows(s.limits.stop_time))
        if row is not None:
            words = f"{name} is driven against its stop at {q[row, k]:.2f}"
            yield Sign(float(s.time[row]), name, words, float(into[:, k].mean()))
