"""What would have been without a cause, recomputed from the log: it held then, or the cause is refuted.

Each asks one law. Friction: the least that the feet need for the wrench that they gave, against what there
is, by the programs of `statics`. Balance: the capture point with and without the velocity that a push has
given. Torque: what was asked for, against what a motor gives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.records.audit.story.control_causes import FAINT
from surefoot.records.audit.story.gait_causes import walks
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.statics import least_friction
from surefoot.records.audit.story.told import Event

SAMPLES = 6
"""How often it is looked at how much friction feet need before a slip."""


class Without(NamedTuple):
    """Whether the law that failed would have held without a cause, and the figures in words."""

    held: bool
    words: str


def _row(s: Signals, time: float) -> int:
    """Return the row of a time, the last of a later one."""
    return min(int(np.searchsorted(s.time, time)), len(s.time) - 1)


def without_slope(s: Signals, sign: Sign, failed: Event) -> Without | None:
    """Ask whether standing still on the slope needs more friction than there is."""
    row = _row(s, sign.time)
    on = s.loaded[row] & s.ground_feet
    if not on.any() or not s.positions.any():
        return None
    weight = np.concatenate([s.weight * s.up, np.zeros(3)])
    # where each foot stands is the gait's matter: what the ground asks for, it asks of them together
    middle = s.positions[row][on].mean(axis=0)
    needs = least_friction(s.positions[row][on], s.normals[row][on], middle, weight)
    there = float(s.mu[row][on].max())
    much = f"{needs:.2f}" if np.isfinite(needs) else "more than any"
    words = f"on level ground standing needs no friction, here {much} of {there:.2f}"
    return Without(needs > s.limits.steep * there, words)


def without_ice(s: Signals, sign: Sign, failed: Event) -> Without | None:
    """Ask whether the friction that there was before would have been enough for what the feet gave then."""
    row = _row(s, sign.time)
    feet = s.ground_feet & np.asarray(s.mu[row] < np.inf)
    there = s.mu[row][feet & s.loaded[row]]
    if not len(there) or not s.positions.any():
        return None
    needs, best = _friction_before(s, row, feet), float(there.min())
    before = float(np.where(s.loaded[:row] & feet, s.mu[:row], 0.0).max(initial=0.0))
    if needs is None or before <= best or needs > before:
        return None
    words = f"before, its feet needed a friction of {needs:.2f}, which {before:.2f} gives and {best:.2f} "
    return Without(True, words + ("does too" if needs <= best else "does not"))


def _friction_before(s: Signals, row: int, feet: BoolArray) -> float | None:
    """Return the most friction that loaded feet needed in rows before a slip; None without any."""
    first = max(row - s.rows(s.limits.window), 0)
    rows = np.flatnonzero(
        (s.loaded & feet)[first:row].any(axis=1) & ~(s.sliding & feet)[first:row].any(axis=1)
    )
    if not len(rows):
        return None
    chosen = first + rows[np.linspace(0, len(rows) - 1, min(SAMPLES, len(rows))).astype(int)]
    needs = [_friction_in(s, int(t), s.loaded[t] & feet) for t in chosen]
    known = [n for n in needs if np.isfinite(n)]
    return max(known) if known else None


def _friction_in(s: Signals, row: int, on: BoolArray) -> float:
    """Return the least friction with which contacts give the wrench that they gave in a row."""
    places, forces = s.positions[row][on], s.world_forces[row][on]
    moment = np.cross(places - s.com[row], forces).sum(axis=0)
    wrench = np.concatenate([forces.sum(axis=0), moment])
    return least_friction(places, s.normals[row][on], s.com[row], wrench)


def without_push(s: Signals, sign: Sign, failed: Event) -> Without | None:
    """Ask whether the capture point would have stayed within the feet without the velocity of a push.

    A push that was survived is refuted: long before the failure the capture point was within the feet again.
    """
    change = _change_of_push(s, sign)
    if change is None or not s.floating or not s.positions.any():
        return None
    end, velocity = change
    last = _row(s, failed.time)
    outside = s.capture_outside > 0.0
    calm = _calm(s, end, last, float(np.linalg.norm(velocity)))
    if calm is not None:
        words = f"it was survived: from {s.time[calm]:.2f} s on the capture point was within the feet again"
        return Without(False, words)
    left = end + int(outside[end : last + 1].argmax()) if outside[end : last + 1].any() else None
    if left is None:
        return None
    moved = velocity * s.pendulum_time
    off, less = _outside_by(s, left, np.zeros(3)), _outside_by(s, left, moved)
    if off is None or less is None or less >= off:
        return None
    words = (
        f"at {s.time[left]:.2f} s the capture point is {100.0 * off:.1f} cm outside of the feet, "
        f"without the {float(np.linalg.norm(velocity)):.2f} m/s of the push {100.0 * less:.1f} cm"
    )
    return Without(True, words)


def _change_of_push(s: Signals, sign: Sign) -> tuple[int, FloatArray] | None:
    """Return the last row of a push of the log, and the change (3,) of velocity by it [m/s]."""
    name = next((n for n in ("wrench_applied", "push") if n in s), None)
    if name is None:
        return None
    row = _row(s, sign.time)
    force = s.numbers(name)[:, :3]
    on = np.linalg.norm(force, axis=1) > s.limits.loaded * s.weight
    if row >= len(on) or not on[row]:
        return None
    end = row + int(np.argmin(np.append(on[row:], False)))
    return min(end, len(on) - 1), force[row:end].sum(axis=0) * s.dt / s.mass


def _calm(s: Signals, first: int, last: int, change: float) -> int | None:
    """Return since when after a row a robot that does not walk has caught a change of velocity [m/s].

    Its capture point is within its feet for a while, it is upright, and most of the velocity is gone.
    """
    if walks(s):
        return None
    inside = np.nan_to_num(s.capture_outside, nan=1.0) <= 0.0
    slow = np.linalg.norm(s.com_velocity, axis=1) < 0.5 * change
    good = (inside & slow & (s.lean < 0.5 * s.limits.crooked))[first:last]
    row = s.first(good, s.rows(s.limits.caught))
    return None if row is None else first + row


def _outside_by(s: Signals, row: int, less: FloatArray) -> float | None:
    """Return how far the capture point, moved back by so much (3,), is from the feet's hull [m]."""
    from scipy.spatial import ConvexHull, QhullError

    at = (s.positions[row] @ s.level_axes.T)[s.ground_feet]
    point = (s.com[row] + s.com_velocity[row] * s.pendulum_time - less) @ s.level_axes.T
    try:
        planes = ConvexHull(at).equations
    except (QhullError, ValueError):
        return float(np.linalg.norm(at - point, axis=1).min()) if len(at) else None
    return max(float((planes[:, :2] @ point + planes[:, 2]).max()), 0.0)


