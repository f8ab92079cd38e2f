"""The laws of a single log's contacts alone, for whoever audits thousands of short logs one after another."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import cache

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.exploits import EXPLOITS, find_exploits
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.batch.side_by_side import (
    SIDE_BY_SIDE,
    Found,
    reasons_of,
    reward_shares,
    start_found,
    take_found,
    take_slides,
)
from surefoot.records.audit.coverage import coverage_of
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.log_context import Setting, setting_of
from surefoot.records.audit.report import Judgement
from surefoot.records.audit.rows import PIECE, Rows, lacking, pieces
from surefoot.records.audit.slide_count import SlideCount
from surefoot.records.log import Log

JUDGED = (
    "time", "forces", "gaps", "contact_velocities", "contact_friction", "mu", "contact_creep",
    "pyramid_turn", "contact_moments",
)  # fmt: skip
"""Channels that are looked at. Places and normals would tell whether a log contradicts itself."""
TOLD = tuple(
    check for check in SIDE_BY_SIDE if check.law or any(check.name in how for how in EXPLOITS.values())
)
"""Laws, and signs that are an exploit's."""
UNTOUCHED = "nothing ever touches"
ROUNDED = 1.0 - 1e-9
"""Bounds are kept by more than sums of other order differ."""


def judge_contacts(
    log: Log, limits: AuditLimits = LIMITS, reward: FloatArray | None = None, unsure: str = "",
    held: Collection[str] = (),
) -> BatchReport:  # fmt: skip
    """Judge the laws that look at contacts alone over one log, as `audit_log` does.

    The report is that of one environment and keeps the log. What a whole audit also does (laws of the motion,
    symptoms, causes, contradictions of the log) is left out; the worst of a law is told where it is broken.

    Parameters
    ----------
    log
        Of one episode.
    limits
        What it is judged by.
    reward
        (T,) of each row: exploits then say which share of it came from their rows.
    unsure
        Why an episode that breaks no law is not called lawful; empty for none.
    held
        Laws that are known to hold, and not looked at.
    """
    seen = Log({name: log[name] for name in JUDGED if name in log}, log.facts, channels=log.channels)
    setting = setting_of(seen, None, limits)
    coverage = coverage_of(seen, setting)
    found = _judge(seen, setting, coverage, None if reward is None else reward[:, None], held)
    rows, instants = found.rows[0], np.asarray(setting.dt * found.row, dtype=np.float64)
    laws = {
        check.name: LawFound(
            check.name, check.unit, check.law, found.rows[:, c] / len(log), found.value[:, c],
            found.limit[:, c], instants[:, c], found.contact[:, c],
        )
        for c, check in enumerate(SIDE_BY_SIDE)
    }  # fmt: skip
    broken = any(check.law and rows[c] for c, check in enumerate(SIDE_BY_SIDE))
    reason = "" if broken else found.reasons[0] or unsure
    verdict: Judgement = "broken" if broken else "cannot tell" if reason else "lawful"
    known = {law: why for law, why in coverage.items() if why and law in laws}
    exploits = find_exploits(laws, reward_shares(found, reward)) if rows.any() else ()
    return BatchReport(
        (verdict,), (reason,), laws, exploits, known, setting.notes, 1, len(log), setting.dt, {0: log}, limits
    )


def _judge(
    log: Log, setting: Setting, coverage: dict[str, str], reward: FloatArray | None, held: Collection[str]
) -> Found:
    """Return what breaks a law, or shows an exploit, as `judge_log` does."""
    found, slides = start_found(1, coverage), SlideCount(setting)
    used = [c for c in TOLD if not coverage.get(c.name, "") and not lacking(log, c.needs)]
    may_slide, loaded, lost = False, np.zeros(1, dtype=bool), np.zeros(1, dtype=bool)
    sliding, whole = any(check.name == "dissipation" for check in used), len(log) <= PIECE
    for rows in pieces(log, setting):
        loaded |= rows.loaded[rows.core].any()
        lost |= rows.not_finite[rows.core].any()
        with np.errstate(over="ignore", invalid="ignore"):
            safe = laws_that_hold(rows).union(held)
            may_slide |= "dissipation" not in safe
            for check in used:
                if check.name not in safe and check.judge(rows)[2].any():
                    take_found(found, check, rows, rows.first + rows.core.start, reward)
            if sliding and (may_slide or not whole):
                slides.add(rows)
    if sliding and may_slide:
        take_slides(found, slides, len(log))
    return replace(found, reasons=reasons_of(setting, coverage, len(log), loaded, lost))


def laws_that_hold(rows: Rows) -> set[str]:
    """Return checks that cannot find anything in some rows, by bounds that are cheaper than the checks.

    A window's way is no longer than that of all rows, its work no more than all that was ever positive.
    """
    setting, out = rows.setting, set[str]()
    limits, weight = setting.limits, setting.weight
    deep = max(limits.laws.penetration, setting.sinking)
    if rows.has("gaps"):
        gaps = rows.gaps
        if -gaps.min(initial=0.0) <= deep:
            out.add("penetration")
        pushed = np.maximum(np.abs(rows.normal), rows.tangential) > setting.threshold
        if gaps.max(initial=0.0, where=pushed) <= deep:
            out.add("distance")
    if rows.normal.min(initial=0.0) >= -limits.laws.pull * weight:
        out.add("pull")
    if np.abs(rows.forces).max(initial=0.0) * np.sqrt(3.0) <= limits.checks.spike * weight:
        out.add("spike")
    if rows.has("contact_velocities") and not rows.not_finite.any():
        f, v = rows.forces, np.where(rows.loaded[..., None], rows.velocities[..., :2], 0.0)
        dt = rows.dt[:, None]
        if (dt * np.hypot(v[..., 0], v[..., 1])).sum(axis=0).max(
            initial=0.0
        ) <= ROUNDED * setting.slide_limit:
            out.add("dissipation")
        work = dt * np.maximum(f[..., 0] * v[..., 0] + f[..., 1] * v[..., 1], 0.0)
        late = limits.laws.slide + 2.0 * setting.stopping
        if work.sum(axis=0).max(initial=0.0) <= ROUNDED * limits.checks.drive_share * late * weight:
            out.add("work")
        up = np.maximum(rows.velocities[..., 2], 0.0)
        up[1:], up[:-1] = np.maximum(up[1:], up[:-1]), np.maximum(up[1:], up[:-1])
        given = (dt * np.maximum(rows.normal, 0.0) * up).sum(axis=0)
        if given.max(initial=0.0) <= ROUNDED * limits.rebound.way * weight:
            out.add("restitution")
    return out


def report_no_touch(rows: int, dt: float, limits: AuditLimits = LIMITS) -> BatchReport:
    """Return the report of rows, dt apart [s], in which nothing touches: no law is shown to hold."""
    laws = dict(clear_laws())
    return BatchReport(("cannot tell",), (UNTOUCHED,), laws, (), {}, (), 1, rows, dt, {}, limits)


@cache
def clear_laws() -> dict[str, LawFound]:
    """Return what is told of laws that are not broken."""
    unknown, zero, first = np.full(1, np.nan), np.zeros(1), np.zeros(1, dtype=np.int64)
    return {
        check.name: LawFound(check.name, check.unit, check.law, zero, unknown, unknown, zero, first)
        for check in SIDE_BY_SIDE
    }
