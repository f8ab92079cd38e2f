"""What a story reads off a log, worked out once: who stands, who slides, which torques are given and asked.

Everything is over all T rows, in world axes unless said otherwise; NaN, which laws have judged, is zero.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.phases import runs_of
from surefoot.base.spatial import GRAVITY, rotation_from_normal, rotation_from_quaternion
from surefoot.mechanics import frames_on
from surefoot.records.audit.continuity import free_base
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Rows
from surefoot.records.audit.story.hulls import outside_hulls
from surefoot.records.audit.story.story_limits import STORY_LIMITS, StoryLimits
from surefoot.records.log import Log


class Signals:
    """The signals of one log.

    Parameters
    ----------
    log, setting
        The log and what its audit knows of it.
    limits
        What counts as an event.
    """

    def __init__(self, log: Log, setting: Setting, limits: StoryLimits = STORY_LIMITS) -> None:
        self.log, self.setting, self.limits = log, setting, limits
        self._rows = Rows(log, setting, 0, len(log))
        self.names, self.weight, self.dt = setting.names, setting.weight, setting.dt

    def __contains__(self, name: object) -> bool:
        return name in self.log

    def numbers(self, name: str) -> FloatArray:
        """Return a channel in its shape (T, ...) and unit, zero where it is not finite."""
        return self._rows.numbers(name)

    def rows(self, seconds: float) -> int:
        """Return how many rows a time [s] has, one at least."""
        return max(1, round(seconds / self.dt)) if self.dt > 0.0 else 1

    def texts(self, fact: str) -> tuple[str, ...]:
        """Return a fact of several texts; none where the log does not tell it."""
        return tuple(map(str, self.log.facts.get(fact, ())))

    @cached_property
    def time(self) -> FloatArray:
        """(T,) [s]."""
        return self.numbers("time")

    @cached_property
    def gravity(self) -> FloatArray:
        """(3,) [m/s²]."""
        return np.asarray(self.log.facts.get("gravity", (0.0, 0.0, -GRAVITY)), dtype=np.float64)

    @cached_property
    def up(self) -> FloatArray:
        """(3,) against gravity."""
        size = float(np.linalg.norm(self.gravity))
        return -self.gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])

    @cached_property
    def mass(self) -> float:
        """Mass of all that moves [kg]."""
        return self.weight / GRAVITY

    @cached_property
    def floating(self) -> bool:
        """Whether the robot has a base that is free, in space, in an upright plane or to rise: it falls."""
        return self.free or self.plane_turn is not None or self._rises

    def came_at(self, row: int, on: BoolArray) -> bool:
        """Return whether contacts (p,) that begin in a row do so as the other thing moves, not the robot.

        A hand that takes something up goes to it: the place of the contact has moved as the two closed in.
        A robot that is not bolted takes up nothing with its links.
        """
        if not self.bolted or "contact_velocities" not in self or not on.any() or row < 1:
            return True
        first = max(row - self.rows(self.limits.brief), 0)
        normals = self.normals[row][on]
        way = np.einsum("pi,pi->p", self.positions[row][on] - self.positions[first][on], normals)
        closed = float(np.median(self.numbers("contact_velocities")[first:row, on, 2].sum(axis=0))) * self.dt
        return not closed < 0.0 or bool(np.median(way) > self.limits.own_part * closed)

    @cached_property
    def bolted(self) -> bool:
        """Whether the log's model says that the base cannot move."""
        root = self.texts("model_joint_kinds")[:1]
        return bool(root) and root != ("free",) and "free_wrenches" not in self.log.facts

    @cached_property
    def _rises(self) -> bool:
        """Whether nothing but what it stands on holds up a base that slides."""
        wrenches = np.asarray(self.log.facts.get("free_wrenches", np.zeros((0, 6))), dtype=np.float64)
        if wrenches.ndim != 2 or wrenches.shape[1:] != (6,) or not self.torques.shape[1]:
            return False
        return bool((np.abs(wrenches[:, :3] @ self.up) > 0.5).any())

    @cached_property
    def plane_turn(self) -> int | None:
        """Which joint of a base turns it in the upright plane that it moves in; None for other bases."""
        wrenches = np.asarray(self.log.facts.get("free_wrenches", np.zeros((0, 6))), dtype=np.float64)
        if wrenches.ndim != 2 or wrenches.shape[1:] != (6,) or not 1 < len(wrenches) < 6 or "q" not in self:
            return None
        turns = np.linalg.norm(wrenches[:, 3:], axis=1) > 0.5
        rises = np.abs(wrenches[:, :3] @ self.up) > 0.5
        if turns.sum() != 1 or not rises.any() or len(wrenches) > self.numbers("q").shape[1]:
            return None
        return int(turns.argmax())

    @cached_property
    def free(self) -> bool:
        """Whether the base is free in space."""
        log = self.log
        if not {"q", "v"} <= set(log.arrays) or len(log) == 0:
            return False
        unit = self.setting.limits.records.unit_quaternion
        return bool(free_base(np.asarray(log["q"][:1]), np.asarray(log["v"][:1]), unit))

    @cached_property
    def jointless(self) -> bool:
        """Whether it is one free body, which nothing but its contacts moves."""
        return self.free and self.numbers("q").shape[1] == 7

    @cached_property
    def thrown(self) -> bool:
        """Whether it is one free body that moves along the ground at first, faster than in the end."""
        if not self.jointless:
            return False
        begin, end = (np.linalg.norm(self.com_velocity[row] @ self.level_axes.T) for row in (0, -1))
        return bool(begin > self.limits.slip_speed and end < begin)

    @cached_property
    def lean(self) -> FloatArray:
        """(T,) angle of the base's up axis from where it was at first [rad]; zero without a free base."""
        if self.plane_turn is not None:
            angle = self.numbers("q")[:, self.plane_turn]
            return np.asarray(np.abs(angle - angle[0]))
        if not self.free:
            return np.zeros(len(self.time))
        turn = self.numbers("q")[:, 3:7].copy()
        turn[~turn.any(axis=1)] = turn[0]  # what was NaN
        up = rotation_from_quaternion(turn)[:, :, 2]
        return np.asarray(np.arccos(np.clip(up @ up[0], -1.0, 1.0)))

    @cached_property
    def com(self) -> FloatArray:
        """(T, 3) centre of mass, the base where the log has no other [m]."""
        if "com" in self:
            return self.numbers("com")
        return self.numbers("q")[:, :3] if self.free else np.zeros((len(self.time), 3))

    @cached_property
    def com_velocity(self) -> FloatArray:
        """(T, 3) [m/s]."""
        if "momentum" in self:
            return self.numbers("momentum")[:, :3] / self.mass
        return np.gradient(self.com, axis=0) / max(self.dt, 1e-9) if len(self.time) > 1 else 0.0 * self.com

    @cached_property
    def is_foot(self) -> BoolArray:
        """(p,) which contact points are on feet; all where the log does not tell."""
        return np.asarray(self.log.facts.get("contact_is_foot", np.ones(len(self.names)))) > 0.0

    @cached_property
    def on_movable(self) -> BoolArray:
        """(p,) which contact points touch what can move."""
        return np.asarray(self.log.facts.get("contact_other_moves", np.zeros(len(self.names)))) > 0.0

    @cached_property
    def ground_feet(self) -> BoolArray:
        """(p,) whether each contact is a foot's, on ground that stands still."""
        return np.asarray(self.is_foot & ~self.on_movable)

    @cached_property
    def feet_down(self) -> dict[str, BoolArray]:
        """Link to where (T,) a foot of it is loaded on ground that stands still."""
        owners = dict.fromkeys(self.links[k] for k in np.flatnonzero(self.ground_feet))
        mine = {one: self.ground_feet & np.array([link == one for link in self.links]) for one in owners}
        return {one: np.asarray(self.loaded[:, which].any(axis=1)) for one, which in mine.items()}

    @cached_property
    def links(self) -> tuple[str, ...]:
        """(p,) links of the contact points, their feet's names where the log does not tell."""
        return self.texts("contact_body") or tuple(self.setting.feet[k] for k in self.setting.owner)

    @cached_property
    def base(self) -> str:
        """Name of the robot's root link, "body" where the log does not tell it."""
        return next(iter(self.texts("model_bodies")), "body")

    @cached_property
    def forces(self) -> FloatArray:
        """(T, p, 3) contact axes [N]."""
        return self._rows.forces

    @cached_property
    def normals(self) -> FloatArray:
        """(T, p, 3) unit normals of the ground; up where the log has none."""
        if "normals" not in self:
            return np.broadcast_to(self.up, self.forces.shape)
        n = self.numbers("normals")
        size = np.linalg.norm(n, axis=-1, keepdims=True)
        return np.asarray(np.where(size > 0.5, n / np.maximum(size, 0.5), self.up))

    @cached_property
    def world_forces(self) -> FloatArray:
        """(T, p, 3) [N]."""
        return np.asarray(np.einsum("tpij,tpj->tpi", frames_on(self.normals), self.forces))

    @cached_property
    def positions(self) -> FloatArray:
        """(T, p, 3) of the contacts [m]."""
        return self.numbers("contact_positions") if "contact_positions" in self else 0.0 * self.forces

    @cached_property
    def loaded(self) -> BoolArray:
        """(T, p) where contacts carry something."""
        return np.asarray(self.forces[..., 2] > self.limits.loaded * self.weight)

    @cached_property
    def gaps(self) -> FloatArray:
        """(T, p) distances to what is touched, negative in penetration [m]; zero where the log has none."""
        return self.numbers("gaps") if "gaps" in self else np.zeros(self.loaded.shape)

    @cached_property
    def mu(self) -> FloatArray:
        """(T, p) friction of the contacts, infinite where the log does not tell it."""
        if "contact_friction" in self:
            return self.numbers("contact_friction")
        own = self.numbers("mu")[:, None] if "mu" in self else np.full((len(self.time), 1), np.inf)
        return np.broadcast_to(own, self.loaded.shape)

    @cached_property
    def friction_use(self) -> FloatArray:
        """(T, p) friction that a force needs, over what there is; zero where nothing is loaded."""
        f = self.forces
        need = np.hypot(f[..., 0], f[..., 1]) / np.maximum(f[..., 2], 1e-9)
        return np.where(self.loaded, need / np.maximum(self.mu, 1e-9), 0.0)

    @cached_property
    def slip_speed(self) -> FloatArray:
        """(T, p) speed of loaded contacts along the ground, less what softness creeps [m/s]."""
        if "contact_velocities" not in self:
            return np.zeros(self.loaded.shape)
        v = self.numbers("contact_velocities")
        creep = self.numbers("contact_creep") if "contact_creep" in self else self.setting.creep
        speed = np.maximum(np.hypot(v[..., 0], v[..., 1]) - creep, 0.0)
        return np.asarray(np.where(self.loaded, speed, 0.0))

    @cached_property
    def sliding(self) -> BoolArray:
        """(T, p) where loaded feet slide with their friction used up."""
        return (
            np.asarray((self.slip_speed > self.limits.slip_speed) & (self.friction_use > self.limits.used_up))
            & self.is_foot
        )

    @cached_property
    def height(self) -> float:
        """Height of the centre of mass over the lowest contact when something first carries it [m]."""
        if not self.loaded.any():
            return 0.0
        row = int(self.loaded.any(axis=1).argmax())
        return float(((self.com[row] - self.positions[row][self.loaded[row]]) @ self.up).max())

    @cached_property
    def pendulum_time(self) -> float:
        """Time sqrt(h / g) in which a body at the height of the centre of mass tips [s]."""
        return float(np.sqrt(max(self.height, 1e-3) / GRAVITY))

    @cached_property
    def level_axes(self) -> FloatArray:
        """(2, 3) two axes across gravity."""
        return rotation_from_normal(self.up).T[:2]

    @cached_property
    def heading(self) -> FloatArray:
        """(T, 2, 3) axes across gravity: along the base's first axis, and to its left."""
        axes = np.broadcast_to(self.level_axes, (len(self.time), 2, 3))
        if not self.free:
            return axes
        turn = self.numbers("q")[:, 3:7].copy()
        turn[~turn.any(axis=1)] = (1.0, 0.0, 0.0, 0.0)
        level = rotation_from_quaternion(turn)[:, :, 0] @ self.level_axes.T
        size = np.linalg.norm(level, axis=1, keepdims=True)
        level = np.where(size > 1e-6, level / np.maximum(size, 1e-6), (1.0, 0.0))
        across = np.stack([-level[:, 1], level[:, 0]], axis=1)
        return np.stack([level @ self.level_axes, across @ self.level_axes], axis=1)

    @cached_property
    def capture_outside(self) -> FloatArray:
        """(T,) how far the capture point is outside the feet's hull [m]; zero inside, NaN in the air."""
        points = self.com + self.com_velocity * self.pendulum_time
        capture, places = points @ self.level_axes.T, self.positions @ self.level_axes.T
        feet, stride = self.ground_feet, self.rows(0.01)
        looked = np.arange(0, len(self.time), stride)
        looked = looked[(self.loaded[looked] & feet).any(axis=1)]
        found = np.full(-(-len(self.time) // stride), np.nan)
        found[looked // stride] = outside_hulls(places[looked][:, feet], capture[looked])
        return np.repeat(found, stride)[: len(self.time)]

    @cached_property
    def torques(self) -> FloatArray:
        """(T, joints) given torques [N m, N]."""
        return self.numbers("torques") if "torques" in self else np.zeros((len(self.time), 0))

    @cached_property
    def asked(self) -> FloatArray:
        """(T, joints) torques that were asked for, the given ones where the log has no other [N m, N]."""
        asked = self.numbers("torques_commanded") if "torques_commanded" in self else self.torques
        return asked if asked.shape == self.torques.shape else self.torques

    @cached_property
    def ticks(self) -> IntArray:
        """(n,) rows in which something new is asked for, the first among them: a controller may hold it."""
        new = np.ones(len(self.time), dtype=bool)
        if self.asked.shape[1]:
            new[1:] = (self.asked[1:] != self.asked[:-1]).any(axis=1)
        return np.flatnonzero(new)

    @cached_property
    def hold(self) -> int:
        """Rows for which what is asked for is held, as a rule."""
        gaps = np.diff(self.ticks)
        return int(np.median(gaps)) if len(gaps) else 1

    @cached_property
    def torque_limits(self) -> FloatArray:
        """(joints,) largest torques, infinite where the log does not tell [N m, N]."""
        facts = self.log.facts
        known = facts.get("effort_limits", facts.get("model_torque_limits"))
        count = self.torques.shape[1]
        fits = known is not None and np.shape(known) == (count,)
        return np.asarray(known, dtype=np.float64) if fits else np.full(count, np.inf)

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """(joints,) names."""
        names, count = self.texts("joints"), self.torques.shape[1]
        return names if len(names) == count else tuple(f"joint {k}" for k in range(count))

    @cached_property
    def joint_state(self) -> tuple[FloatArray, FloatArray]:
        """(T, joints) positions [rad, m] and velocities [rad/s, m/s] of the joints with torques."""
        count = self.torques.shape[1]
        if "joint_positions" in self and "joint_velocities" in self:
            return self.numbers("joint_positions"), self.numbers("joint_velocities")
        if not count or "q" not in self or "v" not in self:
            return np.zeros((len(self.time), count)), np.zeros((len(self.time), count))
        return self.numbers("q")[:, -count:], self.numbers("v")[:, -count:]

    @cached_property
    def base_state(self) -> FloatArray:
        """(T, n) what a controller may know of a base: lean [-, rad], turning [rad/s] and way [m/s]."""
        way = np.einsum("tij,tj->ti", self.heading, self.com_velocity)
        if self.plane_turn is not None:
            at = [self.plane_turn]
            return np.hstack([self.numbers("q")[:, at], self.numbers("v")[:, at], way])
        if not self.free:
            return np.zeros((len(self.time), 0))
        turn = self.numbers("q")[:, 3:7].copy()
        turn[~turn.any(axis=1)] = (1.0, 0.0, 0.0, 0.0)
        lean = np.einsum("tij,i->tj", rotation_from_quaternion(turn), self.up)[:, :2]
        return np.hstack([lean, self.numbers("v")[:, 3:6], way])

    def first(self, where: BoolArray, least: int = 1) -> int | None:
        """Return the first of so many rows of (T,) in a row that are true; None if there are no such."""
        return next((start for start, end in runs_of(where) if end - start >= least), None)
