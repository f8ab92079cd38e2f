"""Which law was broken, where and by how much: logs in, figures out; never imports solvers or controllers."""

from surefoot.audit.auditor import assert_lawful, audit_log
from surefoot.audit.checks import CHECKS
from surefoot.audit.laws import LawFigures, contact_use, log_laws
from surefoot.audit.pressure import sole_pressures
from surefoot.audit.report import AuditReport, FrictionInterval, Violation
from surefoot.audit.stand import StandSummary, summarise_stand
from surefoot.audit.summary import RunSummary
from surefoot.audit.symptoms import SYMPTOMS
from surefoot.audit.walk import WalkSummary, summarise_walk

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
