"""The plans of `auto` name what exists, and cover every law and cone."""

from __future__ import annotations

import surefoot as sf
from surefoot.contact.laws import LAWS
from surefoot.solvers import auto, plans

TABLES = (plans.CONES, plans.CONES_LARGE, plans.PYRAMIDS)


def test_every_stage_is_a_solver_or_a_part() -> None:
    known = {*sf.solver_names(), *auto.PARTS, plans.PROOF, plans.EARLY_PROOF}
    stages = [stage for table in TABLES for plan in table.values() for stage in plan]
    assert {stage.name for stage in [*stages, *plans.GENERAL]} <= known
    assert all(stage.most is None or stage.most > 0 for stage in stages)


def test_every_law_has_its_plans_and_each_looks_for_a_proof() -> None:
    for table in TABLES:
        assert set(table) == set(LAWS)
        assert all(plans.PROOF in [stage.name for stage in plan] for plan in table.values())
    assert plans.PROOF in [stage.name for stage in plans.GENERAL]
