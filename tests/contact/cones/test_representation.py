"""Rays to half-spaces and back, for every shape of cone."""

import numpy as np
import pytest

from surefoot import ProblemError
from surefoot.contact.cones.nearest import nearest_in_cone
from surefoot.contact.cones.polyhedral import PolyhedralCone
from surefoot.contact.cones.representation import _directions, _distinct, convert

KINDS = ("plain", "upward", "flat", "line inside", "redundant", "long and short", "units", "integer", "thin")


def random_rays(rng, kind):
    """Return random rays in up to six dimensions, pointed or not, some of them nearly degenerate."""
    dim, count = int(rng.integers(1, 7)), int(rng.integers(0, 15))
    V = rng.normal(size=(count, dim))
    if kind == "integer":
        return rng.integers(-1, 2, size=(count, dim)).astype(float)
    if kind == "flat":
        V[:, 0] = 0.0
    if kind == "line inside" and count > 1:
        V[1] = -V[0]
    if kind == "redundant" and count > 2:
        V[2] = V[0] + V[1]
    if kind in ("upward", "long and short", "units", "thin"):
        V[:, -1] = np.abs(V[:, -1]) + 0.5
    if kind == "long and short":
        V *= 10.0 ** rng.uniform(-6, 6, size=(count, 1))
    if kind == "units":
        V *= 10.0 ** rng.uniform(-3, 3, size=dim)
    if kind == "thin" and count:
        V[1:] = V[:1] + V[1:] * 10.0 ** rng.uniform(-6, -2)
    return V


def representation_gap(halfspaces, rays, samples=0):
    """Return how far two representations are from one cone, as an angle [rad], both ways."""
    V, H = _directions(rays)[0], _directions(halfspaces)[0]
    outside = float((V @ H.T).max(initial=0.0)) if len(V) and len(H) else 0.0
    draws = np.random.default_rng(0).normal(size=(samples, rays.shape[1]))
    points = np.vstack([convert(halfspaces)[0], draws - nearest_in_cone(H, draws)])
    size = np.linalg.norm(points, axis=1)
    points = points[size > 1e-9] / size[size > 1e-9, None]
    lack = np.linalg.norm(points - nearest_in_cone(V, points), axis=1)
    return max(outside, float(lack.max(initial=0.0)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.sampled(2)
def test_both_representations_describe_one_set(kind):
    """The self-check on a thousand random cones over all kinds."""
    rng = np.random.default_rng(KINDS.index(kind))
    for _ in range(120):
        V = random_rays(rng, kind)
        cone = PolyhedralCone.from_rays(V)
        assert representation_gap(cone.halfspaces, V) < 1e-7
        assert representation_gap(cone.halfspaces, cone.rays) < 1e-7


@pytest.mark.parametrize("method", ["qhull", "cdd"])
def test_engines_agree_with_distances_to_the_rays(method):
    """Non-negative least squares on the rays knows nothing of facets, nor of the engine that found them."""
    if method == "cdd":
        pytest.importorskip("cdd")
    rng = np.random.default_rng(5)
    for _ in range(60):
        dim = int(rng.integers(2, 5))
        V = rng.integers(-3, 4, size=(int(rng.integers(1, 8)), dim)).astype(float)
        cone = PolyhedralCone.from_rays(V, method)
        assert representation_gap(cone.halfspaces, V) < 1e-9
        points = np.vstack([rng.normal(size=(50, dim)), rng.uniform(size=(50, len(V))) @ V])
        distance = np.linalg.norm(points - nearest_in_cone(V, points), axis=1)
        sure = (distance < 1e-12) | (distance > 1e-6)
        assert sure.sum() > 50
        assert np.array_equal(cone.contains(points)[sure], distance[sure] < 1e-12)


def test_rows_and_rays_that_are_redundant_go():
    pyramid = [[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1]]
    cone = PolyhedralCone.from_rays([*pyramid, [0, 0, 1], [0.3, 0.2, 1], [2, 0, 2], [0, 0, 0]])
    assert (len(cone.rays), len(cone.halfspaces)) == (4, 4)
    again = PolyhedralCone.from_halfspaces(np.vstack([cone.halfspaces, [[0, 0, -1]], 5 * cone.halfspaces]))
    assert (len(again.rays), len(again.halfspaces)) == (4, 4)


@pytest.mark.parametrize(
    ("rays", "rows", "inside", "outside"),
    [
        (np.vstack([np.eye(3), -np.ones(3)]), 0, [[1, -2, 3], [0, 0, -9]], []),  # the whole space
        (
            np.array([[1.0, 2, 3], [-1, -2, -3]]),
            4,
            [[2, 4, 6], [-1, -2, -3]],
            [[1, 2, 3.1], [1, 0, 0]],
        ),  # a line
        (
            np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]),
            1,
            [[3, -4, 0]],
            [[0, 0, -1]],
        ),
        (np.array([[0.0, 0, 2]]), 5, [[0, 0, 3]], [[0, 0, -1], [0.1, 0, 1]]),  # a ray
        (np.zeros((0, 3)), 6, [[0, 0, 0]], [[0, 0, 1e-3]]),  # nothing
        (np.zeros((2, 3)), 6, [[0, 0, 0]], [[1, 0, 0]]),
    ],
)
def test_cones_that_are_not_pointed(rays, rows, inside, outside):
    cone = PolyhedralCone.from_rays(rays)
    assert len(convert(rays)[0]) <= rows
    for x in inside:
        assert cone.contains(x)
        np.testing.assert_allclose(cone.project(x), x, atol=1e-9)
    for x in outside:
        assert not cone.contains(x)
    assert representation_gap(cone.halfspaces, cone.rays, 10) < 1e-9


