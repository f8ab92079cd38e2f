"""Many stances at once, of the families that are hard on arithmetic: verdicts as of the single calls."""

from __future__ import annotations

import numpy as np
import pytest
from stance_families import FAMILIES, question

import surefoot as sf
from tests.mechanics.statics.test_statics_batch import assert_same_region


@pytest.mark.parametrize("family", FAMILIES)
def test_verdicts_and_regions_are_those_of_the_single_calls(family: str) -> None:
    rng = np.random.default_rng(11)
    asked = [question(rng, family, 10.0 ** rng.choice([-3.0, 0.0, 3.0])) for _ in range(12)]
    stances, masses = [q.stance for q in asked], [q.mass for q in asked]
    verdicts = sf.can_stand_batch(stances, [q.com for q in asked], masses)
    regions = sf.com_region_batch(stances, masses, tol=1e-3)
    for q, verdict, region in zip(asked, verdicts, regions, strict=True):
        alone = sf.can_stand(q.stance, q.com, q.mass)
        assert verdict.status == alone.status
        assert verdict.margin == pytest.approx(alone.margin, rel=1e-9)
        assert verdict.verify() == alone.verify()
        single = sf.com_region(q.stance, q.mass, tol=1e-3)
        assert_same_region(region, single, 1e-9, 1e-3)
