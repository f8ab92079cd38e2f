"""The rules of the lint: one table, family by family."""

from __future__ import annotations

from surefoot.mechanics.robot.lint.actuators import ACTUATOR_RULES
from surefoot.mechanics.robot.lint.feet import FEET_RULES
from surefoot.mechanics.robot.lint.finding import SEVERITIES, Finding, Rule
from surefoot.mechanics.robot.lint.geometry import GEOMETRY_RULES
from surefoot.mechanics.robot.lint.inertias import INERTIA_RULES
from surefoot.mechanics.robot.lint.joints import JOINT_RULES
from surefoot.mechanics.robot.lint.softness import SOFTNESS_RULES
from surefoot.mechanics.robot.lint.steps import STEP_RULES
from surefoot.mechanics.robot.lint.subject import Subject
from surefoot.mechanics.robot.lint.tree import TREE_RULES

RULES: tuple[Rule, ...] = (
    *TREE_RULES, *INERTIA_RULES, *JOINT_RULES, *FEET_RULES, *GEOMETRY_RULES, *ACTUATOR_RULES, *STEP_RULES,
    *SOFTNESS_RULES,
)  # fmt: skip
"""All rules, in the order in which findings of one severity are told."""


def apply_rules(subject: Subject) -> tuple[Finding, ...]:
    """Return what the rules find in a subject: errors first."""
    found = [
        Finding(
            rule.name,
            offence.severity or rule.severity,
            offence.place,
            offence.value,
            offence.detail,
            rule.remedy,
        )
        for rule in RULES
        for offence in rule.check(subject)
    ]
    return tuple(sorted(dict.fromkeys(found), key=lambda finding: SEVERITIES.index(finding.severity)))
