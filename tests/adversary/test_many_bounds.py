"""Many bounded contacts, hard ones among them: verdicts prove themselves, in blocks as in one piece."""

from __future__ import annotations

import numpy as np
import pytest
from stance_families import FAMILIES, question

import surefoot as sf
from surefoot.mechanics.statics.limits import Question, equations, normal_limits
from surefoot.mechanics.statics.margin import most_margin
from surefoot.mechanics.statics.row_blocks import IN_ONE
from surefoot.mechanics.statics.statics import needed_wrench


def crowd(rng: np.random.Generator, family: str) -> tuple[sf.Stance, np.ndarray, float]:
    """Return a stance of one family, its contacts repeated until they are 40, each with bounds."""
    asked = question(rng, family)
    contacts, weight = list(asked.stance.contacts), 9.81 * asked.mass
    out = []
    for k in range(40):
        at = contacts[k % len(contacts)]
        most = float(weight * rng.choice([0.02, 0.2, 2.0]))
        least = float(rng.choice([0.0, 0.01])) * most
        move = 1e-3 * asked.length * rng.normal(size=3) * (k >= len(contacts))
        out.append(sf.PointContact(at.position + move, at.normal, at.mu, normal_min=least, normal_max=most))
    return sf.Stance(out), asked.com, asked.mass


@pytest.mark.parametrize("family", FAMILIES)
def test_verdicts_of_many_bounded_contacts_prove_themselves(family: str) -> None:
    rng = np.random.default_rng(FAMILIES.index(family))
    for _ in range(6):
        stance, com, mass = crowd(rng, family)
        verdict = sf.can_stand(stance, com, mass)
        assert verdict.status == "undecided" or verdict.verify()
        eq = equations(Question(stance, com, needed_wrench(mass), normal_limits(stance)))
        assert len(eq.blocks)
        whole = most_margin(eq.A, eq.e, eq.w, eq.lorentz, IN_ONE)
        possible = {"possible": True, "impossible": False}.get(verdict.status)
        if possible is not None and abs(whole[1]) > 1e-7:
            assert (whole[1] > 0.0) == possible


@pytest.mark.parametrize("facets", [None, 4])
def test_bounded_margins_on_ice_have_no_unit_of_length(facets):
    """Cones a millionth wide beside bounds: cone and bound move by lengths a million times apart."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        places, normals = rng.normal(size=(4, 3)) * [0.3, 0.3, 0.1], rng.normal(size=(4, 3)) * 0.3 + [0, 0, 1]
        mu, most = 10.0 ** rng.uniform(-9, -6), rng.uniform(50, 400)
        margins = []
        for length in (1e-3, 1.0, 1e3):
            contacts = [
                sf.PointContact(length * p, n / np.linalg.norm(n), mu, normal_max=most)
                for p, n in zip(places, normals, strict=True)
            ]
            margins.append(
                sf.can_stand(sf.Stance(contacts), [0, 0, 0.3 * length], 15.0, facets=facets).margin
            )
        assert np.ptp(margins) < 1e-6 * (15.0 * 9.81 + abs(margins[1]))
