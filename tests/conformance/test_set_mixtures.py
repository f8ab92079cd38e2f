"""Random mixtures of contacts of all kinds, of any rank and scale: no claim without its laws or its proof."""

from __future__ import annotations

import math

import numpy as np
import pytest
from set_judge import check_laws

import surefoot as sf
from surefoot.contact.sets import ContactKind
from surefoot.contact.sets.contact_set import ContactSet

C = sf.contact_sets
LAWS = (sf.laws.COULOMB, sf.laws.CONVEX, sf.laws.Law("half dilatant", shift=0.5))


def draw(rng: np.random.Generator) -> ContactKind:
    """A contact with ordinary and with degenerate parameters; sometimes bounded, sometimes off."""
    kind, mu = rng.integers(8), float(rng.choice([0.0, 0.2, 0.6, 1.5, 5.0]))
    length = float(rng.choice([1e-3, 0.05, 1.0]))
    bounds: dict[str, float] = {}
    if kind != 7 and rng.random() < 0.15:
        bounds = {"normal_min": float(rng.uniform(0, 1)), "normal_max": float(rng.choice([math.inf, 2.0]))}
    elif kind != 7 and rng.random() < 0.1:
        bounds = {"normal_max": 0.0}
    size = rng.uniform(0.05, 0.4, 2).tolist()
    table = {
        0: lambda: C.Frictionless(**bounds),
        1: lambda: C.Planar(mu, **bounds),
        2: lambda: C.Point(mu, **bounds),
        3: lambda: C.SoftFinger(mu, length, **bounds),
        4: lambda: C.Rolling(mu, length, **bounds),
        5: lambda: C.DecoupledSole(mu, *size, length, **bounds),
        6: lambda: C.Pyramid(mu, int(rng.integers(3, 9)), str(rng.choice(["inner", "outer"])), **bounds),
        7: lambda: C.Bilateral(int(rng.integers(1, 7))),
    }
    return table[int(kind)]()


def mixture(seed: int) -> tuple[sf.ContactProblem, bool]:
    """A problem, and whether g is a motion of the bodies, so that only a jam is without solution."""
    rng = np.random.default_rng(seed)
    contacts = [draw(rng) for _ in range(rng.integers(1, 7))]
    s = ContactSet(contacts)
    J = rng.normal(size=(s.rows, rng.integers(1, s.rows + 4))) / s.lengths[:, None]
    if rng.random() < 0.3:
        J *= 10.0 ** rng.uniform(-2, 2, size=J.shape[1])
    if rng.random() < 0.3:
        J *= np.repeat(10.0 ** rng.uniform(-2, 2, len(contacts)), [c.rows for c in contacts])[:, None]
    moving = rng.random() < 0.7
    g = J @ rng.normal(size=J.shape[1]) if moving else rng.normal(size=s.rows) / s.lengths
    return sf.ContactProblem(J @ J.T, g, contacts=contacts, law=LAWS[rng.integers(3)]), moving


@pytest.mark.parametrize("start", range(0, 240, 40))
@pytest.mark.sampled(2)
def test_no_false_claim(start: int) -> None:
    missed = possible = proven = 0
    for seed in range(start, start + 40):
        problem, moving = mixture(seed)
        if not problem.general:
            continue
        found = sf.solve(problem, max_time=5.0)
        possible, missed = possible + moving, missed + (moving and not found.solved)
        s = problem.contact_set
        if found.solved:
            nearest = problem.velocity(s.nearest_to_zero()).ravel() * s.lengths
            slack = 1e-7 * float(np.abs(nearest).max()) * max(1.0, float(np.abs(found.forces).max()))
            assert found.residuals.cone_violation <= 1e-9 * max(1.0, float(np.abs(found.forces).max()))
            parts = zip(s, s.split(found.forces), s.split(problem.velocity(found.forces)), strict=True)
            for contact, force, velocity in parts:
                if contact.normal_min == 0.0 and contact.normal_max == math.inf:
                    check_laws(contact, force, velocity, problem.law.shift, slack)
        if found.status is sf.Status.INFEASIBLE:
            assert found.proof is not None
            d = found.proof.direction.ravel()
            assert problem.g @ d < 0.0
            drift = np.abs(problem.G @ d * s.lengths).max()
            assert drift <= 1e-9 * np.abs(problem.G * s.lengths[:, None] * s.lengths).max()
            proven += 1
    assert missed <= 0.1 * possible
    assert proven > 0  # the family is not all soluble
