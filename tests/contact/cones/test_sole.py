"""The exact cone of a sole, against Clarabel on its corner forces, 50 digits, and closed forms."""

import math
from decimal import Decimal

import numpy as np
import pytest

from benchmarks.soles.judges import ClarabelSole, least_in_digits, random_sole, random_wrenches
from surefoot.base.errors import ProblemError
from surefoot.contact.cones import sole_proof
from surefoot.contact.cones.friction import FrictionCone
from surefoot.contact.cones.sole import Sole
from surefoot.contact.cones.sole_proof import count_moments

PUSH = [55.0, 0.0, 100.0, 0.0, 0.0, 0.0]
SOLE = Sole(0.22, 0.09, mu=0.6)
TRIANGLE = Sole.of_corners([[0.1, 0], [0, 0.1], [0, -0.1]], 2.0)


def size(sole, wrenches):
    return np.array([np.linalg.norm(count_moments(sole, w)) for w in np.reshape(wrenches, (-1, 6))])


@pytest.mark.parametrize("number", range(6))
def test_membership_and_margin_are_those_of_the_corner_forces(number):
    rng = np.random.default_rng(number)
    corners, mu = random_sole(rng, number)
    sole, judge = Sole.of_corners(corners, mu), ClarabelSole(corners, mu)
    wrenches = random_wrenches(rng, judge, mu, 90)
    least = np.array([judge.least(w) for w in wrenches])
    near = np.abs(wrenches[:, 2] - least) / size(sole, wrenches) < 1e-7
    assert near.any()
    assert sole.contains(wrenches).any()
    assert not sole.contains(wrenches).all()
    told = sole.contains(wrenches, tol=0.0)
    assert np.array_equal(told[~near], (wrenches[:, 2] >= least)[~near])
    assert np.all(np.abs(sole.margin(wrenches) - wrenches[:, 2] + least) <= 2e-8 * size(sole, wrenches))
    for k in np.flatnonzero(near)[:3]:  # what double precision cannot tell
        low, high = least_in_digits(corners, mu, wrenches[k])
        scale = size(sole, wrenches[k])[0]
        assert float(high - low) < 1e-18 * scale
        assert abs(float(low) - wrenches[k, 2] + sole.margin(wrenches[k])) < 1e-8 * scale


def test_pads_at_the_corners_resist_a_yaw_moment():
    rng = np.random.default_rng(5)
    corners, mu = random_sole(rng, 1)
    sole, judge = Sole.of_corners(corners, mu, 0.02), ClarabelSole(corners, mu, 0.02)
    wrenches = random_wrenches(rng, judge, mu, 60)
    least = np.array([judge.least(w) for w in wrenches])
    assert np.all(np.abs(sole.margin(wrenches) - wrenches[:, 2] + least) <= 2e-8 * size(sole, wrenches))
    # pressed at a corner, turning there: a soft finger of that radius
    x, y = sole.corners[0]
    finger = np.array([0.0, 0.0, 10.0, 10.0 * y, -10.0 * x, 10.0 * mu * 0.02])
    assert sole.contains(finger * 0.999, 1e-6)
    assert not sole.contains(finger + np.array([0, 0, 0, 0, 0, 0.01]))
    assert Sole.of_corners(corners, mu).friction_needed(finger + 0.01 * np.eye(6)[2]) > 10.0 * mu


@pytest.mark.parametrize("number", range(4))
def test_verdicts_come_with_proofs(number):
    rng = np.random.default_rng(100 + number)
    corners, mu = random_sole(rng, number)
    sole, judge = Sole.of_corners(corners, mu), ClarabelSole(corners, mu)
    cone, kinds = FrictionCone(mu), set()
    for w in random_wrenches(rng, judge, mu, 60, finest=1e-7):
        verdict = sole.verdict(w)
        scale = size(sole, w)[0]
        kinds.add(verdict.holds)
        assert bool(verdict) == bool(sole.contains(w))
        if verdict.holds:
            arms = np.column_stack([sole.corners, np.zeros(len(sole.corners))])
            got = np.concatenate([verdict.forces.sum(axis=0), np.cross(arms, verdict.forces).sum(axis=0)])
            assert np.linalg.norm(count_moments(sole, got - w)) <= 1e-8 * max(1.0, scale)
            assert cone.margin(verdict.forces).min() >= -1e-8 * max(1.0, scale)
        else:
            assert float(verdict.twist @ w) > 0.0
            assert sole.support(verdict.twist) == 0.0
    assert kinds == {True, False}


