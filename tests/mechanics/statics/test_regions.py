"""CoM and ZMP regions against closed forms, linear programs and can_stand itself."""

import math

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.stances import random_case
from benchmarks.statics.rivals import highs_region
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.statics.com_region import support_polygon, zmp_region
from surefoot.mechanics.statics.limits import squeeze_limit
from surefoot.mechanics.statics.polygons import without_flat_corners
from surefoot.mechanics.statics.region import convex_hull, polygon_area

FEET = [[0.2, 0.15], [0.2, -0.15], [-0.2, 0.15], [-0.2, -0.15]]


def level(mu=0.6, **options):
    return sf.Stance([sf.PointContact([*p, 0], mu=mu, **options) for p in FEET])


def grown(polygon, distance):
    """Return corners of a polygon moved away from its middle (inwards for negative distances)."""
    middle = polygon.mean(axis=0)
    away = polygon - middle
    return polygon + distance * away / np.linalg.norm(away, axis=1, keepdims=True)


def rough_cases(count, seed, kinds=("tilted", "patches", "chimney")):
    rng = np.random.default_rng(seed)
    return [random_case(rng, kinds[k % len(kinds)], contacts=int(rng.integers(3, 7))) for k in range(count)]


def test_level_ground_gives_the_support_polygon():
    for stance in (level(), sf.Stance([sf.SoleContact([0, y, 0], sf.Sole(0.2, 0.1)) for y in (0.1, -0.1)])):
        region, support = sf.com_region(stance, 15.0), support_polygon(stance)
        assert region.area == pytest.approx(polygon_area(support), rel=1e-5)
        assert max(region.distance(corner) for corner in support) < 1e-5
        assert region.gap < 1e-3
        assert region.converged


def test_the_region_of_one_contact_at_the_origin_is_that_point():
    for seed in range(60):  # eight of a hundred lost it to underflow
        normal = np.array([*np.random.default_rng(seed).normal(size=2) * 0.3, 1.0])
        foot = sf.PointContact([0, 0, 0], normal / np.linalg.norm(normal), mu=2.0)
        region = sf.com_region(sf.Stance([foot]), 15.0)
        assert region.converged
        assert region.contains([0, 0])


@pytest.mark.parametrize("seed", [1, 2])
def test_regions_between_bounds_are_traced_to_the_end(seed):
    """A slack that has nothing to do with where the weight goes kept the search from ending."""
    rng = np.random.default_rng(seed)
    for _ in range(40):
        bounds = [{"normal_min": a, "normal_max": a + b} for a, b in rng.uniform(0, [[30.0, 190.0]] * 4)]
        mu = rng.choice([1e-6, 0.2, 0.9, 10.0], 4)
        contacts = [sf.PointContact([*p, 0], mu=m, **b) for p, m, b in zip(FEET, mu, bounds, strict=True)]
        stance = sf.Stance([sf.SoleContact([*FEET[0], 0], sf.Sole(0.2, 0.1), **bounds[0]), *contacts[1:]])
        region = sf.com_region(stance, 15.0, external_wrench=rng.normal(size=6))
        assert region.converged


@pytest.mark.long
def test_region_agrees_with_can_stand_inside_and_outside():
    empty = squeezed = 0
    for case in rough_cases(90, 0):
        stance = case.stance
        region = sf.com_region(stance, case.mass, tol=1e-3)
        if region.empty:
            empty += 1
            assert not sf.can_stand(stance, case.com, case.mass)
            continue
        if len(region.inner) < 3:
            continue
        limit = squeeze_limit(stance, region.force_limit) if region.force_limit < math.inf else None
        squeezed += limit is not None
        for corner in grown(region.inner, -1e-5):
            assert sf.can_stand(stance, [*corner, 0.7], case.mass, limits=limit)
        for corner in grown(region.outer, 1e-5):
            assert not sf.can_stand(stance, [*corner, 0.2], case.mass, limits=limit)
    assert empty < 40
    assert squeezed > 5


def test_every_region_converges():
    """Two to eight contacts of every kind, some facing each other so that the region has no bound."""
    for case in rough_cases(150, 9, kinds=("flat", "tilted", "patches", "chimney")) + two_contacts(60):
        region = sf.com_region(case.stance, case.mass, tol=1e-3)
        assert region.converged
        assert region.gap <= 1e-3


def two_contacts(count):
    rng = np.random.default_rng(10)
    return [random_case(rng, "tilted", contacts=2) for _ in range(count)]


@pytest.mark.parametrize("tol", [1e-2, 1e-3, 1e-4])
def test_gap_is_within_the_tolerance_and_certified(tol):
    for case in rough_cases(9, 1):
        region = sf.com_region(case.stance, case.mass, tol=tol)
        if region.empty or len(region.inner) < 3:
            continue
        assert region.gap <= tol
        assert region.converged
        assert np.all(region.directions @ region.inner.T <= region.heights[:, None] + 1e-9)
        away = [region.distance(q) for q in region.outer]
        assert max(away) <= region.gap + 1e-9


