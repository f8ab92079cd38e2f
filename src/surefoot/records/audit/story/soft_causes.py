"""Soft contact as a cause: ground that is deep, gives back energy, or throws up what slides flat."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.windows import sliding_sum
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals

BEGUN = 0.1
"""Share of an energy that is there when it is said to have begun."""
UPRIGHT = 0.05
"""Lean, and turning times sqrt(h / g), up to which a body lies flat [rad]."""

SURE = 0.95
"""Share of the base's reach up to which it is told that a body slides on: soft contacts sink unevenly."""


def soft(s: Signals) -> Iterator[Sign]:
    """Yield contacts that carry the robot deep below the surface, from the start or as they land."""
    most = s.limits.depth
    if not s.torques.shape[1]:  # a thing without joints may be small
        most = min(most, 0.1 * max(abs(s.height), 0.01))
    deep = s.loaded & (s.gaps < -most)
    for k in range(deep.shape[1]):
        # a hard landing goes deep for a moment in any soft contact
        row = s.first(deep[:, k], s.rows(1.5 * s.limits.brief))
        if row is None:
            row = s.first(deep[:, k] & (s.gaps[:, k] < -3.0 * most))
        if row is not None:
            way = -1e3 * float(s.gaps[:, k].min())
            yield Sign(float(s.time[row]), s.links[k], f"it sinks {way:.0f} mm into the ground", way / 1e3)
    yield from thrown_up(s)
    yield from returned_energy(s)


def returned_energy(s: Signals) -> Iterator[Sign]:
    """Yield that contact that should not rebound gave back energy, where a rigid one gives none."""
    if "contact_velocities" not in s or s.height <= 0.0:
        return
    dead = _never_rebounds(s) & ~s.on_movable
    struck = _struck(s)
    power = np.where(dead & ~struck[:, None], _power_out(s), 0.0)
    given = sliding_sum(power.sum(axis=1), s.rows(s.limits.lies)) * s.dt
    row = int(given.argmax())
    if given[row] > s.limits.returned * s.weight * s.height:
        k, lift = int(power[row].argmax()), float(given[row] / s.weight)
        first = max(row - s.rows(s.limits.lies), 0)
        so_far = np.cumsum(power[first : row + s.rows(s.limits.lies)].sum(axis=1))
        first += int((so_far > BEGUN * so_far[-1]).argmax())
        words = (
            f"it gives back {given[row]:.2g} J within {s.limits.lies:g} s, enough to lift all by "
            f"{1e3 * lift:.0f} mm, where rigid contact gives none"
        )
        yield Sign(float(s.time[first]), s.links[k], words, 1.0)


def _struck(s: Signals) -> BoolArray:
    """Return (T,) where something that can move has just begun to press: the ground gives back that blow."""
    on = np.asarray((s.loaded & s.on_movable).any(axis=1))
    begun = np.flatnonzero(on & ~np.concatenate([[False], on[:-1]]))
    out: BoolArray = np.zeros(len(on), dtype=np.bool_)
    for row in begun:
        out[row : row + s.rows(s.limits.lies)] = True
    return out


def _never_rebounds(s: Signals) -> BoolArray:
    """Return (p,) which contacts give back nothing by their world's own law."""
    declared = np.asarray(s.log.facts.get("critically_damped", np.zeros(len(s.names))))
    return np.asarray(declared > 0.0)


def _power_out(s: Signals) -> FloatArray:
    """Return what contacts give back along their normals: (T, p) [W]."""
    return np.asarray(np.maximum(s.forces[..., 2] * s.numbers("contact_velocities")[..., 2], 0.0))


class FlatSlide(NamedTuple):
    """A body that slides flat: row, normal (3,), heights and lengths [m], friction.

    `ahead` is how far its base reaches in front of its centre of mass, which is `height` above it.
    """

    row: int
    normal: FloatArray
    height: float
    ahead: float
    friction: float


def thrown_up(s: Signals) -> Iterator[Sign]:
    """Yield that a body without joints, sliding flat, is tipped or lifted where Coulomb's law slides it on.

    With all forces in their cones their resultant acts within the base as long as mu times the height of the
    centre of mass is less than the base's reach ahead of it: then rigid contact slides it without a turn.
    """
    flat = _flat_slide(s) if s.jointless and "contact_velocities" in s else None
    if flat is None or not flat.friction * flat.height < SURE * flat.ahead:
        return
    rest = slice(flat.row, _meets_more(s, flat))
    rise, lean = ((s.com - s.com[flat.row]) @ flat.normal)[rest], s.lean[rest]
    thrown = (lean > s.limits.crooked) | (rise > s.limits.thrown * flat.height)
    if not thrown.any():
        return
    last = int(thrown.argmax())
    begun = flat.row + int(((rise > BEGUN * rise[last]) | (lean > BEGUN * lean[last])).argmax())
    most = float(rise.max())
    words = (
        f"it lifts what slides flat by {1e3 * most:.0f} mm ({most * s.weight:.2g} J) and tips it by "
        f"{np.degrees(lean.max()):.0f} deg; by Coulomb's law it slides on upright (friction "
        f"{flat.friction:.2f} at {flat.height:.2g} m of height, {flat.ahead:.2g} m of base ahead)"
    )
    yield Sign(float(s.time[begun]), s.base, words, 1.0)


def _flat_slide(s: Signals) -> FlatSlide | None:
    """Return how a body first slides flat on ground that stands still; None if it never does."""
    on = s.loaded & ~s.on_movable & _never_rebounds(s)
    turning = np.linalg.norm(s.numbers("v")[:, 3:5], axis=1) * s.pendulum_time
    row = s.first((on.sum(axis=1) >= 3) & (s.lean < UPRIGHT) & (turning < UPRIGHT))
    if row is None:
        return None
    normal = s.normals[row][on[row]].mean(axis=0)
    normal /= max(float(np.linalg.norm(normal)), 1e-9)
    way = s.com_velocity[row] - (s.com_velocity[row] @ normal) * normal
    speed = float(np.linalg.norm(way))
    if speed < s.limits.slip_speed:
        return None
    arms = s.positions[row][on[row]] - s.com[row]
    friction = float(np.where(on, s.mu, 0.0).max())
    return FlatSlide(row, normal, -float((arms @ normal).mean()), float((arms @ way).max()) / speed, friction)


def _meets_more(s: Signals, flat: FlatSlide) -> int:
    """Return the first row in which it is pushed, or touches more than the plane that it slides on."""
    level = float(np.median(s.positions[flat.row][s.loaded[flat.row]] @ flat.normal))
    off = np.abs(s.positions @ flat.normal - level) > s.limits.edge
    other = s.loaded & (s.on_movable | off | (s.normals @ flat.normal < 1.0 - UPRIGHT**2))
    pushed = s.numbers("pushed_body") >= 0.0 if "pushed_body" in s else np.zeros(len(s.time), dtype=bool)
    stop = other.any(axis=1) | pushed
    stop[: flat.row] = False
    return int(stop.argmax()) if stop.any() else len(s.time)