@pytest.mark.parametrize(
    ("number", "rows"),
    [(3, [6252, 6789, 7656]), (4, [3364, 8383]), (13, [485, 5679, 9532]), (17, [1433, 1560])],
)
@pytest.mark.sampled(2)
def test_wrenches_at_which_rounding_stops_the_steps_are_settled_in_more_digits(number, rows):
    rng = np.random.default_rng(number)
    corners, mu = random_sole(rng, number)
    sole, judge = Sole.of_corners(corners, mu), ClarabelSole(corners, mu)
    wrenches = random_wrenches(rng, judge, mu, max(rows) + 1)[rows]
    for w in wrenches:
        low, high = least_in_digits(corners, mu, w)
        scale, holds = size(sole, w)[0], Decimal(float(w[2])) >= high
        assert bool(sole.contains(w, 0.0)) == holds
        assert (sole.friction_needed(w) <= mu) == holds
        assert abs(float(Decimal(float(w[2])) - low) - sole.margin(w)) < 1e-9 * scale
        assert sole.verdict(w, 1e-11).holds is holds


def test_doubles_and_more_digits_say_the_same():
    rng = np.random.default_rng(11)
    corners, mu = random_sole(rng, 1)
    for sole in (Sole.of_corners(corners, mu), Sole.of_corners(corners, mu, 0.02)):
        wrenches = random_wrenches(rng, ClarabelSole(corners, mu), mu, 40)
        given, scale = sole._data, size(sole, wrenches)
        unsure = np.ones(40, dtype=bool)
        told = sole_proof.hold_in_digits(sole, given, wrenches, 1e-9, unsure)
        assert np.array_equal(told, sole.contains(wrenches))
        needs, shares = np.full(40, np.nan), np.empty((40, 3))
        sole_proof.measure_in_digits(sole, given, wrenches, needs, shares)
        assert np.allclose(needs, wrenches[:, 2] - sole.margin(wrenches), rtol=0, atol=2e-9 * scale)
        use = sole.use(wrenches)
        kinds = np.column_stack([use.friction, use.edge, use.yaw]) * wrenches[:, 2:3]
        held = wrenches[:, 2] > 0.0
        assert np.allclose(shares[held].sum(axis=1), kinds[held].sum(axis=1), rtol=0, atol=1e-6 * scale.max())
        needed = sole.friction_needed(wrenches)
        some = np.isfinite(needed) & (needed > 0.0)
        found = -np.where(some, 0.5 * needed, -1.0)
        sole_proof.frictions_in_digits(sole, given, wrenches, found)
        assert np.allclose(found[some], needed[some], rtol=1e-7, atol=0)


def test_what_each_limit_takes_alone():
    for load in (0.1, 400.0):
        assert sole_use([0.3 * load, 0.0, load, 0.0, 0.0, 0.0]) == pytest.approx(
            (0.5, 0.5, 0.0, 0.0), abs=1e-9
        )
        tip = [0.0, 0.0, load, 0.0, -0.055 * load, 0.0]
        assert sole_use(tip) == pytest.approx((0.5, 0.0, 0.5, 0.0), abs=1e-9)
        most = 0.6 * load * math.hypot(0.11, 0.045)  # pressed evenly, all corners slide about the middle
        yaw = [0.0, 0.0, load, 0.0, 0.0, 0.25 * most]
        assert sole_use(yaw) == pytest.approx((0.25, 0.0, 0.0, 0.25), abs=1e-9)
    assert SOLE.use([[55, 0, 100, 0, 0, 0], [0, 0, 1, 0, 0.1, 0], [0, 0, 1, 0, 0, 0.06]]).binds.tolist() == [
        "friction", "edge", "yaw",
    ]  # fmt: skip


def sole_use(wrench):
    use = SOLE.use(wrench)
    return tuple(float(v) for v in (use.total, use.friction, use.edge, use.yaw))


def test_shares_add_up_and_follow_the_margin():
    rng = np.random.default_rng(3)
    wrenches = rng.normal(size=(200, 6)) * [20, 20, 60, 2, 4, 1] + [0, 0, 150, 0, 0, 0]
    wrenches = wrenches[wrenches[:, 2] > 0.0]
    use = SOLE.use(wrenches)
    assert np.allclose(use.friction + use.edge + use.yaw, use.total, rtol=0, atol=1e-8)
    assert np.allclose(SOLE.margin(wrenches), wrenches[:, 2] * (1.0 - use.total), atol=1e-6)


