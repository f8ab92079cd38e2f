"""Reports of one stretch of steps after another as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.exploits import find_exploits
from surefoot.records.audit.batch.law_found import LawFound
from surefoot.records.audit.report import Judgement
from surefoot.records.audit.resets import SEVERITY
from surefoot.records.log import Log

KEPT = 3
"""Environments whose rows are kept, the worst of all stretches."""


def join_reports(reports: Sequence[BatchReport]) -> BatchReport:
    """Return one report of the same environments over stretches of time, in their order.

    A verdict is the worst of its stretches'. Stretches with fewer rows than `least_rows`, that break no law,
    have nothing to say where another has.
    """
    if len(reports) == 1:
        return reports[0]
    starts = np.append(0.0, np.cumsum([one.dt * one.rows for one in reports[:-1]]))
    laws = {name: _law([one.laws[name] for one in reports], reports, starts) for name in reports[0].laws}
    least = reports[0].limits.records.least_rows
    verdicts: list[Judgement] = []
    reasons: list[str] = []
    for k in range(len(reports[0])):
        told = [one for one in reports if one.rows >= least or one.verdicts[k] == "broken"] or list(reports)
        worst = min(told, key=lambda one: SEVERITY[one.verdicts[k]])
        verdicts.append(worst.verdicts[k])
        reasons.append(worst.reasons[k])
    coverage: dict[str, str] = {}
    for one in reports:
        coverage = {**one.coverage, **coverage}
    return replace(
        reports[0], verdicts=tuple(verdicts), reasons=tuple(reasons), laws=laws,
        exploits=find_exploits(laws, {}), coverage=coverage,
        notes=tuple(dict.fromkeys(note for one in reports for note in one.notes)),
        episodes=sum(one.episodes for one in reports), rows=sum(one.rows for one in reports),
        kept=_worst_logs(reports),
    )  # fmt: skip


def _worst_logs(reports: Sequence[BatchReport]) -> dict[int, Log]:
    """Return the kept logs of the environments that break laws in most of their stretch's rows."""
    shares = [np.max([one.share for one in report.laws.values() if one.law], axis=0) for report in reports]
    found = [
        (float(share[k]), k, log)
        for share, report in zip(shares, reports, strict=True)
        for k, log in report.kept.items()
    ]
    out: dict[int, Log] = {}
    for _, k, log in sorted(found, key=lambda one: -one[0]):
        if len(out) < KEPT:
            out.setdefault(k, log)
    return out


def _law(found: Sequence[LawFound], reports: Sequence[BatchReport], starts: FloatArray) -> LawFound:
    """Return what a law found over all stretches, which begin at times (n,) [s]."""
    rows = np.array([one.rows for one in reports], dtype=np.float64)
    share = (rows[:, None] * [one.share for one in found]).sum(axis=0) / rows.sum()
    over = np.array([np.where(np.isnan(one.worst), -np.inf, one.worst - one.limit) for one in found])
    which, every = over.argmax(axis=0), np.arange(over.shape[1])
    instants = np.array([one.instant for one in found]) + starts[:, None]

    def worst(name: str) -> Any:
        return np.array([getattr(one, name) for one in found])[which, every]

    return replace(
        found[0], share=share, worst=worst("worst"), limit=worst("limit"), contact=worst("contact"),
        instant=instants[which, every],
    )  # fmt: skip
