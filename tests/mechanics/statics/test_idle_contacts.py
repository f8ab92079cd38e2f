"""Contacts that are off, that can carry nothing, that squeeze: where a margin says little."""

import math

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.stances import KINDS, random_case
from surefoot.base.spatial import GRAVITY
from tests.mechanics.statics.test_can_stand import FEET, ask, on_slope


def test_a_contact_that_is_off_is_left_out():
    """With normal_max = 0 nothing had a margin: friction needed was 1, and every push too much."""
    rng = np.random.default_rng(23)
    for facets in (None, 3, 12):
        for k in range(8):
            case = random_case(rng, KINDS[k % 5], contacts=4)
            place, mu = rng.normal(size=3), 10.0 ** rng.uniform(-6, 0)
            off: sf.PointContact | sf.SoleContact = sf.PointContact(place, mu=mu, normal_max=0.0)
            if k % 2 == 0:
                off = sf.SoleContact(place, sf.Sole(0.2, 0.1, mu), normal_max=0.0)
            more = sf.Stance([*case.stance, off])
            without = ask(case, facets=facets)
            verdict = sf.can_stand(more, case.com, case.mass, case.external_wrench, facets)
            assert verdict.status == without.status
            assert verdict.verify()
            scale = 1e-7 * np.linalg.norm(verdict.load)
            assert verdict.margin == pytest.approx(without.margin, abs=scale)
            push = [1.0, 0.5, 0, 0, 0, 0]
            assert verdict.largest_disturbance(push) == pytest.approx(
                without.largest_disturbance(push), rel=1e-6, abs=scale
            )
        needed = (
            sf.friction_needed(s, case.com, case.mass, case.external_wrench) for s in (more, case.stance)
        )
        assert next(needed) == pytest.approx(next(needed), rel=1e-5)
    none = sf.can_stand(sf.Stance([off]), [0, 0, 1.0], 1.0)
    assert none.status == "impossible"
    assert none.verify()
    assert sf.com_region(sf.Stance([off]), 1.0).empty


def test_squeezes_beside_a_bound_and_ice_are_decided():
    """The most margin asks forces that run away, beyond what rounding can judge; fewer hold as well."""
    for seed in (1, 5, 24, 37, 39):
        rng, contacts = np.random.default_rng(seed), []
        for k in range(5):
            x, y = math.cos(0.4 * math.pi * k), math.sin(0.4 * math.pi * k)
            place, normal = (
                [0.3 * x, 0.3 * y, rng.choice([0, 0.5])],
                np.array([-x, -y, rng.choice([0, 0.3, 1])]),
            )
            mu, most = 1e-6 if k == 4 else rng.uniform(0.2, 1), 212.0 if k == 3 else math.inf
            contacts.append(sf.PointContact(place, normal / np.linalg.norm(normal), mu, normal_max=most))
        verdict = sf.can_stand(sf.Stance(contacts), [0, 0, 0.4], 15.0)
        assert verdict
        assert verdict.verify()
        assert sf.com_region(sf.Stance(contacts), 15.0).contains([0, 0])


def test_where_a_contact_can_carry_nothing_the_margin_says_nothing():
    """Friction between 0.3906 and 0.4003 holds, without a margin: the frictionless foot must not push."""
    places = [[0.3, 0, 0.5], [-0.15, 0.25980762113533, 0], [-0.15, -0.25980762113533, 0.5]]
    normals = np.array([[-1, 0, 1], [0.5, -math.sqrt(0.75), 1], [0.5, math.sqrt(0.75), 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    stance = sf.Stance([sf.PointContact(p, n) for p, n in zip(places, normals, strict=True)])
    com, three = [-0.15, -0.25980762113533, 0.5 + 0.2], on_slope(0, feet=FEET[:3])
    needed = sf.friction_needed(stance, com, 15.0)
    for share, possible in ((1.0001, True), (0.9999, False)):
        assert bool(sf.can_stand(stance.with_friction(share * needed), com, 15.0)) is possible
    # above the edge between two feet it can be pushed towards the third, and not away from it
    verdict = sf.can_stand(three, [0, 0, 0.3], 15.0)
    inwards = verdict.largest_disturbance([1, 0, 0, 0, 0, 0])
    assert inwards == pytest.approx(0.6 * 15.0 * GRAVITY, rel=1e-6)
    assert verdict.largest_disturbance([-1, 0, 0, 0, 0, 0]) < 1e-5