def test_region_lies_between_inner_and_outer_pyramids_by_linear_programs():
    for case in rough_cases(10, 2, kinds=("tilted", "patches")):
        region = sf.com_region(case.stance, case.mass, tol=1e-3)
        corners = highs_region(case.stance, case.mass, directions=16, facets=32)()
        if not len(corners) or region.empty:
            assert region.empty or polygon_area(region.inner) < 1e-3
            continue
        assert np.all(region.directions @ corners.T <= region.heights[:, None] + 1e-7)
        pyramid = sf.com_region(case.stance, case.mass, tol=1e-3, facets=32)
        assert np.all(pyramid.directions @ corners.T <= pyramid.heights[:, None] + 1e-7)
        assert max(pyramid.distance(c) for c in corners) <= pyramid.gap + 1e-7


def test_degenerate_regions():
    assert sf.com_region(sf.Stance([]), 15.0).empty
    one = sf.com_region(sf.Stance([sf.PointContact([0.3, 0.2, 0.1])]), 15.0)
    np.testing.assert_allclose(one.inner, [[0.3, 0.2]], atol=1e-6)
    assert one.area == 0.0
    line = sf.com_region(sf.Stance([sf.PointContact([x, 0, 0]) for x in (0.0, 0.5, 1.0)]), 15.0)
    np.testing.assert_allclose(line.inner[np.argsort(line.inner[:, 0])], [[0, 0], [1, 0]], atol=1e-6)
    assert line.contains([0.5, 0.0])
    assert not line.contains([0.5, 0.01])
    twice = sf.com_region(sf.Stance([sf.PointContact([0, 0, 0])] * 2), 15.0)
    assert len(twice.inner) == 1
    slope = sf.SlopeTerrain(30.0)
    slides = sf.Stance([sf.PointContact([*p, float(slope.height(p))], slope.normal(p), 0.5) for p in FEET])
    assert sf.com_region(slides, 15.0).empty
    assert repr(sf.com_region(slides, 15.0)) == "Region(empty)"


def test_acceleration_leans_the_region():
    """On level ground with ample friction the region's foot stays; it leans like the pendulum's force."""
    region = sf.com_region(level(mu=2.0), 15.0, acceleration=[2.0, 0, 1.0], height=0.0)
    np.testing.assert_allclose(region.axis, [2.0 / (GRAVITY + 1.0), 0, 1], atol=1e-12)
    assert region.area == pytest.approx(0.12, rel=1e-5)
    shift = 0.5 * 2.0 / (GRAVITY + 1.0)
    np.testing.assert_allclose(region.at_height(0.5), region.inner + np.array([shift, 0.0]), atol=1e-12)
    assert region.contains([0.2 + shift - 1e-3, 0, 0.5])
    assert not region.contains([-0.2 + shift - 1e-3, 0, 0.5])
    push = -15.0 * np.array([2.0, 0, 1.0, 0, 0, 0])  # d'Alembert
    same = sf.com_region(level(mu=2.0), 15.0, external_wrench=push, height=0.0)
    assert same.area == pytest.approx(region.area, rel=1e-9)
    for corner, possible in ((0.199 + shift, True), (0.201 + shift, False)):
        assert bool(sf.can_stand(level(mu=2.0), [corner, 0, 0.5], 15.0, push)) is possible


def test_moments_on_the_robot_shift_the_region():
    region = sf.com_region(level(), 15.0, external_wrench=[0, 0, 0, 0, 10.0, 0])
    shift = 10.0 / (15.0 * GRAVITY)
    assert sorted({round(x, 5) for x in region.inner[:, 0]}) == [
        round(-0.2 - shift, 5),
        round(0.2 - shift, 5),
    ]


def test_squeezing_without_limit_is_bounded_and_said():
    sides = [
        sf.PointContact([0.3 * s, y, 0], [-s, 0, 0], 0.5, heading=[0, 1, 0])
        for s in (-1, 1)
        for y in (-0.1, 0.1)
    ]
    region = sf.com_region(sf.Stance(sides), 15.0)
    assert region.force_limit == pytest.approx(10.0 * 15.0 * GRAVITY)
    most = [sf.PointContact(c.position, c.normal, 0.5, normal_max=100.0, heading=[0, 1, 0]) for c in sides]
    bounded = sf.com_region(sf.Stance(most), 15.0)
    assert math.isinf(bounded.force_limit)
    assert 0.0 < bounded.area < region.area
    for corner in grown(bounded.inner, -1e-5):
        assert sf.can_stand(sf.Stance(most), [*corner, 0.0], 15.0)
    for corner in grown(bounded.outer, 1e-5):
        assert not sf.can_stand(sf.Stance(most), [*corner, 0.0], 15.0)