def test_least_friction_is_where_the_margin_vanishes():
    rng = np.random.default_rng(4)
    wrenches = rng.normal(size=(100, 6)) * [40, 40, 60, 2, 4, 2] + [0, 0, 100, 0, 0, 0]
    needed = SOLE.friction_needed(wrenches)
    assert np.isfinite(needed).any()
    assert np.isinf(needed).any()
    for w, mu in zip(wrenches, needed, strict=True):
        if math.isfinite(mu):
            assert SOLE.with_friction(mu * (1 + 1e-6)).contains(w)
            assert not SOLE.with_friction(mu * (1 - 1e-5)).contains(w)
        else:
            assert SOLE.with_friction(1e6).margin(w) < 0.0
    assert SOLE.friction_needed([0, 0, 10, 0, 0, 0]) == 0.0
    assert SOLE.friction_needed(np.zeros(6)) == 0.0
    assert SOLE.friction_needed([0, 0, -1, 0, 0, 0]) == math.inf == SOLE.friction_needed([1, 0, 0, 0, 0, 0])


@pytest.mark.parametrize("sole", [SOLE, Sole(0.1, 0.3, 0.0), TRIANGLE])
def test_the_nearest_wrench_obeys_moreau(sole):
    """The rest is in the polar and orthogonal to the nearest, in the metric that the docstring states."""
    rng = np.random.default_rng(6)
    wrenches = rng.normal(size=(60, 6)) * [10, 10, 10, 1, 1, 1]
    near = sole.project(wrenches)
    assert sole.contains(near, 1e-7).all()
    for w, p in zip(wrenches, near, strict=True):
        rest, own = count_moments(sole, w - p), count_moments(sole, p)
        scale = size(sole, w)[0]
        assert abs(rest @ own) <= 1e-6 * scale**2
        # as a twist about the origin: moments over the radius, twice
        turn = rest[3:] / sole.radius
        twist = np.concatenate([rest[:3] - np.cross(turn, [*sole.centre, 0.0]), turn])
        assert sole.support(twist / scale, 1e-6) == 0.0
    inside = wrenches[sole.contains(wrenches)]
    assert np.allclose(sole.project(inside), inside, atol=1e-6)


def test_support_is_that_of_all_corner_forces():
    rng = np.random.default_rng(7)
    for _ in range(50):
        corners, mu = random_sole(rng, 1)
        sole = Sole.of_corners(corners, mu)
        twist = rng.normal(size=6) * [1, 1, 1, 10, 10, 10]
        most = -math.inf
        for x, y in corners:
            at = twist[:3] + np.cross(twist[3:], [x, y, 0.0])
            most = max(most, at[2] + mu * math.hypot(at[0], at[1]))
        down = twist - [0, 0, most, 0, 0, 0]  # moved until no corner resists
        assert sole.support(down - 1e-6 * np.eye(6)[2]) == 0.0
        assert sole.support(down + 1e-6 * np.eye(6)[2], 1e-9) == math.inf


def test_a_sole_has_no_unit_and_no_handedness():
    rng = np.random.default_rng(8)
    wrenches = rng.normal(size=(200, 6)) * [40, 40, 80, 3, 6, 3]
    told = SOLE.contains(wrenches, 0.0)
    for scale in (1e-140, 1e-9, 1e12, 1e140):
        assert np.array_equal(SOLE.contains(scale * wrenches, 0.0), told)
    mirror = [1, -1, 1, -1, 1, -1]
    assert np.allclose(SOLE.margin(wrenches * mirror), SOLE.margin(wrenches), atol=1e-6)
    # the same sole ten times as large
    assert np.array_equal(Sole(2.2, 0.9, 0.6).contains(wrenches * [1, 1, 1, 10, 10, 10], 0.0), told)
    # points within the corners change nothing, whatever their order
    crowd = np.vstack([SOLE.corners[[2, 0, 3, 1]], [[0, 0], [0.11, 0.0], [0.05, 0.02]]])
    assert np.allclose(Sole.of_corners(crowd, 0.6).corners, SOLE.corners)