def without_limit(s: Signals, sign: Sign, failed: Event) -> Without | None:
    """Ask which torque would have been enough for what was asked for."""
    first = sign.where.split(", ")[0]
    if "torques_commanded" not in s or first not in s.joints:
        return None
    k, row = s.joints.index(first), _row(s, sign.time)
    stop = max(_row(s, failed.time), row + 1)
    asked, given = np.abs(s.asked[row:stop, k]), np.abs(s.torques[row:stop, k])
    if not len(asked):
        return None
    t = int((asked - given).argmax())
    short = float(asked[t] - given[t])
    if short <= FAINT * float(asked[t]):
        return None  # what is asked for may have been cut as well
    return Without(True, f"{asked[t]:.3g} N m were asked for, {given[t]:.3g} given")


def without_load(s: Signals, sign: Sign, failed: Event) -> Without | None:
    """Ask how much of their limits torques took before a load, and after."""
    row = _row(s, sign.time)
    stop = min(_row(s, failed.time) + 1, len(s.time))
    if not s.torques.shape[1] or not np.isfinite(s.torque_limits).any() or row < 2 or stop <= row:
        return None
    share = np.abs(s.asked) / np.maximum(s.torque_limits, 1e-9)
    before, after = (float(share[a:b].max()) for a, b in ((row // 2, row), (row, stop)))
    if after <= before:
        return None
    words = f"{after:.0%} of a motor's limit is asked for, before it {before:.0%} at most"
    return Without(True, words)
