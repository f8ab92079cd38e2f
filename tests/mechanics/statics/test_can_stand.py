"""Verdicts against independent solvers, with their proofs, and the cases at the edges."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import surefoot as sf
from benchmarks.problems.stances import KINDS, random_case, random_cases
from benchmarks.statics import rivals
from benchmarks.statics.race import agreement
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY

FEET = [[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]]


def on_slope(degrees, mu=0.6, feet=FEET):
    ground = sf.SlopeTerrain(degrees)
    return sf.Stance([sf.PointContact([*p, float(ground.height(p))], ground.normal(p), mu) for p in feet])


def ask(case, **options):
    return sf.can_stand(case.stance, case.com, case.mass, case.external_wrench, **options)


def moved(stance, R, shift, length=1.0):
    """The same stance turned, put elsewhere and in another unit of length."""
    contacts = []
    for c in stance:
        place, heading = length * R @ c.position + shift, R @ c.rotation_world_contact[:, 0]
        if c.dim == 3:
            contacts.append(sf.PointContact(place, R @ c.normal, c.mu, heading=heading))
        else:
            sole = sf.Sole.of_corners(length * c.sole.corners, c.mu)
            contacts.append(sf.SoleContact(place, sole, R @ c.normal, heading=heading))
    return sf.Stance(contacts)


def test_exact_verdicts_agree_with_clarabel():
    """A sample; `surefoot bench statics` compares 5000 and more."""
    pytest.importorskip("clarabel")
    found = agreement(random_cases(900, seed=11))
    assert found.disagreed == 0
    assert found.verified == found.cases
    assert 0.3 < found.possible / found.cases < 0.7
    assert found.worst_margin < 1e-6


@pytest.mark.parametrize("facets", [4, 8])
def test_pyramid_verdicts_agree_with_highs(facets):
    found = agreement(random_cases(180, seed=12), facets=facets)
    assert found.disagreed == 0
    assert found.verified == found.cases
    assert found.worst_margin < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_margin_is_what_it_says_and_cannot_be_beaten(kind):
    """The forces have exactly the margin, and the dual bound says that no forces have more."""
    rng = np.random.default_rng(5)
    for _ in range(40):
        case = random_case(rng, kind)
        verdict = ask(case)
        if not verdict or not math.isfinite(verdict.margin):
            continue
        scale = np.linalg.norm(verdict.load)
        points = case.stance.points()
        margins = [
            float(c.cone.margin(f)) for c, f in zip(points, verdict.corner_forces, strict=True) if c.mu > 0
        ]
        assert min(margins) == pytest.approx(verdict.margin, abs=1e-9 * scale)
        total = case.stance.grasp_map(case.com) @ verdict.stacked
        np.testing.assert_allclose(total, verdict.load, atol=1e-9 * max(scale, np.abs(verdict.forces).max()))


@pytest.mark.parametrize("degrees", [0, 5, 20, 30, 35, 60, 80, 88])
def test_friction_needed_on_a_slope_is_its_tangent(degrees):
    needed = sf.friction_needed(on_slope(degrees), [0, 0, 0.05], 15.0)
    assert needed == pytest.approx(math.tan(math.radians(degrees)), abs=1e-6, rel=1e-8)


def test_friction_needed_is_the_boundary_of_can_stand():
    rng = np.random.default_rng(6)
    checked = 0
    for k in range(60):
        case = random_case(rng, KINDS[k % 5])
        needed = sf.friction_needed(case.stance, case.com, case.mass, case.external_wrench, math.inf)
        if math.isinf(needed):
            assert not sf.can_stand(case.stance.with_friction(9e3), case.com, case.mass, case.external_wrench)
            continue
        above = sf.can_stand(
            case.stance.with_friction(needed * 1.001), case.com, case.mass, case.external_wrench
        )
        assert above
        if needed > 0.0:
            checked += 1
            lower = case.stance.with_friction(needed * 0.999)
            assert not sf.can_stand(lower, case.com, case.mass, case.external_wrench)
    assert checked > 10


def test_no_friction_saves_a_robot_beside_its_feet():
    assert math.isinf(sf.friction_needed(on_slope(0), [0.3, 0, 0.3], 15.0))
    assert sf.friction_needed(on_slope(0), [0.1, 0.1, 0.3], 15.0) == 0.0
    assert math.isinf(sf.friction_needed(sf.Stance([]), [0, 0, 0], 1.0))


def test_height_matters_on_walls_but_not_on_level_ground():
    wall = sf.Stance([*on_slope(0), sf.PointContact([0.4, 0, 0.8], [-1, 0, 0], 0.0)])
    low = sf.can_stand(wall, [0.25, 0, 0.3], 15.0)
    assert low  # feet push the weight back through friction, the hand holds the moment
    far = sf.Stance([*on_slope(0, mu=0.05), sf.PointContact([0.4, 0, 0.8], [-1, 0, 0], 0.0)])
    assert not sf.can_stand(far, [0.25, 0, 0.3], 15.0)
    for height in (0.1, 1.0, 5.0):
        assert sf.can_stand(on_slope(0), [0.19, 0.14, height], 15.0)
        assert not sf.can_stand(on_slope(0), [0.21, 0.14, height], 15.0)


def test_degenerate_stances_get_right_answers():
    weight = 15.0
    none, one = sf.Stance([]), sf.Stance([sf.PointContact([0, 0, 0])])
    verdict = sf.can_stand(none, [0, 0, 1], weight)
    assert not verdict
    assert verdict.verify()
    assert verdict.margin == -math.inf
    assert sf.can_stand(one, [0, 0, 0.5], weight)
    assert not sf.can_stand(one, [0.001, 0, 0.5], weight)
    twice = sf.Stance([sf.PointContact([0, 0, 0]), sf.PointContact([0, 0, 0])])
    assert sf.can_stand(twice, [0, 0, 0.5], weight)
    assert not sf.can_stand(twice, [0.001, 0, 0.5], weight)
    line = sf.Stance([sf.PointContact([x, 0, 0]) for x in (-0.1, 0.0, 0.1)])
    assert sf.can_stand(line, [0.05, 0, 0.5], weight)
    for com in ([0.05, 0.001, 0.5], [0.11, 0, 0.5]):
        verdict = sf.can_stand(line, com, weight)
        assert not verdict
        assert verdict.verify()
    slippery = sf.Stance([sf.PointContact([*p, 0], mu=0.0) for p in FEET])
    assert sf.can_stand(slippery, [0, 0, 0.3], weight).margin == pytest.approx(weight * GRAVITY / 4)
    assert not sf.can_stand(slippery, [0, 0, 0.3], weight, [1.0, 0, 0, 0, 0, 0])


def test_boundary_has_an_honest_margin():
    scale = 15.0 * GRAVITY
    for com in ([0.2, 0, 0.3], [0.2, 0.15, 0.3], [-0.2, 0.1, 2.0]):
        assert abs(sf.can_stand(on_slope(0), com, 15.0).margin) < 1e-7 * scale
    edge = sf.can_stand(on_slope(30, mu=math.tan(math.radians(30.0))), [0, 0, 0.3], 15.0)
    assert abs(edge.margin) < 1e-7 * scale


def test_squeezing_without_limit_and_with_one():
    sides = [
        sf.PointContact([0.3 * s, 0.1 * t, 0], [-s, 0, 0], 0.3, heading=[0, 1, 0])
        for s in (-1, 1)
        for t in (-1, 1)
    ]
    verdict = sf.can_stand(sf.Stance(sides), [0, 0, 0], 15.0)
    assert math.isinf(verdict.margin)
    assert verdict.verify()
    margins = [float(c.cone.margin(f)) for c, f in zip(sides, verdict.by_contact(), strict=True)]
    assert min(margins) >= 0.0999 * 15.0 * GRAVITY
    each = 15.0 * GRAVITY / 4 / 0.3  # normal force that friction 0.3 needs
    for most, possible in ((1.01 * each, True), (0.99 * each, False)):
        bounded = sf.Stance(
            [sf.PointContact(c.position, c.normal, 0.3, normal_max=most, heading=[0, 1, 0]) for c in sides]
        )
        answer = sf.can_stand(bounded, [0, 0, 0], 15.0)
        assert bool(answer) is possible
        assert answer.verify()


def test_bounds_on_normal_forces_against_a_linear_program():
    """Inner pyramids and bounds on whole patches, put to HiGHS in its own words."""
    from scipy.optimize import linprog

    rng = np.random.default_rng(8)
    verdicts = []
    for k in range(60):
        case = random_case(rng, ("tilted", "patches")[k % 2], contacts=5)
        weight = case.mass * GRAVITY
        low, high = rng.uniform(0.0, 0.1) * weight, rng.uniform(0.15, 0.4) * weight
        for c in case.stance:
            c.normal_min, c.normal_max = low, high
        case.com[:] = case.stance.positions.mean(axis=0)
        stance = sf.Stance([*case.stance])
        angle = 2.0 * np.pi * np.arange(8) / 8
        corners = [(at, c.mu) for at, c in enumerate(stance) for _ in range(1 if c.dim == 3 else 4)]
        edges = [[mu * np.cos(angle), mu * np.sin(angle), np.ones(8)] for _, mu in corners]
        grasp = rivals.world_grasp(case.stance, case.com)
        A = np.hstack([grasp[:, 3 * j : 3 * j + 3] @ edge for j, edge in enumerate(edges)])
        rows = np.repeat(np.eye(len(stance))[:, [at for at, _ in corners]], 8, axis=1)
        G = np.vstack([rows, -rows])
        h = np.concatenate([np.full(len(stance), high), np.full(len(stance), -low)]) / weight
        truth = linprog(
            np.zeros(A.shape[1]), A_ub=G, b_ub=h, A_eq=A, b_eq=rivals.load_of(case) / weight,
            bounds=(0, None), method="highs",
        ).status == 0  # fmt: skip
        verdict = sf.can_stand(stance, case.com, case.mass, facets=8)
        assert verdict.verify()
        if abs(verdict.margin) > 1e-6 * weight:
            assert bool(verdict) == truth
        exact = sf.can_stand(stance, case.com, case.mass)
        assert exact.verify()
        assert exact or not verdict
        verdicts.append(truth)
    assert 5 < sum(verdicts) < 55


def test_inner_below_exact_below_outer():
    rng = np.random.default_rng(9)
    for k in range(40):
        case = random_case(rng, KINDS[k % 5])
        inner, exact, outer = ask(case, facets=6), ask(case), ask(case, facets=6, fit="outer")
        assert bool(inner) <= bool(exact) <= bool(outer)
        assert outer.verify()
        assert inner.verify()


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    length=st.sampled_from([1e-3, 1e3, 1.0]),
    mass=st.sampled_from([1e-6, 1e3, 1.0]),
)
def test_units_do_not_matter(seed, length, mass):
    """Millimetres, kilometres, milligrams and tons: the verdict is the same, the margin scales."""
    case = random_case(np.random.default_rng(seed), KINDS[seed % 5])
    here = ask(case)
    push = mass * case.external_wrench * np.array([1, 1, 1, length, length, length])
    stance = moved(case.stance, np.eye(3), 0.0, length)
    there = sf.can_stand(stance, length * case.com, mass * case.mass, push)
    if abs(here.margin) > 1e-6 * np.linalg.norm(here.load):
        assert bool(here) == bool(there)
        assert there.verify()
        if math.isfinite(here.margin):
            assert there.margin == pytest.approx(mass * here.margin, rel=1e-5)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_moving_and_turning_the_world_changes_nothing(seed):
    """Turned about the vertical and moved anywhere, the answer is the same."""
    rng = np.random.default_rng(seed)
    case = random_case(rng, KINDS[seed % 4])
    R = Rotation.from_euler("z", rng.uniform(-np.pi, np.pi)).as_matrix()
    shift = rng.normal(size=3) * 10.0
    there = sf.can_stand(moved(case.stance, R, shift), R @ case.com + shift, case.mass)
    here = ask(case)
    scale = np.linalg.norm(here.load)
    if abs(here.margin) > 1e-6 * scale:
        assert bool(here) == bool(there)
        if math.isfinite(here.margin):
            assert there.margin == pytest.approx(here.margin, rel=1e-5, abs=1e-7 * scale)


def test_a_patch_is_its_four_corners():
    rng = np.random.default_rng(10)
    for _ in range(20):
        case = random_case(rng, "patches")
        whole, corners = ask(case), sf.can_stand(case.stance.points(), case.com, case.mass)
        assert bool(whole) == bool(corners)
        assert whole.margin == pytest.approx(corners.margin, abs=1e-7 * np.linalg.norm(whole.load))


def test_certificate_is_a_separating_wrench():
    """Two matrix products, done here by hand on a stance that slides."""
    stance = on_slope(40)
    verdict = sf.can_stand(stance, [0, 0, 0.3], 15.0)
    assert not verdict
    assert verdict.forces is None
    assert verdict.by_contact() == []
    assert verdict.certificate @ verdict.load < 0.0
    forces = np.random.default_rng(0).normal(size=(500, len(stance), 3)) * 100.0
    for k, contact in enumerate(stance):
        forces[:, k] = contact.cone.project(forces[:, k])
    wrenches = forces.reshape(500, -1) @ stance.grasp_map([0, 0, 0.3]).T
    assert np.all(wrenches @ verdict.certificate >= -1e-9 * np.abs(wrenches).max())


def test_a_wrong_proof_does_not_verify():
    good, bad = (sf.can_stand(on_slope(degrees), [0, 0, 0.3], 15.0) for degrees in (10, 40))
    corners, good.corner_forces = good.corner_forces, 0.0 * good.corner_forces
    assert not good.verify()
    good.corner_forces, good.stacked = corners, good.stacked * 1.01
    assert not good.verify()
    for certificate in (-bad.certificate, None):
        bad.certificate = certificate
        assert not bad.verify()


def test_largest_disturbance_is_where_the_stance_fails():
    rng = np.random.default_rng(13)
    checked = 0
    for k in range(100):
        case = random_case(rng, KINDS[k % 5], contacts=int(rng.integers(3, 7)))
        verdict = ask(case)
        if not verdict or verdict.margin < 1e-3:
            continue
        direction = rng.normal(size=6) * [1, 1, 1, 0.1, 0.1, 0.1]
        reach = verdict.largest_disturbance(direction)
        if math.isinf(reach):
            push = case.external_wrench + 1e3 * case.mass * direction
            assert sf.can_stand(case.stance, case.com, case.mass, push)
            continue
        checked += 1
        for share, possible in ((0.999, True), (1.001, False)):
            push = case.external_wrench + share * reach * direction
            assert bool(sf.can_stand(case.stance, case.com, case.mass, push)) is possible
    assert checked > 10


def test_pushing_over_and_pushing_away():
    """Four feet on level ground: sliding at mu m g, tipping at m g x / h, lifting at m g."""
    weight = 15.0 * GRAVITY
    low = sf.can_stand(on_slope(0), [0, 0, 0.05], 15.0)
    assert low.largest_disturbance([1, 0, 0, 0, 0, 0]) == pytest.approx(0.6 * weight, rel=1e-6)
    high = sf.can_stand(on_slope(0), [0.05, 0, 0.6], 15.0)
    assert high.largest_disturbance([1, 0, 0, 0, 0, 0]) == pytest.approx(weight * 0.15 / 0.6, rel=1e-6)
    assert high.largest_disturbance([2, 0, 0, 0, 0, 0]) == pytest.approx(weight * 0.15 / 1.2, rel=1e-6)
    assert high.largest_disturbance([0, 0, 1, 0, 0, 0]) == pytest.approx(weight, rel=1e-6)
    assert math.isinf(high.largest_disturbance([0, 0, -1, 0, 0, 0]))
    assert sf.can_stand(on_slope(40), [0, 0, 0.3], 15.0).largest_disturbance([1, 0, 0, 0, 0, 0]) == 0.0
    with pytest.raises(ProblemError, match="direction"):
        high.largest_disturbance(np.zeros(6))


def test_an_unknown_fit_is_named():
    with pytest.raises(ProblemError, match="inner, outer"):
        sf.can_stand(on_slope(0), [0, 0, 0.3], 15.0, facets=8, fit="middle")
