"""Contact points of pairs against a distance by bounded least squares, and coal's contact patches."""

from __future__ import annotations

from types import SimpleNamespace

import coal
import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

from surefoot.mechanics.collision import Box, Capsule, Geometry, PairSearch, Solid, Sphere
from surefoot.mechanics.collision.pairs import FAR

SHAPES = {
    "box": Box((0.3, 0.2, 0.12)),
    "plate": Box((0.4, 0.4, 0.02)),
    "ball": Sphere(0.08),
    "capsule": Capsule(0.05, 0.25),
}
PAIRS = [(a, b) for k, a in enumerate(SHAPES) for b in list(SHAPES)[k:]]


def core_distance(half_a, R_a, c_a, half_b, R_b, c_b):
    """The distance of two boxes that do not overlap: min ||c_a + R_a x - c_b - R_b y||."""
    A = np.hstack([R_a, -R_b])
    limit = np.concatenate([half_a, half_b]) + 1e-15
    found = lsq_linear(A, c_b - c_a, (-limit, limit), method="bvls", tol=1e-15, max_iter=500)
    return float(np.linalg.norm(A @ found.x - (c_b - c_a)))


def outside(shape, R, c, point):
    """Signed distance of a point to a shape's surface, exact outside its core and on it."""
    away = np.abs(R.T @ (point - c)) - shape.core
    inside = min(away.max(), 0.0) if shape.core.all() else 0.0
    return float(np.linalg.norm(np.maximum(away, 0.0))) + inside - shape.radius


def search(one, two, reach=1.0):
    return PairSearch(Geometry((Solid("a", one, 1), Solid("b", two, 2))), reach)


def placed(R_a, c_a, R_b, c_b):
    """What Pinocchio's data.oMi would hold."""
    poses = [(np.eye(3), np.zeros(3)), (R_a, c_a), (R_b, c_b)]
    return [SimpleNamespace(rotation=R, translation=c) for R, c in poses]


def near_pose(rng, one, two):
    """Poses of two shapes at a small distance: random, face to face, or nearly so."""
    R_a = Rotation.random(random_state=rng).as_matrix()
    tilt = rng.choice([0.0, 1e-9, 1e-5, 2e-3, 0.3])
    R_b = R_a @ Rotation.from_rotvec(tilt * rng.normal(size=3)).as_matrix()
    if rng.random() < 0.3:
        R_b = Rotation.random(random_state=rng).as_matrix()
    elif rng.random() < 0.5:
        R_b = R_b @ Rotation.from_euler("xyz", 90.0 * rng.integers(4, size=3), degrees=True).as_matrix()
    c_a, way = rng.normal(size=3), rng.normal(size=3)
    if rng.random() < 0.5:
        way = R_a[:, rng.integers(3)] + 0.2 * way
    low, high, wanted = 0.0, 2.0, 10.0 ** rng.uniform(-5, -1.5)
    for _ in range(40):  # bisection for the wanted distance along the way
        middle = 0.5 * (low + high)
        far = core_distance(one.core, R_a, c_a, two.core, R_b, c_a + middle * way) - one.radius - two.radius
        low, high = (middle, high) if far < wanted else (low, middle)
    return R_a, c_a, R_b, c_a + high * way


@pytest.mark.parametrize(("first", "second"), PAIRS)
@pytest.mark.sampled(2)
def test_contacts_lie_on_both_surfaces(first, second):
    """The least gap is the distance of the two; where that is, both surfaces are half of it away.

    Contacts with a larger gap, as of the raised end of a capsule, may lie within the shapes, never outside.
    """
    one, two = SHAPES[first], SHAPES[second]
    rng, finder = np.random.default_rng([3, *map(ord, first + second)]), search(one, two)
    for _ in range(40):
        R_a, c_a, R_b, c_b = near_pose(rng, one, two)
        finder.update(placed(R_a, c_a, R_b, c_b))
        on = finder.on
        apart = core_distance(one.core, R_a, c_a, two.core, R_b, c_b) - one.radius - two.radius
        least = finder.gaps[on].min()
        assert abs(least - apart) < 2e-7 + 1e-3 * apart  # a normal within 1 mrad of a face's is taken for it
        for gap, point, normal in zip(finder.gaps[on], finder.points[on], finder.normals[on], strict=True):
            assert abs(np.linalg.norm(normal) - 1.0) < 1e-12
            off = np.array(
                [
                    outside(one, R_a, c_a, point - 0.5 * gap * normal),
                    outside(two, R_b, c_b, point + 0.5 * gap * normal),
                ]
            )
            assert off.max() < 5e-7
            if gap < least + 1e-6:
                assert off.min() > -5e-7


