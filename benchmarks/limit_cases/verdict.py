"""A case: a verdict that is right or not, and the ways to ask an audit for one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from surefoot.mechanics import Robot
from surefoot.records.audit import AuditReport, audit_log
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.log import Log

CleanLogs = Callable[[int], Log]
"""From a number to the log of that one of `clean_runs`; it must not be written to."""
TROT, STAND, SLOPE = 10, 11, 13
"""Numbers of the clean runs in which a Go2 trots, stands, and stands on a slope, in the rigid world."""


@dataclass(frozen=True)
class Verdict:
    """A case.

    Attributes
    ----------
    name
        What is judged.
    why
        Where its size is from.
    right
        From limits to whether what is said with them is right.
    """

    name: str
    why: str
    right: Callable[[AuditLimits], bool]


def audited(
    name: str, why: str, log: Log, right: Callable[[AuditReport], bool], robot: Robot | None = None
) -> Verdict:
    """Return the case of an audit of a log, of a robot or of the one that it names."""
    return Verdict(name, why, lambda limits: right(audit_log(log, robot, limits)))


def clean(name: str, why: str, log: Log) -> Verdict:
    """Return the case of a log that is lawful, without any symptom or finding about its command."""
    return audited(name, why, log, lambda r: r.lawful and not r.symptoms and not r.command)


def breaks(name: str, why: str, log: Log, law: str) -> Verdict:
    """Return the case of a log that breaks a law, among others perhaps."""
    return audited(name, why, log, lambda r: law in r.laws_broken)


def keeps(name: str, why: str, log: Log, law: str) -> Verdict:
    """Return the case of a log that keeps a law, whatever else is wrong with it."""
    return audited(name, why, log, lambda r: law not in r.laws_broken)


def named(name: str, why: str, log: Log, symptom: str, robot: Robot | None = None) -> Verdict:
    """Return the case of a log whose first symptom is this one."""
    return audited(name, why, log, lambda r: bool(r.symptoms) and r.symptoms[0].name == symptom, robot)


def asked(name: str, why: str, log: Log, finding: str) -> Verdict:
    """Return the case of a log whose first finding about its command is this one."""
    return audited(name, why, log, lambda r: bool(r.command) and r.command[0].name == finding)


def obeyed(name: str, why: str, log: Log, finding: str) -> Verdict:
    """Return the case of a log without this finding about its command."""
    return audited(name, why, log, lambda r: finding not in {found.name for found in r.command})