def test_bad_requests_are_named():
    with pytest.raises(ProblemError, match="tol"):
        sf.com_region(level(), 15.0, tol=0.0)
    with pytest.raises(ProblemError, match="rest on the contacts"):
        sf.com_region(level(), 15.0, acceleration=[0, 0, -20.0])
    with pytest.raises(ProblemError, match="acceleration"):
        sf.com_region(level(), 15.0, acceleration=[0, 0])
    with pytest.raises(ProblemError, match="height must differ"):
        zmp_region(level(), [0, 0, 0.0], 15.0)


def test_zmp_region_of_level_ground_is_the_support_polygon_within_the_friction():
    """With enough friction the support polygon; with little, a disc of radius mu h around the CoM."""
    enough = zmp_region(level(mu=2.0), [0.05, 0, 0.3], 15.0)
    assert enough.area == pytest.approx(0.12, rel=1e-5)
    scarce = zmp_region(level(mu=0.3), [0.0, 0, 0.3], 15.0, tol=1e-5)
    assert scarce.area == pytest.approx(math.pi * 0.09**2, rel=1e-3)
    for angle in np.linspace(0, 6, 7):
        side = np.array([math.cos(angle), math.sin(angle)])
        assert scarce.contains(0.0899 * side)
        assert not scarce.contains(0.0901 * side)


def test_zmp_region_agrees_with_can_stand():
    """The pendulum's force through the zero-moment point, as an external wrench."""
    checked = 0
    for case in rough_cases(20, 3, kinds=("tilted", "patches")):
        com, weight = case.com, case.mass * GRAVITY
        com[:2] = case.stance.positions[:, :2].mean(axis=0)
        com[2] = case.stance.positions[:, 2].max() + 0.4
        region = zmp_region(case.stance, com, case.mass, tol=1e-3)
        if len(region.inner) < 3 or region.force_limit < math.inf:
            continue
        checked += 1
        for corners, distance, possible in ((region.inner, -1e-5, True), (region.outer, 1e-5, False)):
            for zmp in grown(corners, distance):
                pull = -weight / (com[2] - region.height) * (com[:2] - zmp)
                push = [*pull, 0, 0, 0, 0]
                assert bool(sf.can_stand(case.stance, com, case.mass, push)) is possible
    assert checked > 5


def test_polygons():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    assert polygon_area(square) == 1.0
    cloud = np.random.default_rng(5).uniform(size=(200, 2))
    hull = convex_hull(np.vstack([cloud, square, [[0.5, 0.0]]]))
    assert sorted(map(tuple, hull.tolist())) == sorted(map(tuple, square.tolist()))
    assert len(without_flat_corners(np.array([[0, 0], [0.5, -1e-9], [1, 0], [1, 1]]), 1e-6)) == 3
    assert len(convex_hull(np.array([[1.0, 2.0]] * 3))) == 1


def test_regions_without_interior_forces():
    """At the limit of friction every force is on its cone; a hand that nothing opposes carries nothing."""
    slope = sf.SlopeTerrain(30.0)
    mu = math.tan(math.radians(30.0)) * (1.0 + 1e-14)
    limit = sf.Stance([sf.PointContact([*p, float(slope.height(p))], slope.normal(p), mu) for p in FEET])
    assert sf.com_region(limit, 15.0).area == pytest.approx(0.12, rel=1e-4)
    hand = sf.PointContact([0, 0.2, 0.1], [-0.8, 0.0, 0.6], 0.1)
    useless = sf.Stance([sf.PointContact([0.3, 0.2, 0.0], mu=0.0), hand])
    region = sf.com_region(useless, 15.0)
    np.testing.assert_allclose(region.inner, [[0.3, 0.2]], atol=1e-6)


@pytest.mark.parametrize("mu", [1e8, 1e12])
def test_very_much_friction_leaves_no_empty_region(mu):
    """What rounding cannot say of it, less friction can: the polygon stands, what is outside is not known."""
    rng = np.random.default_rng(2)
    feet = [[0.2, 0.15, 0.01], [0.2, -0.15, -0.02], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.03], [0.0, 0.2, 0.02]]
    for _ in range(4):
        normals = np.array([[*rng.normal(0.0, 0.3, 2), 1.0] for _ in feet])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        contacts = [sf.PointContact(p, n, mu) for p, n in zip(feet, normals, strict=True)]
        region = sf.com_region(sf.Stance(contacts), 15.0)
        assert not region.empty
        assert "empty" not in repr(region)
        assert len(region.outer) or region.gap == np.inf
        for corner in region.inner[:: max(1, len(region.inner) // 4)]:
            held = [sf.PointContact(c.position, c.normal, 1e4) for c in contacts]
            assert sf.can_stand(sf.Stance(held), [*(0.999 * corner), region.height], 15.0)
