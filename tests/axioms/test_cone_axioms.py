"""The axioms of a closed convex cone, for every cone class of the package."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefoot.base.errors import ProblemError
from surefoot.contact.cones import FrictionCone, PolyhedralCone, ProductCone, Sole
from tests.pages import blocks, run_page

RNG = np.random.default_rng(7)
SHOWN = run_page("add-a-cone.md")
"""What the page about new cones defines and works out."""
FAMILY = {
    "friction": FrictionCone(0.6),
    "friction, wide": FrictionCone(1e160),
    "friction, none": FrictionCone(0.0),
    "friction, half-space": FrictionCone(math.inf),
    "pyramid, inner": FrictionCone(0.6).polyhedral(5, "inner", 0.3),
    "pyramid, outer": FrictionCone(0.8).polyhedral(8, "outer", 0.1),
    "pyramid, none": FrictionCone(0.0).polyhedral(4),
    "wrench, coupled": Sole(0.2, 0.1, 0.6).closed_form(),
    "wrench, outer": Sole(0.1, 0.3, 0.9).closed_form("outer"),
    "polyhedral, random": PolyhedralCone.from_rays(RNG.normal(size=(7, 4)) + np.array([0, 0, 0, 3])),
    "polyhedral, flat": PolyhedralCone.from_rays([[1, 0, 0], [0, 1, 0]]),
    "polyhedral, line": PolyhedralCone.from_rays([[1, 2, 3], [-1, -2, -3]]),
    "polyhedral, half-space": PolyhedralCone.from_halfspaces([[0, 0, -1]]),
    "polyhedral, space": PolyhedralCone.from_rays(np.vstack([np.eye(3), -np.ones(3)])),
    "polyhedral, zero": PolyhedralCone.from_rays(np.zeros((0, 3))),
    "the page's, of a friction cone": SHOWN["wall"],
    "the page's, of a sole": SHOWN["TurnedCone"](Sole(0.2, 0.1, 0.6).closed_form(), SHOWN["turn"]),
    "product": ProductCone([FrictionCone(3.0), Sole(0.2, 0.1, 0.4).closed_form(), FrictionCone(0.9)]),
}
cones = pytest.mark.parametrize("cone", FAMILY.values(), ids=FAMILY.keys())
seeds = st.integers(0, 2**32 - 1)


def draws(cone, seed, count=8):
    """Return random points inside, outside and near the boundary, the apex, and all axes downwards."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, cone.dim)) * 10.0 ** rng.uniform(-1, 2, size=(count, 1))
    return np.vstack([points, cone.project(points[: count // 2]), np.zeros((1, cone.dim)), -np.eye(cone.dim)])


def size(x):
    return 1e-9 * np.maximum(1.0, np.linalg.norm(x, axis=-1))


@cones
@settings(max_examples=12, deadline=None)
@given(seed=seeds)
def test_projection_is_in_the_cone_and_idempotent(cone, seed):
    x = draws(cone, seed)
    p = cone.project(x)
    assert np.all(cone.contains(p, 1e-9))
    assert np.all(np.linalg.norm(cone.project(p) - p, axis=-1) <= 10 * size(x))


@cones
@settings(max_examples=12, deadline=None)
@given(seed=seeds)
def test_moreau_decomposition(cone, seed):
    x = draws(cone, seed)
    p, q = cone.project(x), cone.dual().project(-x)
    assert np.all(np.linalg.norm(x - (p - q), axis=-1) <= 10 * size(x))
    assert np.all(
        np.abs(np.sum(p * q, axis=-1)) <= 10 * size(x) * np.maximum(1.0, np.linalg.norm(x, axis=-1))
    )


@cones
@settings(max_examples=8, deadline=None)
@given(seed=seeds)
def test_dual_of_dual_is_the_cone(cone, seed):
    x = draws(cone, seed)
    twice = cone.dual().dual()
    assert np.array_equal(cone.contains(x, 1e-7), twice.contains(x, 1e-7))
    assert np.all(np.linalg.norm(cone.project(x) - twice.project(x), axis=-1) <= 10 * size(x))


@cones
@settings(max_examples=8, deadline=None)
@given(seed=seeds, other=seeds)
def test_no_dual_vector_works_against_the_cone(cone, seed, other):
    inside, dual = cone.project(draws(cone, seed)), cone.dual().project(draws(cone, other))
    work = inside @ dual.T
    scale = np.linalg.norm(inside, axis=1)[:, None] * np.linalg.norm(dual, axis=1)[None]
    assert np.all(work >= -1e-9 * np.maximum(1.0, scale))


@cones
@settings(max_examples=8, deadline=None)
@given(seed=seeds, other=seeds)
def test_margin_is_the_distance_to_the_boundary(cone, seed, other):
    x = draws(cone, seed)
    margin = cone.margin(x)
    distance = np.linalg.norm(x - cone.project(x), axis=-1)
    outside = distance > size(x)
    assert np.all(np.abs(margin[outside] + distance[outside]) <= 10 * size(x)[outside])
    assert np.all(margin[~outside] >= -size(x)[~outside])
    ball = np.random.default_rng(other).normal(size=x.shape)
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    room = (margin > 0.0) & np.isfinite(margin)
    assert np.all(cone.contains((x + margin[:, None] * ball)[room], 1e-9))
    # and no larger ball fits: some unit vector of the dual reaches the margin
    dual = cone.dual().project(draws(cone, other, 40))
    length = np.linalg.norm(dual, axis=1)
    unit = dual[length > 1e-6] / length[length > 1e-6, None]
    if len(unit):
        assert np.all((x @ unit.T).min(axis=1) >= margin - 10 * size(x))


@cones
@settings(max_examples=8, deadline=None)
@given(seed=seeds, factor=st.floats(1e-6, 1e6))
def test_cones_are_cones(cone, seed, factor):
    x = draws(cone, seed)
    p, q = cone.project(x), cone.project(factor * x)
    assert np.all(
        np.linalg.norm(q - factor * p, axis=-1)
        <= 1e-9 * factor * np.maximum(1e-9, np.linalg.norm(x, axis=-1)) + 1e-14
    )


@cones
def test_support_is_zero_on_the_polar_and_infinite_elsewhere(cone):
    polar = -cone.dual().project(draws(cone, 3))
    assert np.all(cone.support(polar, 1e-7) == 0.0)
    inside = cone.project(draws(cone, 4))
    climbs = inside[np.linalg.norm(inside, axis=1) > 1e-3]
    assert np.all(np.isinf(cone.support(climbs)))  # x . x > 0


@cones
def test_batches_equal_single_calls(cone):
    x = draws(cone, 5)
    grid = np.stack([x, 2.0 * x])
    assert cone.project(grid).shape == grid.shape
    assert cone.margin(grid).shape == grid.shape[:-1]
    assert cone.contains(grid).shape == grid.shape[:-1]
    single = np.array([cone.project(v) for v in x])
    np.testing.assert_allclose(cone.project(grid)[0], single, atol=1e-12)
    np.testing.assert_allclose(cone.margin(grid)[0], [cone.margin(v) for v in x], atol=1e-9)


@cones
def test_wrong_dimension_is_refused(cone):
    with pytest.raises(ProblemError, match=f"shape .*{cone.dim}"):
        cone.project(np.zeros(cone.dim + 1))


@settings(max_examples=60, deadline=None)
@given(
    seed=seeds,
    facets=st.integers(3, 24),
    mu=st.floats(0.01, 3.0),
    phase=st.floats(-4.0, 4.0),
)
def test_inner_inside_exact_inside_outer(seed, facets, mu, phase):
    exact = FrictionCone(mu)
    inner, outer = exact.polyhedral(facets, "inner", phase), exact.polyhedral(facets, "outer", phase)
    forces = np.random.default_rng(seed).normal(size=(200, 3)) * [mu, mu, 1.0]
    is_inner, is_exact, is_outer = (c.contains(forces, 1e-12) for c in (inner, exact, outer))
    assert np.all(is_exact[is_inner])
    assert np.all(is_outer[is_exact])
    assert np.all(exact.contains(inner.rays))
    assert np.all(outer.contains(exact.project(forces)))


@pytest.mark.parametrize("fit", ["inner", "outer"])
@pytest.mark.parametrize("facets", [3, 4, 6, 8, 16, 64])
def test_fit_errors_equal_the_closed_forms_and_what_is_measured(facets, fit):
    mu = 0.7
    pyramid = FrictionCone(mu).polyhedral(facets, fit, 0.2)
    angle = 0.2 + np.linspace(0.0, 2.0 * np.pi, 73729)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    tangential, limit = pyramid.halfspaces @ ring.T, -pyramid.halfspaces[:, 2:3]
    reach = np.min(np.where(tangential > 1e-12, limit / np.maximum(tangential, 1e-12), np.inf), axis=0)
    radial = np.max(1.0 - reach / mu) if fit == "inner" else np.max(reach / mu - 1.0)
    half = math.pi / facets
    form = 1.0 - math.cos(half) if fit == "inner" else 1.0 / math.cos(half) - 1.0
    assert pyramid.fit_error.radial == pytest.approx(form, rel=1e-12)
    assert radial == pytest.approx(form, rel=1e-9)
    area = abs(0.5 * np.sum(reach[:-1] * reach[1:] * np.sin(np.diff(angle))) / (math.pi * mu**2) - 1.0)
    assert pyramid.fit_error.area == pytest.approx(area, rel=1e-2)


def test_the_page_says_what_its_cone_does():
    wall = SHOWN["wall"]
    assert len(blocks("add-a-cone.md")) == 2
    assert wall.contains([10.0, 0.0, 4.9])
    assert not wall.contains([10.0, 0.0, 5.1])
    assert wall.project([10.0, 0.0, 10.0]) == pytest.approx([12.0, 0.0, 6.0])


@pytest.mark.parametrize(
    ("cone", "rotation", "message"),
    [
        (FrictionCone(0.6), -np.eye(3), "rotation must be"),
        (FrictionCone(0.6), 2.0 * np.eye(3), "rotation must be"),
        (FrictionCone(0.6), np.full((3, 3), np.nan), "is NaN"),
        (PolyhedralCone.from_rays(np.eye(4)), np.eye(3), "multiple of 3"),
    ],
)
def test_the_pages_cone_refuses_what_is_none(cone, rotation, message):
    with pytest.raises(ProblemError, match=message):
        SHOWN["TurnedCone"](cone, rotation)
