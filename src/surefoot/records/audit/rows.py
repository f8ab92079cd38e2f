"""Rows of a log as the audit reads them: arrays derived piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property, reduce
from typing import Any, TypeAlias, TypeVar

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.numerics.vectors import planar_lengths
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import frames_on
from surefoot.records.audit.dynamics import UnexplainedForces, balanced_forces, unexplained
from surefoot.records.audit.laws import swinging
from surefoot.records.audit.log_context import PER_POINT, Setting
from surefoot.records.log import Log

Measured: TypeAlias = tuple[FloatArray, FloatArray, BoolArray]
"""Measure, limit, and where it is exceeded: (T, c) each, c the contacts or contacts and body."""
Made = TypeVar("Made")
PAD = 0.15
"""Time before and after a piece that its windows may look at [s]."""
PIECE = 1 << 15
"""Rows of a piece."""
FINITE = (
    *PER_POINT, "q", "v", "torques", "mu", "push", "other_forces", "momentum", "momentum_rate", "com",
    "energy", "wrench_applied", "contact_moments", "contact_creep", "pyramid_turn",
)  # fmt: skip


def lacking(log: Log, names: Iterable[str]) -> list[str]:
    """Return which of these channels a log lacks; friction may stand in either of two."""
    known = {"mu"} if "contact_friction" in log else set()
    return [name for name in names if name not in log and name not in known]


class Rows:
    """Rows `first` to `last` of a log with what surrounds them; `core` are those asked for.

    Numbers that are not finite are zero here; `not_finite` says where.
    """

    def __init__(self, log: Log, setting: Setting, first: int, last: int) -> None:
        pad = min(max(int(PAD / setting.dt), 2), PIECE) if setting.dt > 0.0 else 2
        self.first = max(first - pad, 0)
        self.log = log.rows(slice(self.first, min(last + pad, len(log))))
        self.core = slice(first - self.first, last - self.first)
        self.setting = setting
        self.count = len(self.log)
        self.points = len(setting.names)
        self._numbers: dict[str, FloatArray] = {}
        self._kept: dict[Callable[[Rows], Any], Any] = {}

    def has(self, *names: str) -> bool:
        """Return whether the log has all of these channels."""
        return self.points > 0 and not lacking(self.log, names)

    def once(self, function: Callable[[Rows], Made]) -> Made:
        """Return what a function makes of these rows, made once: several checks look at it."""
        if function not in self._kept:
            self._kept[function] = function(self)
        found: Made = self._kept[function]
        return found

    def numbers(self, name: str) -> FloatArray:
        """Return a channel's rows (T, ...) in its unit, zero where they are not finite."""
        known = self._numbers.get(name)
        if known is None:
            values = np.asarray(self.log[name], dtype=np.float64)
            finite = np.isfinite(values)
            known = self._numbers[name] = values if finite.all() else np.where(finite, values, 0.0)
        return known

    @cached_property
    def not_finite(self) -> BoolArray:
        """(T, p + 1) where a contact's measurement, or one of the body, is not finite."""
        out = np.zeros((self.count, self.points + 1), dtype=bool)
        for name in FINITE:
            if name not in self.log:
                continue
            bad = ~np.isfinite(np.asarray(self.log[name]))
            if not bad.any():
                continue
            if name in PER_POINT:
                out[:, :-1] |= bad.reshape(self.count, self.points, -1).any(axis=2)
            else:
                out[:, -1] |= bad.reshape(self.count, -1).any(axis=1)
        if "normals" in self.log:
            length = (self.numbers("normals") ** 2).sum(axis=2)
            out[:, :-1] |= np.abs(length - 1.0) > self.setting.limits.records.unit_length  # no direction
        return out

    @cached_property
    def all_finite(self) -> bool:
        """Whether every measurement is finite."""
        return not self.not_finite.any()

    @cached_property
    def time(self) -> FloatArray:
        """(T,) [s]."""
        return np.asarray(self.log["time"], dtype=np.float64)

    @cached_property
    def dt(self) -> FloatArray:
        """(T,) time to the next row, the usual one where the clock is wrong [s]."""
        steps = np.diff(self.time, append=self.time[-1:] + self.setting.dt)
        return np.where(np.isfinite(steps) & (steps > 0.0), steps, self.setting.dt)

    @cached_property
    def forces(self) -> FloatArray:
        """(T, p, 3) contact frames [N]; zero where the log has none: laws that need them are not judged."""
        return self.numbers("forces") if "forces" in self.log else np.zeros((self.count, self.points, 3))

    @cached_property
    def normal(self) -> FloatArray:
        """(T, p) normal forces [N]."""
        return np.ascontiguousarray(self.forces[..., 2])

    @cached_property
    def tangential(self) -> FloatArray:
        """(T, p) size of the tangential forces [N]."""
        return planar_lengths(self.forces)

    @cached_property
    def loaded(self) -> BoolArray:
        """(T, p) where a contact is loaded."""
        return self.normal > self.setting.threshold

    @cached_property
    def gaps(self) -> FloatArray:
        """(T, p) [m]."""
        return self.numbers("gaps")

    @cached_property
    def velocities(self) -> FloatArray:
        """(T, p, 3) contact frames [m/s]."""
        return self.numbers("contact_velocities")

    @cached_property
    def rising(self) -> FloatArray:
        """(T, p) velocities along the normals [m/s]."""
        return np.ascontiguousarray(self.velocities[..., 2])

    @cached_property
    def speeds(self) -> FloatArray:
        """(T, p) size of the tangential velocities [m/s]."""
        return planar_lengths(self.velocities)

    @cached_property
    def mu(self) -> FloatArray:
        """Friction of the ground [-]: (T, p) where each contact has its own, else (T, 1)."""
        own = "contact_friction" in self.log
        return np.maximum(self.numbers("contact_friction") if own else self.numbers("mu")[:, None], 0.0)

    @property
    def knows_creep(self) -> bool:
        """Whether it is known of every row how fast its contacts creep."""
        return "contact_creep" in self.log or "creep_slope" in self.log.facts

    @cached_property
    def creep(self) -> FloatArray:
        """Speed at which the world's soft friction lets contacts move: (T, p) or (1, 1) [m/s].

        By its own law a_t + b v_t + R f_t = 0, where the log has R f_t / b and b: that and what the contact
        is braked by, at least what holds the weight, since a_t is known to a step and a contact point's turn.
        """
        if not self.knows_creep:
            return np.full((1, 1), self.setting.creep)
        v = self.velocities[..., :2]
        change = np.diff(v, axis=0, append=v[-1:])
        along = v / np.maximum(self.speeds, 1e-300)[..., None]
        faster = change[..., 0] * along[..., 0] + change[..., 1] * along[..., 1]
        braked = np.maximum(-faster, 0.0) / self.dt[:, None]
        rate = np.asarray(self.log.facts.get("contact_damping", np.full(self.points, np.inf)))
        late = braked / np.maximum(rate, 1e-300)
        if "contact_creep" not in self.log:  # in proportion to what it holds, by the same law
            slope = max(float(self.log.facts["creep_slope"]), 0.0) / max(self.setting.weight, 1e-300)
            own = np.minimum(slope * self.tangential, self.setting.creep) + late
            # means have no law of an instant: the largest creep is theirs
            return np.asarray(np.maximum(own, self.setting.creep) if self.setting.means else own)
        creep = np.maximum(self.numbers("contact_creep"), 0.0) + late
        most = self.setting.limits.records.creep
        return np.asarray(np.maximum(creep, min(float(self.log.facts.get("creep", 0.0)), most)))

    @cached_property
    def slip(self) -> FloatArray:
        """(T, p, 3) velocities, the tangential ones less what the world creeps [m/s]."""
        if not self.creep.any():
            return self.velocities
        left = np.maximum(1.0 - self.creep / np.maximum(self.speeds, 1e-300), 0.0)
        return np.asarray(self.velocities * left[..., None])

    @cached_property
    def unsure_way(self) -> FloatArray:
        """(T, p) way along the ground that velocities of the ends of loaded rows leave open [m].

        Half of their change; all of it where they are means, since friction changes with the slip meanwhile,
        and from the row before as well as to the next: a mean lies between its neighbours.
        """
        change = np.diff(self.velocities[..., :2], axis=0, append=self.velocities[-1:, :, :2])
        size = self.dt[:, None] * planar_lengths(change)
        if self.setting.means:
            size[1:] = np.maximum(size[1:], size[:-1].copy())
        else:
            size *= 0.5
        return np.asarray(np.where(self.loaded, size, 0.0))

    @cached_property
    def arms(self) -> FloatArray:
        """(T, p) distances of the contact points from the centre of mass [m]."""
        apart = self.numbers("contact_positions") - self.numbers("com")[:, None]
        return np.asarray(np.sqrt(np.einsum("tpi,tpi->tp", apart, apart)))

    @cached_property
    def force_sizes(self) -> FloatArray:
        """(T, p) [N]."""
        x, y, z = np.moveaxis(self.forces, -1, 0)
        return np.asarray(np.sqrt(x * x + y * y + z * z))

    @cached_property
    def frames(self) -> FloatArray:
        """(T, p, 3, 3) contact frames (rotations) in world axes, from the ground's normals."""
        normals = self.numbers("normals")
        length = np.linalg.norm(normals, axis=-1, keepdims=True)
        return frames_on(np.where(length > 0.5, normals / np.maximum(length, 0.5), [0.0, 0.0, 1.0]))

    @cached_property
    def world_forces(self) -> FloatArray:
        """(T, p, 3) forces in world axes [N]."""
        return np.asarray((self.frames @ self.forces[..., None])[..., 0])

    @cached_property
    def left_over(self) -> FloatArray:
        """(T, 6) wrench about the centre of mass that nothing in the log explains [N, N m], see `balance`.

        Along what holds the root (a planar robot's bearings) it is zero.
        """
        com, facts, force = self.numbers("com"), self.log.facts, self.world_forces
        out = self.numbers("momentum_rate").copy()
        arm = self.numbers("contact_positions") - com[:, None]
        out[:, :3] -= force.sum(axis=1) + self.setting.weight / GRAVITY * np.asarray(
            facts.get("gravity", (0.0, 0.0, -GRAVITY))
        )
        out[:, 3:] -= np.cross(arm, force).sum(axis=1)
        if "contact_moments" in self.log:
            out[:, 3:] -= np.einsum("tpij,tpj->ti", self.frames, self.numbers("contact_moments"))
        if "wrench_applied" in self.log:
            out -= self.numbers("wrench_applied")
        # A planar robot's bearings carry what they like: rows that are not free are projected out.
        free = np.asarray(facts.get("free_wrenches", np.eye(6)))
        return np.asarray(out @ free.T @ free)

    @cached_property
    def unexplained(self) -> UnexplainedForces | None:
        """What Newton-Euler leaves over in every row, NaN where it is not known; None without a robot."""
        robot = self.setting.robot
        if robot is None or self.count < 2:
            return None
        log, time, limits = self.log, self.time, self.setting.limits.records
        arrays = {name: self.numbers(name) for name in _MOTION if name in log}
        clean = Log({**arrays, "time": time}, log.facts, channels=log.channels)
        with np.errstate(all="ignore"):
            world = self.world_forces
            load = self.setting.payload
            mass = self.setting.weight / (GRAVITY * (robot.mass + load))
            place, means = self.setting.payload_position, self.setting.means
            out = unexplained(robot, clean, world, mass, load, place, limits.sticking, means)
        steps, dt = np.diff(time), self.setting.dt
        wrong = ~(steps > limits.known_step_low * dt) | ~(steps < limits.known_step_high * dt)
        wrong |= self.not_finite[:-1].any(axis=1) | self.not_finite[1:, -1]
        parts = (out.force, out.moment, out.feet, out.velocities)
        return UnexplainedForces(*(_with_last(part, wrong) for part in parts))

    @cached_property
    def missing(self) -> FloatArray | None:
        """(T, p, 3) force that the joint torques ask for beyond the logged one, contact frames [N].

        Of feet with one contact point; NaN for others, and where it is not known.
        """
        rest = self.unexplained
        return None if rest is None else self._at_points(rest.feet)

    @cached_property
    def balanced(self) -> FloatArray | None:
        """(T, p, 3) force that the joint torques balance at rest, contact frames [N], see `balanced_forces`.

        Of feet with one contact point, NaN for others; None without a robot or its torques.
        """
        robot = self.setting.robot
        if robot is None or "torques" not in self.log:
            return None
        return self._at_points(
            balanced_forces(robot, Log({name: self.numbers(name) for name in _BALANCE}, self.log.facts))
        )

    def _at_points(self, feet: FloatArray) -> FloatArray:
        """Return forces (T, n, 3) on feet, world axes, in the frames of their contacts: (T, p, 3) [N].

        NaN for the contacts of feet with several.
        """
        out = np.full(self.forces.shape, np.nan)
        for k in filter(self.setting.single, range(self.points)):
            out[:, k] = np.einsum("tji,tj->ti", self.frames[:, k], feet[:, self.setting.owner[k]])
        return out

    @cached_property
    def swinging(self) -> BoolArray:
        """Whether soft contacts may still swing from a hard touchdown of one of them.

        (T, 1) of the robot, (T, p) of several.
        """
        if self.setting.settling <= 0.0 or not self.has("gaps", "contact_velocities"):
            return np.zeros((self.count, 1), dtype=bool)
        settling, limits = self.setting.settling, self.setting.limits.laws
        each = self.points // self.setting.robots
        found = [
            swinging(self.time, self.gaps[:, at], self.velocities[:, at], settling, limits=limits)[0]
            for at in (slice(k, k + each) for k in range(0, self.points, each))
        ]
        return np.asarray(self._spread(np.stack(found, axis=1)))

    def over_robot(self, values: FloatArray | BoolArray, operation: np.ufunc) -> Any:
        """Return (T, p) values of contacts put together for their robot: (T, 1), or (T, p) of several."""
        parts = values.reshape(self.count, self.setting.robots, -1)
        # a robot has few contacts: one whole array after the other, where a reduction goes by fours
        return self._spread(reduce(operation, np.moveaxis(parts, 2, 0)))

    def _spread(self, values: Any) -> Any:
        """Return (T, robots) values at each robot's contacts, (T, p); those of one robot as they are."""
        robots = self.setting.robots
        return values if robots == 1 else np.repeat(values, self.points // robots, axis=1)

    def window(self, seconds: float) -> int:
        """Return how many rows a time [s] has, one at least."""
        dt = self.setting.dt
        return max(1, min(round(seconds / dt), self.count)) if dt > 0.0 else 1


_BALANCE = ("time", "q", "v", "torques", "contact_positions")
_MOTION = ("q", "v", "torques", "push", "other_forces", "contact_positions")


def _with_last(part: FloatArray, wrong: BoolArray) -> FloatArray:
    """Return rows with one of NaN more, NaN where the rows are wrong or too large."""
    out = np.concatenate([part, np.full((1, *part.shape[1:]), np.nan)])
    out[:-1][wrong] = np.nan
    return np.where(np.abs(out) < 1e150, out, np.nan)


def over(value: FloatArray, limit: FloatArray | float) -> Measured:
    """Return a measure (T, c) with its limit and where it exceeds it."""
    bound = np.broadcast_to(limit, value.shape)
    return value, bound, value > bound


def on_body(rows: Rows, value: FloatArray) -> FloatArray:
    """Return (T,) values of the body in the last of p + 1 columns, the contacts' zero."""
    out = np.zeros((rows.count, rows.points + 1))
    out[:, -1] = value
    return out


def pieces(log: Log, setting: Setting, rows: int = PIECE) -> Iterator[Rows]:
    """Yield a log piece by piece; what is mapped is let go of again."""
    for start in range(0, len(log), rows):
        yield Rows(log, setting, start, min(start + rows, len(log)))
        log.let_go()
