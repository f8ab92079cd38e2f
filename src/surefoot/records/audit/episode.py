"""An episode: what went wrong at one contact over a time, and everything that was measured there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.checks import CHECKS
from surefoot.records.audit.intervals import Interval
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.audit.rows import Rows

LONGEST = 4000
"""Rows of a long episode that are looked at: its first."""


@dataclass(frozen=True)
class Episode:
    """What a symptom is judged from.

    Attributes
    ----------
    rows
        The log about it; `rows.core` is the episode.
    column
        Contact, or the number of contacts for the body.
    failed
        Name to interval of the laws and signs that failed here.
    """

    rows: Rows
    column: int
    failed: dict[str, Interval]

    @property
    def body(self) -> bool:
        """Whether it is about the robot as a whole."""
        return self.column == self.rows.points

    def has(self, *checks: str) -> bool:
        """Return whether all of these failed."""
        return all(name in self.failed for name in checks)

    @property
    def breaks(self) -> bool:
        """Whether a law is broken here."""
        return any(check.law and check.name in self.failed for check in CHECKS)

    @property
    def limits(self) -> AuditLimits:
        """What the log is judged by."""
        return self.rows.setting.limits

    @property
    def weight(self) -> float:
        """M g [N]."""
        return self.rows.setting.weight

    @cached_property
    def force(self) -> FloatArray:
        """(m, 3) logged force of the contact, contact frame [N]."""
        return self.rows.forces[self.rows.core, self.column]

    @cached_property
    def true(self) -> FloatArray | None:
        """(m, 3) force that the joint torques ask for, contact frame [N]; None where that is unknown."""
        return self.true_of(self.column)

    def true_of(self, column: int) -> FloatArray | None:
        """Return the force (m, 3) [N] that joint torques ask of any contact, see `true`."""
        whole = self.whole_true(column)
        if whole is None:
            return None
        part = whole[self.rows.core]
        return part if np.isfinite(part).all(axis=1).mean() > self.limits.episodes.known else None

    def whole_true(self, column: int) -> FloatArray | None:
        """Return the same at every row of `rows`, the surroundings of the episode with it: (T, 3) [N]."""
        missing = self.rows.missing
        return None if missing is None else self.rows.forces[:, column] + missing[:, column]

    @cached_property
    def gap(self) -> FloatArray:
        """(m,) gap of the contact [m]; zero where the log has none."""
        if not self.rows.has("gaps"):
            return np.zeros(len(self.force))
        return self.rows.gaps[self.rows.core, self.column]

    @cached_property
    def velocity(self) -> FloatArray:
        """(m, 3) of the contact [m/s]; zero where the log has none."""
        if not self.rows.has("contact_velocities"):
            return np.zeros((len(self.force), 3))
        return self.rows.velocities[self.rows.core, self.column]

    @cached_property
    def dt(self) -> FloatArray:
        """(m,) [s]."""
        return self.rows.dt[self.rows.core]

    @cached_property
    def mu(self) -> FloatArray:
        """(m,) friction of the ground [-]; infinite where the log has none."""
        if not self.rows.has("mu"):
            return np.full(len(self.force), np.inf)
        mu = self.rows.mu[self.rows.core]
        return mu[:, min(self.column, mu.shape[1] - 1)]

    @cached_property
    def loaded(self) -> BoolArray:
        """(m,) where it is loaded."""
        return self.rows.loaded[self.rows.core, self.column]

    @cached_property
    def static(self) -> bool:
        """Whether nothing at all changes: a solution of statics, and no sensor that repeats itself."""
        forces = self.rows.forces[self.rows.core]
        least = self.limits.episodes.at_rest
        rests = "v" not in self.rows.log or float(np.abs(self.rows.numbers("v")).max(initial=0.0)) < least
        return rests and bool((forces == forces[:1]).all())

    @cached_property
    def impact(self) -> bool:
        """Whether the largest force is the blow of a landing: no more than its momentum twice over."""
        k = int(np.argmax(np.linalg.norm(self.force, axis=1)))
        speed = float(np.linalg.norm(self.velocity[max(k - 2, 0) : k + 1], axis=1).max())
        blow = float(np.linalg.norm(self.force[k])) * float(self.dt[k])
        return blow <= self.limits.episodes.landing * self.weight / GRAVITY * speed

    @cached_property
    def consistent(self) -> bool:
        """Whether the joint torques are known and agree with the logged forces here."""
        return self.true is not None and not self.has("motion")

    @cached_property
    def sideways(self) -> bool:
        """Whether what is amiss with the force lies across the normal, as far as is known."""
        true = self.true
        if true is None:
            return True
        off = np.nan_to_num(self.force - true)
        share = self.limits.episodes.sideways
        return bool((off[:, 2] ** 2).sum() <= share * (off**2).sum() or self.consistent)

    def share_explained(self, model: FloatArray) -> float:
        """Return the share of the mismatch between logged and true force that a model (m, 3) [N] explains."""
        true = self.true
        if true is None:
            return 0.0
        logged = self.force
        known = np.isfinite(true).all(axis=1) & np.isfinite(model).all(axis=1)
        amiss = float(((logged - true)[known] ** 2).sum())
        if amiss <= (self.limits.episodes.amiss * self.weight) ** 2 * max(int(known.sum()), 1):
            return 0.0
        return 1.0 - float(((logged - model)[known] ** 2).sum()) / amiss