def test_nothing_and_what_is_no_number():
    odd = np.array([[math.nan, 0, 1, 0, 0, 0], [0, 0, math.inf, 0, 0, 0], [0, 0, math.nan, 0, 0, 0]])
    assert not SOLE.contains(odd).any()
    assert np.isnan(SOLE.margin(odd)).all()
    assert np.isnan(SOLE.project(odd)).all()
    assert np.isnan(SOLE.friction_needed(odd)).all()
    zero = np.zeros(6)
    assert SOLE.contains(zero)
    assert SOLE.margin(zero) == 0.0
    assert np.array_equal(SOLE.project(zero), zero)
    assert SOLE.verdict(zero).holds
    assert SOLE.use(zero).total == 0.0
    assert SOLE.contains(np.zeros((0, 6))).shape == (0,)
    assert SOLE.margin(np.zeros((2, 3, 6))).shape == (2, 3)
    pull = [0.0, 0.0, -1.0, 0.0, 0.0, 0.0]
    assert not SOLE.contains(pull)
    assert SOLE.margin(pull) == -1.0
    assert SOLE.verdict(pull).holds is False
    slick = Sole(0.2, 0.1, 0.0)
    assert slick.contains([0, 0, 1, 0, -0.1, 0])
    assert not slick.contains([1e-6, 0, 1, 0, 0, 0])
    assert slick.verdict([0.1, 0, 1, 0, 0, 0]).holds is False
    assert slick.margin([0, 0, 2, 0, -0.1, 0]) == 1.0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: Sole(0.0, 0.1), "length must be positive"),
        (lambda: Sole(0.2, 0.1, math.inf), "a sole needs a finite mu"),
        (lambda: Sole(0.2, 0.1, -1.0), "mu must be"),
        (lambda: Sole(0.2, 0.1, 0.5, -1.0), "torsional_radius must be"),
        (lambda: Sole.of_corners([[0, 0], [1, 0], [2, 0]]), "three corners that are not in one line"),
        (lambda: Sole.of_corners([[0, 0], [0, 0]]), "three corners that are not in one line"),
        (lambda: Sole.of_corners([[0, 0, 0]]), "corners must have shape"),
        (lambda: SOLE.contains([1, 2, 3]), r"shape \(..., 6\)"),
        (lambda: SOLE.polyhedral(2), "facets"),
        (lambda: SOLE.polyhedral(8, "middle"), "fit"),
        (lambda: Sole(0.2, 0.1, 0.5, 0.01).polyhedral(8), "without a torsional radius"),
        (lambda: Sole.of_corners([[0, 0], [1, 0], [0, 1]]).closed_form(), "of a rectangle"),
    ],
)
def test_wrong_input_is_refused(call, said):
    with pytest.raises(ProblemError, match=said):
        call()


@pytest.mark.parametrize("fit", ["inner", "outer"])
@pytest.mark.parametrize("facets", [4, 5, 8])
def test_pyramids_are_on_the_side_they_say_by_no_more_than_they_say(facets, fit):
    rng = np.random.default_rng(9)
    for number in range(2):
        corners, mu = random_sole(rng, number)
        sole = Sole.of_corners(corners, mu)
        cone = sole.polyhedral(facets, fit)
        assert len(cone.names) == len(cone.halfspaces)
        judge = ClarabelSole(corners, mu)
        wrenches = random_wrenches(rng, judge, mu, 150, finest=1e-3)
        inner, outer = cone, sole
        if fit == "outer":
            inner, outer = sole, cone
        within = inner.contains(wrenches, 0.0)
        assert within.any()
        assert outer.contains(wrenches[within], 1e-9).all()
        # friction changed by the error turns the inclusion round
        share = 1.0 - cone.fit_error.radial if fit == "inner" else 1.0 + cone.fit_error.radial
        other = sole.with_friction(mu * share)
        small, large = (other, cone) if fit == "inner" else (cone, other)
        within = small.contains(wrenches, 0.0)
        assert within.any()
        assert large.contains(wrenches[within], 1e-9).all()


def test_rows_have_names_and_their_number_does_not_follow_friction():
    names = SOLE.closed_form("outer").names
    for name in ("tips over the toe edge", "tips over the left edge", "slides +x", "slides -y"):
        assert names.count(name) == 1
    assert sum(name.startswith("yaws") for name in names) == 8
    row = SOLE.closed_form("outer").halfspaces[names.index("slides -x")]
    assert float(row @ [0.6, 0.0, 1.0, 0.0, 0.0, 0.0]) == pytest.approx(0.0)  # friction +x stops a slip to -x
    counts = {len(SOLE.with_friction(mu).polyhedral(8).halfspaces) for mu in (0.0, 0.3, 5.0)}
    assert len(counts) == 1
    held = SOLE.with_friction(0.0).polyhedral(8)
    assert held.contains([0, 0, 1, 0.04, 0.1, 0])
    assert not held.contains([0, 0, 1, 0, 0, 1e-3])
    fine = SOLE.polyhedral(64)
    assert fine.contains(PUSH)
    assert 10_000 < len(fine.halfspaces) < 13_000
    assert "gives up up to 0.12 % of the friction" in repr(fine)


def test_the_closed_form_says_what_it_gives_up():
    cone = SOLE.closed_form()
    assert SOLE.contains(PUSH)
    assert not cone.contains(PUSH)
    assert "29 %" in repr(cone)
    assert len(cone.halfspaces) == 16
    assert cone.contains([0.6 * 100 / math.sqrt(2) - 1e-6, 0, 100, 0, 0, 0])
