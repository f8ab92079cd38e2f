"""Rows of contacts that are proven lawful before any log is made of them; see `proof_of_rows`.

Of worlds whose soft friction is known row by row (`contact_creep`), as MuJoCo's is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.batch import proof_of_rows as proof
from surefoot.records.audit.batch import row_limits
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.exploits import EXPLOITS, Exploit, find_exploits
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.batch.one_log import clear_laws
from surefoot.records.audit.batch.signs_in_rows import SIGN_THROW, SIGNS, start_signs
from surefoot.records.audit.coverage import NEVER_LOADED
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.log_context import softness_doubts
from surefoot.records.audit.report import Judgement
from surefoot.records.audit.rows import PIECE
from surefoot.records.audit.slides import start_slides


class ContactRows(NamedTuple):
    """Rows of an episode's contacts, in contact axes.

    Attributes
    ----------
    table, used
        (T, contacts, fields), and which contacts (k,) are looked at.
    columns
        (6,) where in the fields force [N] and velocity [m/s] begin, then gap [m], friction, turn of friction
        pyramids [rad], or -1 for round cones, and R f_t of soft friction [m/s²].
    times
        (T, 2) start and length of each row [s].
    """

    table: FloatArray
    used: IntArray
    columns: IntArray
    times: FloatArray


class ContactWorld(NamedTuple):
    """The world of an episode's contacts.

    Attributes
    ----------
    damping, damped
        (k,) rate at which soft friction brakes [1/s], 0 for none; 1 for contacts that are critically damped.
    margins
        (k,) gaps from which contacts push [m].
    mass, gravity
        Of the robot [kg], of the world [m/s²].
    settling
        How long soft contacts swing [s].
    recoil
        Speed at which a loaded contact comes out of the ground at most, over its depth [1/s].
    means
        Whether velocities are means over the rows.
    """

    damping: FloatArray
    damped: FloatArray
    margins: FloatArray
    mass: float
    gravity: float
    settling: float
    recoil: float
    means: bool


class ContactProof:
    """Figures of an episode's rows, and the report of those that break no law.

    Parameters
    ----------
    rows, world
        What is judged.
    limits
        What is judged by.

    Attributes
    ----------
    deepest
        Depth [m].
    fastest, row, contact
        Highest speed of a touchdown along the normal [m/s], its row, and which of `used`.
    across, touched
        Highest speed of a touchdown across the normal [m/s], and greatest depth in the first row of one [m].
    held
        Laws that `report` has proven to hold, where it could not prove all.
    """

    def __init__(self, rows: ContactRows, world: ContactWorld, limits: AuditLimits = LIMITS) -> None:
        self._rows, self._world, self._limits = rows, world, limits
        self._weight = world.mass * GRAVITY
        time, self._dt = np.ascontiguousarray(rows.times.T)
        self._swings, found = np.zeros(len(time), dtype=np.int64), np.zeros(9)
        proof.read_figures(
            rows.table, rows.used, rows.columns, time, world.damping, limits.laws.loaded * self._weight,
            limits.laws.hard_touchdown, world.settling, world.means, self._swings, found,
        )  # fmt: skip
        self.deepest, self._loaded = float(found[proof.DEEPEST]), bool(found[proof.LOADED])
        self._crept = float(found[proof.CREPT] / found[proof.LOAD]) if found[proof.LOAD] > 0.0 else 0.0
        self.fastest, self.row = float(found[proof.FASTEST]), int(found[proof.FAST_ROW])
        self.contact, self.across = int(found[proof.FAST_CONTACT]), float(found[proof.ACROSS])
        self.touched = float(found[proof.TOUCHED])
        self.held: frozenset[str] = frozenset()

    def report(
        self, sinking: float, creep: float, stopping: float, unsure: str = "",
        reward: Callable[[], FloatArray | None] = lambda: None,
    ) -> BatchReport | None:  # fmt: skip
        """Return the report of the rows; None where it is not proven that they break no law.

        Parameters
        ----------
        sinking, creep, stopping
            What the world declares of its softness [m], [m/s], [m]; `sinking` may be less.
        unsure
            Why rows that break no law are not called lawful; empty for lawful ones.
        reward
            Gives what each row was paid (T,), None for nothing; asked where a sign is found in them.
        """
        (table, used, columns, _), world = self._rows, self._world
        rows, dt = len(self._dt), float(self._dt[0])
        if not (self._dt == dt).all() or self.deepest > self._limits.softness.sinking:
            return None  # so deep that what is declared of it may hide anything
        soft = sinking, creep, stopping
        if (world.margins > self._limits.softness.sinking).any() or (world.margins < 0.0).any():
            return None  # pushed from afar, or from below: the audit knows of both
        bounds = row_limits.limits_of(
            self._limits, self._weight, world.gravity, dt, world.means, soft, world.recoil
        )
        (signs, marks), states = start_signs(rows), start_slides(len(used), self._limits.laws)
        margins = np.maximum(world.margins, 0.0)
        open_ = proof.rows_hold(
            table, used, columns, self._dt, self._swings, world.damping, world.damped, margins,
            bounds.numbers, bounds.how, bounds.slides, states, signs, marks,
        )  # fmt: skip
        if marks[SIGN_THROW].any() and (open_ or rows > PIECE):
            open_ |= row_limits.THROWS  # the audit tells it, and looks at pieces
        if open_:
            held = (
                ()
                if open_ == row_limits.ALL_LAWS
                else (n for bit, n in row_limits.NAMES.items() if not open_ & bit)
            )
            self.held = frozenset(name for names in held for name in names)
            return None
        most = self._limits.softness
        # as for a log whose soft friction is known row by row
        told = (0.0, self._crept, min(stopping, most.stopping), world.settling)
        hidden = self._crept > most.creep or world.settling > most.settling
        reason = next(softness_doubts(told, self._limits), "") if hidden else ""
        least = self._limits.records.least_rows
        if not reason and rows < least:
            reason = f"{rows} rows are too few, {least} are the least"
        reason = reason or ("" if self._loaded else NEVER_LOADED) or unsure
        if not marks.any():
            return _report(rows, dt, reason, clear_laws(), (), self._limits)
        found = _laws_of_signs(signs, marks, dt)
        exploits = find_exploits(found, _paid(marks, reward()))
        return _report(rows, dt, reason, clear_laws() | found, exploits, self._limits)


def _laws_of_signs(signs: FloatArray, marks: BoolArray, dt: float) -> dict[str, LawFound]:
    """Return what is told of the signs that are found, see `start_signs`."""
    out, laws = {}, clear_laws()
    for name, (worst, limit, row, contact), rows in zip(SIGNS, signs, marks, strict=True):
        if rows.any():
            out[name] = replace(
                laws[name], share=np.full(1, rows.mean()), worst=np.full(1, worst),
                limit=np.full(1, limit), instant=np.full(1, dt * row), contact=np.full(1, int(contact)),
            )  # fmt: skip
    return out


def _paid(marks: BoolArray, reward: FloatArray | None) -> dict[str, float]:
    """Return the share of the reward that came from the rows of each exploit that signs show."""
    total = 0.0 if reward is None else float(np.nansum(reward))
    if reward is None or total == 0.0:
        return {}
    paid = dict(zip(SIGNS, [float(reward[rows].sum()) / total for rows in marks], strict=True))
    return {name: paid[check] for name, checks in EXPLOITS.items() for check in checks if check in paid}


def _report(
    rows: int, dt: float, reason: str, laws: dict[str, LawFound], exploits: tuple[Exploit, ...],
    limits: AuditLimits,
) -> BatchReport:  # fmt: skip
    """Return the report of rows that break no law; it keeps no log."""
    verdict: Judgement = "cannot tell" if reason else "lawful"
    return BatchReport((verdict,), (reason,), dict(laws), exploits, {}, (), 1, rows, dt, {}, limits)
