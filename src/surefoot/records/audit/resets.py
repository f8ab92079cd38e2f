"""The audit of a log whose state was reset: every episode is judged alone, and the worst is the verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from surefoot.records.audit.report import AuditReport, Judgement, Task
from surefoot.records.audit.story.told import Story
from surefoot.records.log import Log

SEVERITY: dict[Judgement, int] = {"broken": 0, "cannot tell": 1, "lawful": 2}


def join_episodes(log: Log, reports: Sequence[AuditReport]) -> AuditReport:
    """Return one report of all episodes.

    Parameters
    ----------
    log
        The whole.
    reports
        Of its episodes, in their order. One with fewer rows than `least_rows` that breaks no law has nothing
        to say, as long as another has.
    """
    long = [one for one in reports if one.rows >= one.limits.records.least_rows or one.verdict == "broken"]
    worst = min(long or reports, key=lambda one: SEVERITY[one.verdict])
    number = next(k for k, one in enumerate(reports, 1) if one is worst)
    tasks = {one.task for one in reports}
    task: Task = "failed" if "failed" in tasks else "attained" if tasks == {"attained"} else "unknown"
    more: Counter[str] = Counter()
    coverage: dict[str, str] = {}
    for one in long or reports:
        more.update(one.more)
        coverage |= {name: why for name, why in one.coverage.items() if not coverage.get(name)}
    return AuditReport(
        verdict=worst.verdict,
        violations=tuple(found for one in reports for found in one.violations),
        more=dict(more),
        symptoms=tuple(sorted((s for one in reports for s in one.symptoms), key=lambda s: -s.strength)),
        coverage=coverage,
        friction=tuple(found for one in reports for found in one.friction),
        notes=(*_lines(reports), *dict.fromkeys(note for one in reports for note in one.notes)),
        rows=len(log),
        start=reports[0].start,
        end=reports[0].start + sum(one.end - one.start for one in reports),
        contacts=reports[0].contacts,
        weight=reports[0].weight,
        reason=f"episode {number} of {len(reports)}: {worst.reason}" if worst.reason else "",
        task=task,
        task_reason=next((one.task_reason for one in reports if one.task == task), ""),
        command=tuple(found for one in reports for found in one.command),
        limits=worst.limits,
        story=_story_of(reports, worst),
        log=log,
        limits_broken=tuple(dict.fromkeys(line for one in reports for line in one.limits_broken)),
        episodes=tuple(reports),
        load_doubt=next((one.load_doubt for one in reports if one.load_doubt), ""),
    )


def _story_of(reports: Sequence[AuditReport], worst: AuditReport) -> Story:
    """Return the story of the first episode that failed for a cause, that has one, or that failed."""
    stories = [one.story for one in reports]
    told = (
        next((x for x in stories if x.failure is not None and x.causes), None),
        next((x for x in stories if x.causes), None),
        next((x for x in stories if x.failure is not None), None),
    )
    return next((x for x in told if x is not None), worst.story)


def _lines(reports: Sequence[AuditReport]) -> list[str]:
    """Return a line for each episode."""
    out, first = [], 0
    for number, one in enumerate(reports, 1):
        out.append(f"episode {number} (rows {first} to {first + one.rows - 1}): {one.sentence}")
        first += one.rows
    return out
