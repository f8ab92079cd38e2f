"""A checklist for contact in a log: ten questions, each answered by the laws and symptoms that bear on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from surefoot.records import Log
    from surefoot.records.audit import AuditReport


class ChecklistQuestion(NamedTuple):
    """A question, the laws, symptoms and findings on the command that answer it, and channels it needs."""

    text: str
    laws: tuple[str, ...]
    signs: tuple[str, ...]
    needs: tuple[str, ...] = ("forces",)


QUESTIONS = (
    ChecklistQuestion("Does the schedule let feet push, and do they?", (), ("no forces", "idle", "dropout")),
    ChecklistQuestion(
        "Did the controller ask for what contacts can give?",
        (),
        ("infeasible", "coarse facets", "commanded pull", "commanded cone"),
        ("forces_commanded",),
    ),
    ChecklistQuestion(
        "Do forces, frames, signs and torques agree with the motion?",
        ("motion", "balance"),
        (
            "wrong frame",
            "reversed",
            "mirrored",
            "swapped feet",
            "wrong torques",
            "torques not applied",
            "dead torque",
            "outside force",
        ),
    ),
    ChecklistQuestion("Does the ground only push?", ("pull",), ("pull",)),
    ChecklistQuestion(
        "Does friction stay in the cone?", ("friction",), ("too much friction", "pyramid bias")
    ),
    ChecklistQuestion(
        "Is there force only in contact?", ("distance",), ("phantom force", "friction in the air")
    ),
    ChecklistQuestion("Do feet stay out of the ground?", ("penetration",), ("sinking", "deep contact")),
    ChecklistQuestion(
        "Do feet that stand stay where they are?", ("dissipation", "work"), ("skating", "frictionless slide")
    ),
    ChecklistQuestion(
        "Do touches return no energy?", ("restitution",), ("energy gain", "push off penetration")
    ),
    ChecklistQuestion(
        "Is the contact force calm?", (), ("chatter", "one step impulse", "unconverged solver")
    ),
)

ANSWER = ("question", "answer", "why")
"""Columns of the answers."""


def answers(report: AuditReport, log: Log) -> list[list[str]]:
    """Return a row for each question: the question, "yes", "no" or "cannot tell", and why."""
    return [[question.text, *_answer(question, report, log)] for question in QUESTIONS]


def _answer(question: ChecklistQuestion, report: AuditReport, log: Log) -> tuple[str, str]:
    """Return the answer to a question, and what speaks against it or could not be judged."""
    broken = [str(v) for v in report.violations if v.law in question.laws]
    found = [str(f) for f in (*report.command, *report.symptoms) if f.name in question.signs]
    if broken or found:
        return "no", (broken + found)[0]
    # a policy's commands hold no forces but NaN, of which nothing was judged
    lacking = [name for name in question.needs if name not in log or not np.isfinite(log[name]).any()]
    if lacking:
        return "cannot tell", f"the log has no {', '.join(lacking)}"
    reasons = {law: report.coverage.get(law, "") for law in question.laws}
    if reasons and all(reasons.values()):
        return "cannot tell", "; ".join(f"{law}: {why}" for law, why in reasons.items())
    log_itself = [v for v in report.violations if v.law not in report.coverage]
    if log_itself:
        return "cannot tell", str(log_itself[0])
    return "yes", ", ".join(law for law, why in reasons.items() if not why)
