"""Which laws a log lets one judge, and whether they are enough to call it lawful."""

from __future__ import annotations

import numpy as np

from surefoot.records.audit.checks import CHECKS
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.model_changes import masses_changed
from surefoot.records.audit.rows import lacking
from surefoot.records.log import Log

OF_ONE_MASS = ("motion", "acceleration", "centre of mass", "momentum")
"""Laws that take the robot to have one mass; `balance` knows of weight that is put on."""
FROM_ROW_TO_ROW = (
    "motion", "restitution", "flight", "state", "gap rate", "momentum", "centre of mass", "acceleration",
    "contact jump",
)  # fmt: skip
"""Laws of what changes from a row to the next: nobody knows them where rows are lost."""
NEEDED = ("pull", "penetration", "distance", "friction")
"""Laws without which no log is called lawful: unilateral contact and Coulomb's cone."""
NEVER_LOADED = "no contact ever carries anything, and the motion is not known"


def coverage_of(log: Log, setting: Setting) -> dict[str, str]:
    """Return why each law cannot be judged; "" where it can."""
    out = {}
    for check in (c for c in CHECKS if c.law and c.applies(log)):
        missing = lacking(log, check.needs)
        why = f"the log has no {', '.join(missing)}" if missing else ""
        if not setting.names:  # what never touches anything is judged by its momentum
            free = "momentum_rate" in log and not missing
            why = "" if check.name == "balance" and free else "the log has no contacts"
        if not why and check.name in OF_ONE_MASS and masses_changed(log):
            why = "the loop changed masses of its model"
        if not why and check.name in FROM_ROW_TO_ROW:
            why = setting.missing_rows
        out[check.name] = why or check.doubt(log, setting)
    return out


def why_unsure(log: Log, setting: Setting, coverage: dict[str, str]) -> str:
    """Return why a log in which nothing is found wrong cannot be called lawful; empty if it can."""
    why = why_unsure_of(setting, coverage, len(log))
    if why or not (coverage["motion"] and coverage["balance"]):
        return why
    return "" if any(_loaded(piece, setting) for piece in log.chunks()) else NEVER_LOADED


def why_unsure_of(setting: Setting, coverage: dict[str, str], rows: int) -> str:
    """Return why so many rows cannot be called lawful, whatever they are; empty if they can."""
    alone = not setting.names and not coverage["balance"]
    lacking = {why for name, why in coverage.items() if why and name in NEEDED and not alone}
    if lacking:
        return ", ".join(sorted(lacking))
    if setting.doubts:
        return setting.doubts[0]
    if rows < (least := setting.limits.records.least_rows):
        return f"{rows} rows are too few, {least} are the least"
    return ""


def _loaded(log: Log, setting: Setting) -> bool:
    """Return whether a contact is ever loaded."""
    return bool(np.any(np.asarray(log["forces"])[..., 2] > setting.threshold))