@pytest.mark.parametrize("seed", range(4))
def test_boxes_face_to_face_touch_where_coals_patch_says(seed):
    rng, (one, two) = np.random.default_rng(seed), (Box((0.3, 0.2, 0.1)), Box((0.2, 0.25, 0.1)))
    turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.1, 3.0)]).as_matrix()
    place = np.array([*rng.uniform(-0.08, 0.08, 2), 0.1])
    finder = search(one, two)
    finder.update(placed(np.eye(3), np.zeros(3), turn, place))
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    request.security_margin = 1e-3
    poses = coal.Transform3s(), coal.Transform3s(turn, place)
    coal.collide(one.solid(), poses[0], two.solid(), poses[1], request, result)
    patches = coal.ContactPatchResult()
    coal.computeContactPatch(
        one.solid(), poses[0], two.solid(), poses[1], result, coal.ContactPatchRequest(), patches
    )
    patch = patches.getContactPatch(0)
    expected = np.array([patch.getPoint(k) for k in range(patch.size())])
    found = finder.points[finder.on]
    assert len(found) == len(expected) >= 4
    apart = np.linalg.norm(found[:, None] - expected[None], axis=2)
    assert apart.min(axis=1).max() < 5e-6  # edges that cross at a small angle reach beyond by `SLACK`
    assert apart.min(axis=0).max() < 5e-6
    assert np.abs(finder.gaps[finder.on]).max() < 1e-12


def test_a_tilted_box_has_its_raised_side_in_the_air():
    """Where coal's patch puts all corners at one depth."""
    cube, tilt = Box((0.2, 0.2, 0.2)), 2e-3
    turn = Rotation.from_rotvec([0.0, tilt, 0.0]).as_matrix()
    finder = search(Box((1.0, 1.0, 0.2)), cube)
    finder.update(
        placed(np.eye(3), np.zeros(3), turn, np.array([0.0, 0.0, 0.1 + 0.1 * (np.cos(tilt) + np.sin(tilt))]))
    )
    gaps = np.sort(finder.gaps[finder.on])
    np.testing.assert_allclose(gaps, [0.0, 0.0, 0.2 * np.sin(tilt), 0.2 * np.sin(tilt)], atol=1e-12)


def test_edges_that_lie_on_edges_are_four_corners_however_they_shake():
    cube, rng, finder = Box((0.2, 0.2, 0.2)), np.random.default_rng(0), search(*2 * (Box((0.2, 0.2, 0.2)),))
    for _ in range(50):
        place = np.array([0.0, 0.0, 0.2]) + 1e-12 * rng.normal(size=3)
        finder.update(placed(np.eye(3), np.zeros(3), np.eye(3), place))
        assert finder.on.sum() == 4
        assert np.abs(finder.gaps[finder.on]).max() < 1e-11
        assert (np.abs(finder.points[finder.on][:, :2]) > 0.5 * cube.size[0] - 1e-9).all()


def test_parallel_capsules_touch_at_both_ends_of_their_overlap():
    one, two = Capsule(0.05, 0.3), Capsule(0.03, 0.3)
    finder = search(one, two)
    finder.update(placed(np.eye(3), np.zeros(3), np.eye(3), np.array([0.08, 0.0, 0.1])))
    ends = finder.points[finder.on][:, 2]
    assert finder.on.sum() == 3
    np.testing.assert_allclose([ends.min(), ends.max()], [-0.05, 0.15], atol=1e-9)
    np.testing.assert_allclose(finder.gaps[finder.on], 0.0, atol=1e-9)


def test_what_is_out_of_reach_has_no_contact():
    finder = search(Sphere(0.1), Sphere(0.1), reach=0.05)
    finder.update(placed(np.eye(3), np.zeros(3), np.eye(3), np.array([0.3, 0.0, 0.0])))
    assert not finder.on.any()
    assert (finder.gaps == FAR).all()


@pytest.mark.parametrize(("one", "two"), [(Sphere(0.1), Sphere(0.05)), (Box((0.2, 0.2, 0.2)), Sphere(0.05))])
def test_bodies_within_each_other_have_a_finite_way_out(one, two):
    finder = search(one, two)
    finder.update(placed(np.eye(3), np.zeros(3), np.eye(3), np.zeros(3)))
    assert finder.gaps[finder.on].max() < -0.1
    np.testing.assert_allclose(np.linalg.norm(finder.normals[finder.on], axis=1), 1.0)