def test_force_closure_is_the_whole_space():
    """Two opposing points with friction, and a third off their line, resist any wrench."""
    import surefoot as sf

    contacts = [
        sf.PointContact([-0.3, 0, 0], [1, 0, 0], mu=0.8),
        sf.PointContact([0.3, 0.1, 0], [-1, 0, 0], mu=0.8),
        sf.PointContact([0.3, -0.1, 0.1], [-1, 0, 0], mu=0.8),
    ]
    cone = sf.wrench_cone(sf.Stance(contacts), facets=6)
    assert len(cone.halfspaces) == 0
    assert np.all(cone.contains(np.random.default_rng(0).normal(size=(20, 6))))


def test_scale_of_rays_and_units_do_not_matter():
    rng = np.random.default_rng(3)
    V = rng.normal(size=(12, 6))
    V[:, 2] = np.abs(V[:, 2]) + 1.0
    reference = convert(V)[0]
    for unit in (1e-6, 1e-3, 1e3):
        scale = np.array([1, 1, 1, unit, unit, unit])
        H = convert(V * scale * 10.0 ** rng.uniform(-5, 5, size=(12, 1)))[0]
        assert len(H) == len(reference)
        back = H * scale
        back /= np.linalg.norm(back, axis=1, keepdims=True)
        nearest = np.abs(back[:, None] - reference[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 1e-7


def test_rows_that_repeat_to_the_last_bit_are_compared_once(monkeypatch):
    """Qhull repeats a facet for each of its simplices; pairs are for rows that rounding keeps apart."""
    rows, passes = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0], []
    monkeypatch.setattr(np, "flatnonzero", lambda mask: passes.append(mask) or mask.nonzero()[0])
    assert len(_distinct(np.repeat(rows, 50, axis=0))) == 6
    assert not passes
    assert len(_distinct(np.vstack([rows, rows + 1e-13]))) == 6


def test_self_check_sees_wrong_representations():
    good = PolyhedralCone.from_rays([[1, 0, 1], [0, 1, 1], [-1, 0, 1], [0, -1, 1]])
    assert representation_gap(good.halfspaces[:3], good.rays) > 0.1  # a facet is missing
    assert representation_gap(good.halfspaces, good.rays[:3]) > 0.1  # a ray is missing
    assert representation_gap(-good.halfspaces, good.rays) > 0.1


def test_a_cone_that_no_linear_program_can_tell_about_is_taken_for_its_whole_space(monkeypatch):
    import scipy.optimize

    angles = np.radians(np.linspace(0.0, 179.0, 10))  # nearly a half-plane: the mean does not show its axis
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    assert len(convert(rays)[0]) == 2
    failed = scipy.optimize.OptimizeResult(x=None, status=4)
    monkeypatch.setattr(scipy.optimize, "linprog", lambda *_, **__: failed)
    rows, kept = convert(rays)
    assert rows.shape == (0, 2)
    assert kept.tolist() == list(range(10))


def test_unknown_method_and_bad_rays_are_named():
    with pytest.raises(ProblemError, match="cdd, qhull"):
        PolyhedralCone.from_rays(np.eye(2), "magic")
    with pytest.raises(ProblemError, match="rays"):
        PolyhedralCone.from_rays([[1.0, np.nan]])
    with pytest.raises(ProblemError, match="same dimension"):
        PolyhedralCone(np.eye(2), np.eye(3))
