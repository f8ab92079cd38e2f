"""Causes that lie in what a controller believes: a biased sensor, another body, a pose out of reach.

No log tells what was measured. What torques were asked for tells of it: a joint at rest in the pose that it
was started in needs none but what gravity asks, and what is asked for does not jump where nothing moves.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.story.control_causes import at_limit, chatter, largest_torques
from surefoot.records.audit.story.failure import fall, stray
from surefoot.records.audit.story.gait_causes import left_the_feet, walks
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals


def bias(s: Signals) -> Iterator[Sign]:
    """Yield a torque that nothing in the motion asks for: of one joint, in the first row or from a row on."""
    found = _first_torque(s) or _jump(s, alone=True)
    if found is not None:
        yield found


def drift(s: Signals) -> Iterator[Sign]:
    """Yield that several torques jump at once, or that a body is driven to one side from the start."""
    found = _jump(s, alone=False)
    if found is not None:
        yield found
        return
    pull, row = pull_at_rest(s), left_the_feet(s)
    if not s.torques.shape[1]:
        return
    if walks(s, row):
        yield from _walks_crooked(s)
        return
    if row is None:
        yield from _creeps(s)
        return
    if pull is not None and float(np.linalg.norm(pull - (pull @ s.up) * s.up)) < 0.2 * s.limits.drives:
        return
    if pull is None and _stood_still(s, row):
        return
    way = (s.com[row] - s.com[0]) @ s.level_axes.T
    words = f"it is driven {100.0 * float(np.linalg.norm(way)):.0f} cm to one side until it tips"
    yield Sign(float(s.time[0]), s.base, words, s.limits.drift_strength)


def _stood_still(s: Signals, row: int) -> bool:
    """Return whether hardly any of the way to a row was gone for a while at first."""
    way = np.linalg.norm((s.com[: row + 1] - s.com[0]) @ s.level_axes.T, axis=1)
    begun = int(np.flatnonzero(way <= s.limits.drift_begun * way[-1])[-1])
    return bool((begun + 1) * s.dt > s.limits.stood)


def _creeps(s: Signals) -> Iterator[Sign]:
    """Yield since when a body that stands leans or drifts ever more, until it has lost its place."""
    lost = stray(s)
    if lost is None:
        return
    row = int(np.searchsorted(s.time, lost.time))
    way = (s.com - s.com[0]) @ s.level_axes.T
    for size in (s.lean, np.linalg.norm(way, axis=1)):
        begun = int(np.flatnonzero(size[: row + 1] <= s.limits.drift_begun * size[row])[-1])
        if size[row] > 0.0 and (row - begun) * s.dt > s.limits.stood:
            words = f"it leans and drifts ever more from {s.time[begun]:.2f} s on, by torques of its own"
            yield Sign(float(s.time[begun]), s.base, words, s.limits.drift_strength)
            return


def _walks_crooked(s: Signals) -> Iterator[Sign]:
    """Yield since when a body that walks on leans ever more, slower than anything falls, and to the end."""
    last = s.lean[-s.rows(s.limits.lies) :]
    if float(last.min()) < s.limits.crooked:
        return
    there = int((s.lean >= 0.9 * float(last.mean())).argmax())
    begun = int(np.flatnonzero(s.lean[: there + 1] <= s.limits.drift_begun * s.lean[there])[-1])
    if (there - begun) * s.dt > s.pendulum_time:
        words = (
            f"it leans ever more from {s.time[begun]:.2f} s on, and walks on with "
            f"{np.degrees(last.mean()):.0f} deg, by torques of its own"
        )
        yield Sign(float(s.time[begun]), s.base, words, s.limits.drift_strength)


def _shares(s: Signals) -> FloatArray:
    """Return (T, joints) torques that are asked for over the largest."""
    return np.asarray(s.asked / np.maximum(largest_torques(s), 1e-9))


def _first_torque(s: Signals) -> Sign | None:
    """Return the one joint that is asked for a torque in the very first row, in which all others rest."""
    _, v = s.joint_state
    if s.torques.shape[1] < 2 or not v.shape[1] or np.abs(v[0]).max() > 1e-6:
        return None
    in_the_air = s.floating and not s.loaded[: s.rows(s.limits.started_on)].any()
    if in_the_air and s.asked.any(axis=0).sum() < s.limits.few_driven:
        return None  # a limb is swung to where it will land, one other rests
    share = np.abs(_shares(s)[0])
    k = int(share.argmax())
    if share[k] < s.limits.biased or np.delete(share, k).max() > 0.25 * share[k]:
        return None
    if abs(s.asked[0, k]) < 1.2 * _weight_on(s)[k]:
        return None
    words = f"{s.joints[k]} is asked for {s.asked[0, k]:+.3g} N m where it was started, at rest; no other is"
    return Sign(float(s.time[0]), s.joints[k], words, s.limits.jump_strength)


def _jump(s: Signals, alone: bool) -> Sign | None:
    """Return the first row in which torques jump by far more than ever before, though nothing else happens.

    Parameters
    ----------
    s
        The signals.
    alone
        Whether one joint's jump is looked for, else that of several at once.
    """
    ticks = s.ticks
    if s.torques.shape[1] < 2 or len(ticks) < 8:
        return None
    share = _shares(s)[ticks]
    jump = np.abs(np.diff(share, axis=0))
    calm = s.time[ticks[1:]] - s.time[0] > s.limits.known_after
    before = np.maximum.accumulate(jump, axis=0)[:-1]
    odd = (jump[1:] > s.limits.jumps * before) & (jump[1:] > s.limits.biased) & calm[1:, None]
    # who falls silent has lost a motor, not a sensor
    odd &= np.abs(share[2:]) > 1e-9
    if s.floating:
        odd &= ~_contact_changes(s)[ticks[2:], None]
    fell = fall(s)
    until = np.inf if fell is None else fell.time
    for t in np.flatnonzero(odd.any(axis=1)):
        which = np.flatnonzero(odd[t])
        # small torques that jump as never before are a controller's that switches, not one sensor's
        with_it = (jump[t + 1] > s.limits.jumps * before[t]) & (
            jump[t + 1] > s.limits.with_it * jump[t + 1].max()
        )
        if (len(which) == 1 and with_it.sum() <= 1) != alone:
            continue
        if (jump[t + 1] > s.limits.biased).sum() > len(which):  # a landing or a blow, which all joints answer
            continue
        k = int(which[jump[t + 1][which].argmax()])
        again = (jump[t + 2 :, k] > 0.8 * jump[t + 1, k]) & (s.time[ticks[t + 3 :]] < until)
        if again.any():  # a controller that switches does so again and again
            continue
        size, most = float(jump[t + 1, k] * largest_torques(s)[k]), jump[t + 1, k] / max(before[t, k], 1e-9)
        words = (
            f"the torque asked for at {s.joints[k]} jumps by {size:.3g} N m, {min(most, 999.0):.0f} times "
            "more than ever before, while nothing moves otherwise"
        )
        where = s.joints[k] if alone else s.base
        return Sign(float(s.time[ticks[t + 2]]), where, words, s.limits.jump_strength)
    return None


def _weight_on(s: Signals) -> FloatArray:
    """Return (joints,) the most that gravity asks: of what hangs on each, of all on a slide [N m, N]."""
    facts, count = s.log.facts, s.torques.shape[1]
    names = ("model_parents", "model_masses", "model_positions", "model_joint_bodies", "model_joint_axes")
    if any(name not in facts for name in names) or len(facts["model_joint_bodies"]) != count:
        return np.full(count, s.weight * max(s.height, 0.0))
    parents = np.asarray(facts["model_parents"], dtype=int)
    masses = np.asarray(facts["model_masses"], dtype=np.float64).copy()
    long = np.linalg.norm(np.asarray(facts["model_positions"], dtype=np.float64), axis=1)
    beyond = np.zeros(len(masses))
    for body in range(len(masses) - 1, 0, -1):
        masses[parents[body]] += masses[body]
        beyond[parents[body]] = max(beyond[parents[body]], beyond[body] + long[body])
    owners = np.asarray(facts["model_joint_bodies"], dtype=int)
    last = np.where(beyond[owners] > 0.0, beyond[owners], long[owners])
    hangs = masses[owners] * GRAVITY * last
    kinds = s.texts("model_joint_kinds")[-count:]
    slides = (
        np.array([kind == "slide" for kind in kinds]) if len(kinds) == count else np.zeros(count, dtype=bool)
    )
    out = np.where(slides, s.weight, hangs)
    if not s.floating:  # of a bolted robot the axes of its first joints are the world's
        axes = np.asarray(facts["model_joint_axes"], dtype=np.float64)
        upright = ~slides & (owners == owners.min()) & (np.abs(axes @ s.up) > 0.99)
        out[upright] = 0.0
    return out


def _contact_changes(s: Signals) -> BoolArray:
    """Return (T,) where a foot began or ceased to carry a moment before: controllers may switch by that."""
    change = np.zeros(len(s.time))
    for down in s.feet_down.values():
        change[1:] += down[1:] != down[:-1]
    total = np.cumsum(change)
    since = np.maximum(np.arange(len(total)) - s.rows(s.limits.brief), 0)
    return np.asarray(total > total[since])


def led_out(s: Signals) -> Iterator[Sign]:
    """Yield that a body that stood at first leads itself out of its feet, without a jump of its torques."""
    row = left_the_feet(s)
    if row is None or walks(s, row) or not s.torques.shape[1] or s.time[row] - s.time[0] < s.limits.stood:
        return
    if next(bias(s), None) is None and next(drift(s), None) is None:
        words = f"from {s.time[row]:.2f} s on its own torques lead it out over the edge of its feet"
        yield Sign(float(s.time[row]), "body", words, s.limits.drift_strength)


def pull_at_rest(s: Signals) -> FloatArray | None:
    """Return the mean force (3,) that moves a body in its first moments, over its weight.

    None unless it stands at rest at first, on contacts that do not give way.
    """
    on = s.loaded.any(axis=1)
    if "momentum_rate" not in s or not on.any() or not s.torques.shape[1] or s.height <= 0.0:
        return None
    first = int(on.argmax())
    begun = slice(first, first + s.rows(s.limits.at_rest))
    at_rest = float(np.linalg.norm(s.com_velocity[first])) < 0.05 and first * s.dt < 0.02
    firm = bool((np.where(s.loaded[begun], s.gaps[begun], 0.0) > -s.limits.depth).all())
    return s.numbers("momentum_rate")[begun, :3].mean(axis=0) / s.weight if at_rest and firm else None


def wrong_mass(s: Signals) -> Iterator[Sign]:
    """Yield that the controller says so, or that torques for another body push one at rest from the start."""
    believed = s.log.facts.get("mass_controller")
    if believed is not None and abs(float(believed) - s.mass) > s.limits.payload * s.mass:
        words = f"the controller believes in {float(believed):.3g} kg, there are {s.mass:.3g}"
        yield Sign(float(s.time[0]), s.base, words, 1.0)
        return
    pull = pull_at_rest(s)
    if pull is not None:
        beside = float(np.nan_to_num(s.capture_outside[: s.rows(s.limits.at_rest)], nan=np.inf).min())
        if s.limits.off_feet * s.height < beside < np.inf:
            words = f"started at rest, its centre of mass is {100.0 * beside:.0f} cm outside of its feet"
            yield Sign(float(s.time[0]), s.base, words, 1.0)
            return
    if pull is None or any(sign.time - s.time[0] < s.limits.at_rest for sign in chatter(s)):
        return  # gains that chatter push as it happens
    up = float(pull @ s.up)
    along = (pull - up * s.up) @ s.level_axes.T
    if "command" in s:  # a body that is led somewhere is pushed there
        led = (
            s.level_axes @ s.heading[0].T @ s.numbers("command")[: s.rows(s.limits.at_rest), :2].mean(axis=0)
        )
        size = float(np.linalg.norm(led))
        if size > 0.0:
            along = along - float(along @ led) / size**2 * led  # and before, what balances, the other way
    level = float(np.linalg.norm(along))
    sags = up < 0.0 and level < s.limits.drives and at_limit(s)[: s.rows(s.limits.at_rest)].any()
    if not sags and (abs(up) > s.limits.lifts or level > s.limits.drives):
        words = f"at rest its feet push it by {up:+.0%} of its weight upwards and {level:.0%} sideways"
        yield Sign(float(s.time[0]), s.base, words, abs(up) + level)
