"""Causes that lie in the world: pushes, payloads, ground without grip, edges, collisions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.phases import joined_runs
from surefoot.base.numerics.windows import sliding_mean
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import frames_on
from surefoot.records.audit.model_changes import logged_changes
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.symptoms.fits import rotation_between

MOST_NAMES = 4
"""Shapes whose friction changed that are named."""


def model_changes(s: Signals, kind: str) -> Iterator[tuple[float, str, float]]:
    """Yield when, whose and by which factor the loop changed numbers of one kind in its model."""
    for time, what, name, factor in logged_changes(s.log):
        if what == kind:
            yield time, name, factor


def push(s: Signals) -> Iterator[Sign]:
    """Yield outside forces of the log, and other bodies that hit the robot for a moment."""
    speed = np.sqrt(GRAVITY * max(s.height, 0.05))
    for start, end, force, where in [*_outside(s), *_hits(s)]:
        change = float(np.linalg.norm(force[start:end].sum(axis=0))) * s.dt / s.mass
        if change > s.limits.push * speed:
            peak = float(np.linalg.norm(force[start:end], axis=1).max())
            words = f"{peak:.3g} N for {(end - start) * s.dt:.2g} s change its velocity by {change:.2g} m/s"
            yield Sign(float(s.time[start]), where, words, change / speed)


def _outside(s: Signals) -> Iterator[tuple[int, int, FloatArray, str]]:
    """Yield spans of outside force with first and last row, (T, 3) force [N] and the pushed link."""
    name = next((n for n in ("wrench_applied", "push") if n in s), None)
    if name is None:
        return
    force = s.numbers(name)[:, :3]
    on = np.linalg.norm(force, axis=1) > s.limits.loaded * s.weight
    links = s.texts("model_bodies")
    if s.log.facts.get("kind") == "recording" and "pushed_body" not in s:
        return  # weight that was put on, thrust and drag
    place = s.numbers("pushed_body") if "pushed_body" in s else np.full(len(on), -1.0)
    if "pushed_body" in s:
        on &= place >= 0.0
    for start, end in joined_runs(on):
        k = int(place[start])
        yield start, end, force, links[k] if 0 <= k < len(links) else "body"


def _hits(s: Signals) -> Iterator[tuple[int, int, FloatArray, str]]:
    """Yield the same of what movable bodies do to the robot, for less than a time of pushes."""
    if not s.torques.shape[1]:
        return  # what cannot move by itself is pushed on purpose
    for k in np.flatnonzero(s.on_movable & ~_bears_robot(s)):
        on = s.forces[:, k, 2] > s.limits.loaded * s.weight
        for start, end in joined_runs(on, s.rows(s.limits.lies)):
            only = np.arange(s.loaded.shape[1]) == k
            if (end - start) * s.dt < s.limits.lies and s.came_at(start, only):
                yield start, end, s.world_forces[:, k], s.links[k]


def _bears_robot(s: Signals) -> BoolArray:
    """Return (p,) which contacts hold up the robot on something that can move: a board, not a ball thrown."""
    share = (s.world_forces @ s.up).sum(axis=0) / max(float((s.world_forces @ s.up).sum()), 1e-9)
    return np.asarray((share > 0.2) | (s.is_foot & (share > 0.0)))


def payload(s: Signals) -> Iterator[Sign]:
    """Yield mass that is added to a link, and bodies that come to lie on one."""
    masses = np.asarray(s.log.facts.get("model_masses", np.zeros(0)), dtype=np.float64)
    links = s.texts("model_bodies")
    for time, name, factor in model_changes(s, "mass"):
        if name in links and (factor - 1.0) * masses[links.index(name)] > 0.5 * s.limits.payload * s.mass:
            more = (factor - 1.0) * masses[links.index(name)]
            yield Sign(time, name, f"{name} is {more:.2g} kg heavier, {more / s.mass:.0%} of all", 1.0)
    for link in dict.fromkeys(s.links[k] for k in np.flatnonzero(s.on_movable)):
        mine = s.on_movable & np.array([other == link for other in s.links])
        above = s.normals[:, mine] @ s.up < -0.7
        down = np.where(above, -(s.world_forces[:, mine] @ s.up), 0.0).sum(axis=1)
        for start, end in joined_runs(down > 0.0, s.rows(s.limits.lies)):
            mean = float(down[start:end].mean())
            heavy = (end - start) * s.dt >= s.limits.lies and mean > s.limits.payload * s.weight
            if heavy and s.came_at(start, mine & s.loaded[start]):
                yield Sign(float(s.time[start]), link, f"{mean / GRAVITY:.2g} kg lies on {link}", 1.0)


def slope(s: Signals) -> Iterator[Sign]:
    """Yield ground under the first loaded feet that is steeper than its friction can hold."""
    if not (s.loaded & s.is_foot).any():
        return
    row = int((s.loaded & s.is_foot).any(axis=1).argmax())
    on = s.loaded[row] & s.ground_feet
    if not on.any():
        return
    lift = np.clip(s.normals[row][on] @ s.up, 1e-6, 1.0)
    tilt = float(np.arccos(lift.max()))  # where the least steep of them stands
    mu = float(s.mu[row][on].max())
    if np.tan(tilt) > s.limits.steep * mu and tilt > 0.02:
        words = f"the ground leans by {np.degrees(tilt):.0f} deg, friction {mu:.2f} holds {_holds(mu):.0f}"
        yield Sign(float(s.time[row]), "ground", words, float(np.tan(tilt) / max(mu, 1e-9)))


def _holds(mu: float) -> float:
    return float(np.degrees(np.arctan(mu)))


def slippery(s: Signals) -> Iterator[Sign]:
    """Yield feet that slide with their friction used up, on less of it than before or on little at all."""
    fallen = dict[float, list[tuple[str, float]]]()
    for time, name, factor in model_changes(s, "friction"):
        if factor < s.limits.less_grip:
            fallen.setdefault(time, []).append((name, factor))
    for time, changes in fallen.items():  # of the ground and all that stands on it at once, as a rule
        names = ", ".join(name for name, _ in changes[:MOST_NAMES])
        more = f" and {len(changes) - MOST_NAMES} more" if len(changes) > MOST_NAMES else ""
        least = min(factor for _, factor in changes)
        yield Sign(time, names, f"the friction of {names}{more} falls to {least:.1%}", 1.0)
    if (s.torques.shape[1] and not s.floating) or s.thrown:
        return  # a hand that slides does not fall, and what is thrown slides
    touched = s.texts("contact_with")
    known = np.where(s.loaded & s.ground_feet, s.mu, 0.0).max(axis=1, initial=0.0)
    before = np.maximum.accumulate(known)[:, None]
    slippery_there = (s.mu < s.limits.slippery) | (s.mu < s.limits.less_grip * before)
    window = s.rows(2.0 * s.limits.brief)
    for k in np.flatnonzero(s.ground_feet & s.sliding.any(axis=0)):
        there = s.sliding[:, k] & slippery_there[:, k]
        # a contact that bounces slides now and then
        row = s.first(there & (sliding_mean(there.astype(np.float64), window) > 0.3))
        if row is not None:
            mu, best = float(s.mu[row, k]), float(before[row, 0])
            ground = touched[k] if k < len(touched) else "the ground"
            more = f", {best:.2f} before" if best > mu else ""
            words = f"it slides on {ground}, whose friction is {mu:.2f}{more}"
            yield Sign(
                _came_there(s, slippery_there, row), s.links[k], words, 1.0 - mu, shown=float(s.time[row])
            )


def _came_there(s: Signals, there: BoolArray, row: int) -> float:
    """Return when feet came to such ground (T, p) on which one slides in a row, and stayed there [s]."""
    on = np.asarray((there & s.loaded & s.ground_feet).any(axis=1))
    stays = joined_runs(on, s.rows(s.limits.lies))
    return float(s.time[next((start for start, end in stays if start <= row < end), row)])


def edge(s: Signals) -> Iterator[Sign]:
    """Yield feet that meet ground higher or lower than the plane that they began on, or its side."""
    on = s.loaded & s.ground_feet
    if not on.any():
        return
    first = int(on.any(axis=1).argmax())
    begin = slice(first, first + s.rows(3.0 * s.limits.window))
    places, normals = s.positions[begin][on[begin]], s.normals[begin][on[begin]]
    normal = normals.mean(axis=0)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-9)
    level = float(np.median(places @ normal))
    over, side = s.positions @ normal - level, s.normals @ normal
    high = on & (np.abs(over) > s.limits.edge + _depth(s))
    low = s.ground_feet & (over < -s.limits.edge - _depth(s)) & (s.gaps > 0.0)
    wall = on & (side < 0.7)
    for k in range(on.shape[1]):
        where = (high | low | wall)[:, k]
        row = s.first(where)
        if row is not None and row > first:
            step = 100.0 * float(over[row, k])
            words = f"its ground is {step:+.1f} cm from the plane that it began on"
            yield Sign(float(s.time[row]), s.links[k], words, 1.0)


def _depth(s: Signals) -> float:
    """Return how deep soft contact lets feet sink in the first rows [m]."""
    begin = s.rows(0.3)
    gaps = np.where(s.loaded[:begin], s.gaps[:begin], 0.0)
    return float(max(-gaps.min(initial=0.0), 0.0))


def self_collision(s: Signals) -> Iterator[Sign]:
    """Yield links of the robot that press on each other, or on the stand that they are bolted to."""
    if s.bolted:
        yield from _hits_stand(s)
    if "inner_force" not in s:
        return
    force = s.numbers("inner_force")
    row = s.first(force > s.limits.inner * s.weight, s.rows(0.25 * s.limits.brief))
    if row is None:
        return
    links = s.texts("model_bodies")
    pair = [links[int(k)] for k in s.numbers("inner_bodies")[row] if 0 <= int(k) < len(links)]
    words = f"{' and '.join(pair)} press on each other with up to {force[row:].max():.3g} N"
    yield Sign(float(s.time[row]), ", ".join(pair) or "body", words, 1.0)


def _hits_stand(s: Signals) -> Iterator[Sign]:
    """Yield links of a bolted robot that press on what stands still under its base, or close by."""
    offsets = np.asarray(s.log.facts.get("model_positions", np.zeros((0, 3))), dtype=np.float64)
    if len(offsets) < 2 or "contact_positions" not in s:
        return
    reach = float(np.linalg.norm(offsets[1:], axis=1).sum())
    away = np.linalg.norm((s.positions - offsets[0]) @ s.level_axes.T, axis=-1)
    on = s.loaded & ~s.on_movable & (away < s.limits.near_base * reach)
    touched = s.texts("contact_with")
    for k in range(on.shape[1]):
        row = s.first(on[:, k], s.rows(0.25 * s.limits.brief))
        if row is not None:
            stand = touched[k] if k < len(touched) else "the stand"
            most = float(s.forces[row:, k, 2].max())
            words = f"{s.links[k]} presses on {stand} at its own base with up to {most:.3g} N"
            yield Sign(float(s.time[row]), s.links[k], words, 1.0)


def wrong_frame(s: Signals) -> Iterator[Sign]:
    """Yield that the forces of a log are those that moved it once they are turned, or of the other sign."""
    if not s.forces.any() or not s.mass > 0.0:
        return
    if "momentum_rate" not in s:
        yield from _beyond_cones(s)
        return
    applied = s.numbers("wrench_applied")[:, :3] if "wrench_applied" in s else 0.0
    needed = s.numbers("momentum_rate")[:, :3] - s.mass * s.gravity - applied
    given = s.world_forces.sum(axis=1)

    def left(forces: FloatArray) -> float:
        """Return what (T, 3) forces leave of the needed ones, along the ground and against gravity [N²]."""
        rest = needed - forces
        along = rest - np.outer(rest @ s.up, s.up)
        level = needed - np.outer(needed @ s.up, s.up)
        scale = max(float(np.sum(level**2)), 1e-4 * float(np.sum(needed**2)), 1e-300)
        return float(np.sum(along**2)) / scale + float(np.sum(rest**2) / max(np.sum(needed**2), 1e-300))

    amiss = left(given)
    if amiss < s.limits.turned:
        return
    tried = {
        "have the other sign": -given,
        "are in world axes": s.forces.sum(axis=1),
        "are turned": given @ rotation_between(given, needed).T,
        "are turned about their normals": _turned_about_normals(s, needed),
    }
    words, best = min(tried.items(), key=lambda item: left(item[1]))
    if left(best) < 0.2 * amiss:
        yield Sign(float(s.time[0]), "all", f"they explain the motion once one takes that they {words}", 1.0)


def _beyond_cones(s: Signals) -> Iterator[Sign]:
    """Yield that no contact gives most of a log's forces: where nothing else is known of what they moved."""
    # forces and cones that are wider than doubles are
    with np.errstate(over="ignore"):
        size = np.linalg.norm(s.forces, axis=-1)
        on = (size > s.limits.loaded * s.weight) & np.isfinite(s.mu) & (s.mu > 0.0)
        if on.sum() < s.rows(s.limits.window):
            return
        forces = s.forces[on]
        # axes in another order may leave nothing along the normal
        most = (1.0 + s.limits.turned) * s.mu[on] * np.maximum(forces[:, 2], 0.0)
        share = float((np.hypot(forces[:, 0], forces[:, 1]) > most).mean())
    if share > 0.5:
        words = f"{share:.0%} of them lie far outside of their cones: their axes are not the contacts'"
        yield Sign(float(s.time[0]), "all", words, share)


def _turned_about_normals(s: Signals, needed: FloatArray) -> FloatArray:
    """Return the sum (T, 3) of a log's forces turned about their contacts' normals by the best of angles."""
    frames = frames_on(s.normals)
    along, across = s.forces.copy(), s.forces.copy()
    across[..., 0], across[..., 1], across[..., 2] = -s.forces[..., 1], s.forces[..., 0], 0.0
    along[..., 2] = 0.0
    part = [np.einsum("tpij,tpj->ti", frames, f) for f in (along, across)]
    rest = s.world_forces.sum(axis=1) - part[0]
    basis = np.stack([p.ravel() for p in part], axis=1)
    cosine, sine = np.linalg.lstsq(basis, (needed - rest).ravel(), rcond=None)[0]
    size = max(float(np.hypot(cosine, sine)), 1e-9)
    return np.asarray(rest + (cosine * part[0] + sine * part[1]) / size)
