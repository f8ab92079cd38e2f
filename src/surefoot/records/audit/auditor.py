"""The audit of a log: every law over time, what the signs point at, and one verdict."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot
from surefoot.records.audit.checks import CHECKS, Check
from surefoot.records.audit.command_tracking import judge_command, judge_task
from surefoot.records.audit.coverage import coverage_of, why_unsure
from surefoot.records.audit.diagnosis import diagnose
from surefoot.records.audit.friction import FrictionCount
from surefoot.records.audit.intervals import Interval, Track
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.audit.log_context import Setting, setting_of
from surefoot.records.audit.report import (
    MASSES,
    TOPICS,
    AuditReport,
    FrictionInterval,
    Judgement,
    LawBroken,
    Violation,
)
from surefoot.records.audit.resets import join_episodes
from surefoot.records.audit.rows import Rows, lacking, pieces
from surefoot.records.audit.slide_count import SlideCount
from surefoot.records.audit.story.story import story_of
from surefoot.records.audit.summary.motor_summary import limits_broken, motor_use
from surefoot.records.log import Log
from surefoot.records.log.plausibility import load_doubts
from surefoot.records.log.reading import read_log

FINITE, CLOCK = "finite", "clock"
"""What is asked of the log itself before any law: numbers that are finite, and time that goes on."""
_FAULTS = (FINITE, CLOCK)


def audit_log(log: Log | Path | str, robot: Robot | None = None, limits: AuditLimits = LIMITS) -> AuditReport:
    """Judge every law of contact over a log, in bounded memory.

    Parameters
    ----------
    log
        A log, or the path of one. What can be judged depends on its channels; ``forces`` alone tell of
        pulls, with ``gaps``, ``contact_velocities`` and ``mu`` all laws of contact can be judged, with
        ``q``, ``v`` and ``normals`` whether the forces explain the motion.
    robot
        Whose log it is; None for the robot that it names.
    limits
        What the log is judged by; the report keeps it.

    Returns
    -------
    AuditReport
        `.verdict`, `.violations`, `.symptoms`, `.coverage`, `.friction`. Never "lawful" where numbers are
        not finite, time stands still or runs back, the log contradicts itself, or the laws of
        `coverage.NEEDED` could not be judged. A log with several episodes (its state was reset) is judged
        episode by episode, `.episodes`; its verdict is the worst.

    Raises
    ------
    ProblemError
        For what is no log, has no rows, or tells facts that cannot be.
    """
    if not isinstance(log, (Log, str, Path)):
        raise ProblemError(
            f"audit_log takes an sf.Log or the path of one; arrays become one by sf.log_from_arrays, "
            f"got {type(log).__name__}"
        )
    if not isinstance(log, Log):
        log = read_log(log)
    if len(episodes := log.episodes) > 1:
        return join_episodes(log, [audit_log(one, robot, limits) for one in episodes])
    setting = setting_of(log, robot, limits)
    coverage = coverage_of(log, setting)
    used = [check for check in CHECKS if check.applies(log) and not coverage.get(check.name, "")]
    used = [check for check in used if check.law or not (lacking(log, check.needs) or not setting.names)]
    join = max(1, round(limits.records.join / setting.dt)) if setting.dt > 0.0 else 1
    tracks = {name: Track(name, join) for name in (*_FAULTS, *(check.name for check in used))}
    friction, slides, last = FrictionCount(setting), SlideCount(setting), -np.inf
    for rows in pieces(log, setting):
        last = _faults(rows, tracks, last)
        if setting.names or used:
            with np.errstate(over="ignore", invalid="ignore"):
                _measure(rows, used, tracks)
                if setting.names:
                    friction.add(rows)
                if "dissipation" in tracks:
                    slides.add(rows)
    if "dissipation" in tracks:
        _slow_slides(slides, tracks["dissipation"], len(log))
    return _report(log, setting, coverage, tracks, friction)


def assert_lawful(log: Log | Path | str, robot: Robot | None = None, symptoms: bool = False) -> AuditReport:
    """Audit a log and raise unless it is lawful and its task did not fail; for tests.

    Parameters
    ----------
    log, robot
        See `audit_log`.
    symptoms
        Whether symptoms that break no law (chatter, blows of one step, ...) fail as well.

    Raises
    ------
    LawBroken
        An AssertionError whose text is the verdict, the symptoms with their causes, and the violations.
    ProblemError
        See `audit_log`.
    """
    report = audit_log(log, robot)
    if not report.passed or (symptoms and report.symptoms):
        raise LawBroken(report)
    return report


def _faults(rows: Rows, tracks: dict[str, Track], before: float) -> float:
    """Track what is wrong with the log itself, and return the last time stamp."""
    first, core = rows.first + rows.core.start, rows.core
    lost = rows.not_finite[core]
    if lost.any():
        tracks[FINITE].add(lost, lost.astype(np.float64), np.zeros(lost.shape), first)
    time = rows.time[core]
    step = np.diff(time, prepend=before if np.isfinite(before) else time[:1] - rows.setting.dt)
    bad = ~(step > 0.0) | ~np.isfinite(time)
    if rows.setting.dt > 0.0:
        bad |= step > rows.setting.limits.records.missing_step * rows.setting.dt
    if bad.any():
        tracks[CLOCK].add(
            bad[:, None], step[:, None], np.full((len(step), 1), rows.setting.dt), first, rows.points
        )
    return float(time[-1])


def _measure(rows: Rows, used: list[Check], tracks: dict[str, Track]) -> None:
    """Track every check in a piece."""
    first = rows.first + rows.core.start
    for check in used:
        value, limit, bad = check.judge(rows)
        if bad.any():
            tracks[check.name].add(bad, value, limit, first)


def _slow_slides(slides: SlideCount, track: Track, rows: int) -> None:
    """Track the contacts that slid too far without friction, too slowly for a window to show."""
    seen = {i.column for i in track.kept}
    for column, (way, limit) in enumerate(zip(slides.ways.tolist(), slides.limits.tolist(), strict=True)):
        if way > limit and column not in seen:
            track.kept.append(Interval(track.check, column, 0, rows - 1, way, limit, rows))


def _report(
    log: Log, setting: Setting, coverage: dict[str, str], tracks: dict[str, Track], friction: FrictionCount
) -> AuditReport:
    time = log["time"]
    titles = {check.name: check for check in CHECKS}
    laws = {name for name, check in titles.items() if check.law} | set(_FAULTS)
    found: list[Interval] = [i for track in tracks.values() for i in track.kept]
    physical = [i for i in found if i.check not in _FAULTS]
    violations = tuple(
        Violation(
            i.check, setting.columns[i.column], float(time[i.first]),
            float(time[i.last]) + setting.dt, i.value, i.limit,
            titles[i.check].unit if i.check in titles else ("places" if i.check == FINITE else "s"),
        )
        for i in sorted(found, key=lambda i: (i.first, i.column)) if i.check in laws
    )  # fmt: skip
    more = {t.check: t.dropped for t in tracks.values() if t.dropped and t.check in laws}
    broken = any(v.law not in _FAULTS for v in violations)
    verdict: Judgement = "lawful"
    reason = "" if broken else str(violations[0]) if violations else why_unsure(log, setting, coverage)
    if broken:
        verdict = "broken"
    elif reason:
        verdict = "cannot tell"
    symptoms = tuple(diagnose(log, setting, physical)) if physical else ()
    intervals = friction.intervals()
    task, task_reason = judge_task(log, setting.limits)
    blind = all(coverage[law] for law in TOPICS[MASSES])
    doubt = next(load_doubts(log), "") if blind and setting.names else ""
    told = [f"doubt: {doubt}"] if doubt and doubt not in log.doubts else []
    return AuditReport(
        verdict, violations, more, symptoms, coverage, intervals,
        (*setting.doubts, *told, *setting.notes, *_changes(intervals)), len(log), float(time[0]),
        float(time[-1]), setting.names, setting.weight, reason, task, task_reason,
        tuple(judge_command(log, setting)), setting.limits, story_of(log, setting, symptoms, task_reason),
        log, tuple(limits_broken(log, motor_use(log, setting.limits)) or ()), load_doubt=doubt,
    )  # fmt: skip


def _changes(intervals: tuple[FrictionInterval, ...]) -> Iterator[str]:
    """Yield a line for each change of the ground's friction under a foot."""
    for one, two in pairwise(intervals):
        if one.contact == two.contact:
            how = "rises" if two.low > one.high else "falls"
            yield (
                f"the ground's friction under {one.contact} {how} at {two.start:.2f} s: {one.words} before, "
                f"{two.words} after"
            )
