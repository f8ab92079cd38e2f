"""Which law was broken, where and by how much: logs in, figures out; never imports solvers or controllers."""

from surefoot.audit.laws import Laws, check_laws, contact_use, log_laws
from surefoot.audit.pressure import SolePressure, sole_pressures
from surefoot.audit.stand import StandSummary, summarise_stand
from surefoot.audit.summary import RunSummary
from surefoot.audit.walk import WalkSummary, summarise_walk

__all__ = [
    "Laws",
    "RunSummary",
    "SolePressure",
    "StandSummary",
    "WalkSummary",
    "check_laws",
    "contact_use",
    "log_laws",
    "sole_pressures",
    "summarise_stand",
    "summarise_walk",
]
