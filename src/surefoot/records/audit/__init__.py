"""Which law was broken, where and by how much: logs in, figures out; never imports solvers or controllers."""

from surefoot.records.audit.auditor import assert_lawful, audit_log
from surefoot.records.audit.checks import CHECKS
from surefoot.records.audit.laws import LawFigures, contact_use, log_laws
from surefoot.records.audit.pressure import sole_pressures
from surefoot.records.audit.report import AuditReport, FrictionInterval, Violation
from surefoot.records.audit.summary.run_summary import RunSummary
from surefoot.records.audit.summary.stand_summary import StandSummary, summarise_stand
from surefoot.records.audit.summary.walk_summary import WalkSummary, summarise_walk
from surefoot.records.audit.symptoms import SYMPTOMS

__all__ = [
    "CHECKS",
    "SYMPTOMS",
    "AuditReport",
    "FrictionInterval",
    "LawFigures",
    "RunSummary",
    "StandSummary",
    "Violation",
    "WalkSummary",
    "assert_lawful",
    "audit_log",
    "contact_use",
    "log_laws",
    "sole_pressures",
    "summarise_stand",
    "summarise_walk",
]
