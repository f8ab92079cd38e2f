"""From intervals to findings: episodes are cut out of the log, and every symptom is asked about each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from surefoot.records.audit.episode import LONGEST, Episode
from surefoot.records.audit.intervals import Interval
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.audit.log_context import BODY, Setting
from surefoot.records.audit.report import Finding
from surefoot.records.audit.rows import Rows
from surefoot.records.audit.symptoms import SYMPTOMS, Symptom
from surefoot.records.log import Log

MOST_EPISODES = 200
"""Episodes that are looked at, of each contact the first."""
WHOLE = ("no forces", "infeasible", "held rows", "teleport", "other velocities", "velocity jump")
"""What is said of the body and explains what is amiss at the feet at that time."""


def diagnose(log: Log, setting: Setting, found: Sequence[Interval]) -> list[Finding]:
    """Return what explains the intervals of an audit, the strongest first."""
    episodes = _episodes(found, setting)
    count = max(1, MOST_EPISODES // (len(setting.names) + 1))
    out: list[Finding] = []
    for column in sorted({e[0] for e in episodes}):
        mine = [e for e in episodes if e[0] == column][:count]
        for _, first, last, failed in mine:
            shown = min(last + 1, first + LONGEST)
            out += _best(Episode(Rows(log, setting, first, shown), column, failed), last - first + 1)
    return _rank(_join_findings(_not_shadowed(out, setting.limits), setting), setting.limits)


def _episodes(found: Iterable[Interval], setting: Setting) -> list[tuple[int, int, int, dict[str, Interval]]]:
    """Return (column, first row, last row, checks that failed) by time."""
    near = max(1, int(setting.limits.episodes.near / setting.dt)) if setting.dt > 0.0 else 1
    out: list[tuple[int, int, int, dict[str, Interval]]] = []
    latest: dict[int, int] = {}
    for one in sorted(found, key=lambda i: i.first):
        at = latest.get(one.column)
        if at is not None and one.first - out[at][2] <= near:
            column, first, last, failed = out[at]
            known = failed.get(one.check)
            joined = one if known is None else replace(
                one, first=known.first, last=max(known.last, one.last), rows=known.rows + one.rows,
                value=max(known.value, one.value),
            )  # fmt: skip
            out[at] = (column, first, max(last, one.last), {**failed, one.check: joined})
            continue
        latest[one.column] = len(out)
        out.append((one.column, one.first, one.last, {one.check: one}))
    return out


def _best(episode: Episode, rows: int) -> list[Finding]:
    """Return the strongest finding of an episode, or none."""
    speaking = [(found, s) for s in SYMPTOMS if (found := s.evidence(episode)) is not None]
    begun = min(i.first for i in episode.failed.values())
    soon = begun + episode.rows.window(episode.limits.episodes.at_once)

    def late(s: Symptom) -> bool:
        """Return whether it rests on a motion that went wrong after what began the episode: a consequence."""
        return "motion" in s.checks and episode.failed["motion"].first > soon

    speaking.sort(key=lambda t: (late(t[1]), -t[0].strength))
    time, core = episode.rows.time, episode.rows.core
    start = float(time[core.start])
    end = start + rows * episode.rows.setting.dt
    name = BODY if episode.body else episode.rows.setting.names[episode.column]
    return [
        Finding(s.name, name, start, end, found.text, s.cause, s.confirm, s.cure, found.strength)
        for found, s in speaking[:1]
    ]


def _not_shadowed(found: list[Finding], limits: AuditLimits) -> list[Finding]:
    """Leave out what is said of the body while a foot's wrong force explains it, and the other way round."""
    whole = [f for f in found if f.contact == BODY and f.name in WHOLE]
    feet = [f for f in found if f.contact != BODY]
    out, near = [], limits.episodes.near
    for one in found:
        others = feet if one.contact == BODY else whole
        shadowed = any(o.start - near <= one.end and one.start <= o.end + near for o in others)
        if not shadowed or one in whole or one.strength >= limits.ranks.certain:
            out.append(one)
    return out


def _join_findings(found: list[Finding], setting: Setting) -> list[Finding]:
    """Return one finding where (nearly) all contacts have the same at the same time."""
    out: list[Finding] = []
    all_from = setting.limits.episodes.all * len(setting.names)
    for one in found:
        same = [f for f in found if f.name == one.name and f.start <= one.end and one.start <= f.end]
        contacts = {f.contact for f in same}
        if len(setting.names) < 2 or len(contacts) < all_from or one.contact == BODY:
            out.append(one)
            continue
        strongest = max(same, key=lambda f: f.strength)
        joined = replace(
            strongest, contact="all", start=min(f.start for f in same), end=max(f.end for f in same)
        )
        if not any(f.contact == "all" and f.name == one.name and f.start <= joined.end for f in out):
            out.append(joined)
    return out


def _rank(found: list[Finding], limits: AuditLimits) -> list[Finding]:
    """Return the strongest first, of all contacts before one; equally strong ones by time.

    Joints come to their stops when a robot falls: what went wrong before comes first.
    """
    begun, ranks = min((f.start for f in found), default=0.0), limits.ranks

    def key(f: Finding) -> tuple[bool, bool, float, float]:
        follows = f.name == "joint stop" and f.start > begun + limits.episodes.near
        shared = ranks.shared * (f.contact == "all")
        return follows, f.strength < ranks.certain, -f.strength - shared, f.start

    return sorted(found, key=key)
