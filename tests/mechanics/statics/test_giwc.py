"""The wrench cone of a stance against can_stand and cddlib."""

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.stances import random_case
from benchmarks.statics.rivals import cddlib_rows
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.statics.wrench_cone import wrench_cone_size
from tests.contact.cones.test_representation import representation_gap


@pytest.mark.parametrize("method", ["qhull", "cdd"])
@pytest.mark.parametrize("kind", ["flat", "tilted", "chimney", "patches"])
def test_contains_is_the_verdict_over_pyramids(kind, method):
    if method == "cdd":
        pytest.importorskip("cdd")
    rng = np.random.default_rng(0)
    answers = []
    for _ in range(4):
        case = random_case(rng, kind, contacts=3)
        cone = sf.wrench_cone(case.stance, case.com, facets=6, method=method)
        weight = np.array([0, 0, case.mass * GRAVITY, 0, 0, 0])
        for _ in range(25):
            mix = cone.rays.T @ rng.exponential(size=len(cone.rays)) ** 2
            noise = rng.normal(size=6) * np.array([1, 1, 1, 0.1, 0.1, 0.1]) * rng.choice([0.01, 0.1, 0.3])
            load = weight[2] * (mix / np.linalg.norm(mix) + noise)
            verdict = sf.can_stand(case.stance, case.com, case.mass, weight - load, facets=6)
            if abs(verdict.margin) > 1e-6 * np.linalg.norm(load):
                assert bool(cone.contains(load)) == bool(verdict)
                answers.append(bool(verdict))
    assert 0.1 < np.mean(answers) < 0.95


def test_rows_equal_cddlibs():
    pytest.importorskip("cdd")
    rng = np.random.default_rng(1)
    for kind in ("flat", "tilted"):
        case = random_case(rng, kind, contacts=4)
        cone = sf.wrench_cone(case.stance, case.com, facets=8)
        theirs = cddlib_rows(cone.rays)()
        theirs /= np.linalg.norm(theirs, axis=1, keepdims=True)
        assert len(theirs) == len(cone.halfspaces)
        gaps = np.abs(theirs[:, None] - cone.halfspaces[None]).max(axis=2)
        assert gaps.min(axis=1).max() < 1e-8


def test_two_points_have_no_moment_about_their_line():
    stance = sf.Stance([sf.PointContact([x, 0, 0]) for x in (-0.2, 0.2)])
    cone = sf.wrench_cone(stance, [0, 0, 0.3])
    assert cone.contains([0, 0, 100, 0, 0, 0])
    assert not cone.contains([0, 0, 100, 1.0, 0, 0])
    assert representation_gap(cone.halfspaces, cone.rays) < 1e-9


def test_no_contacts_and_no_friction():
    nothing = sf.wrench_cone(sf.Stance([]))
    assert nothing.contains(np.zeros(6))
    assert not nothing.contains([0, 0, 1e-3, 0, 0, 0])
    slippery = sf.Stance([sf.PointContact([x, y, 0], mu=0.0) for x in (-1, 1) for y in (-1, 1)])
    cone = sf.wrench_cone(slippery)
    assert len(cone.rays) == 4
    assert cone.contains([0, 0, 10, 5, 5, 0])
    assert not cone.contains([0.1, 0, 10, 0, 0, 0])


def test_growth_is_reported_before_it_explodes():
    patches = sf.Stance([sf.SoleContact([k, 0, 0], sf.Sole(0.2, 0.1)) for k in range(6)])
    size = wrench_cone_size(patches, facets=8)
    assert size.rays == 6 * 4 * 8
    assert size.most_rows > 30_000
    cone = sf.wrench_cone(patches, facets=8, most_rows=20_000)
    assert cone.contains([0, 0, 1, 0, -2.5, 0])
    assert not cone.contains([0, 0, 1, 0, 1, 0])
    with pytest.raises(ProblemError, match=r"192 rays may have up to .* half-spaces"):
        _ = cone.halfspaces
    few = wrench_cone_size(sf.Stance([sf.PointContact([0, 0, 0])]), facets=4)
    assert few.rays == 4
    rng = np.random.default_rng(2)
    for kind in ("flat", "tilted"):
        case = random_case(rng, kind, contacts=4)
        bound = wrench_cone_size(case.stance, 8).most_rows
        assert len(sf.wrench_cone(case.stance, facets=8).halfspaces) <= bound
