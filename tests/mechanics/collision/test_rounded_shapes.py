from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.collision import Box, Capsule, Sphere


@pytest.mark.parametrize(
    ("shape", "inertia"),
    [
        (Sphere(0.13), pinocchio.Inertia.FromSphere(2.5, 0.13)),
        (Box((0.4, 0.3, 0.2)), pinocchio.Inertia.FromBox(2.5, 0.4, 0.3, 0.2)),
        (Capsule(0.07, 0.31), pinocchio.Inertia.FromCapsule(2.5, 0.07, 0.31)),
        (Capsule(0.2, 0.01), pinocchio.Inertia.FromCapsule(2.5, 0.2, 0.01)),
    ],
)
def test_moments_are_pinocchios(shape, inertia):
    np.testing.assert_allclose(np.diag(shape.moments(2.5)), inertia.inertia, rtol=1e-12)


@pytest.mark.parametrize("shape", [Sphere(0.1), Box((0.4, 0.3, 0.2)), Capsule(0.05, 0.3)])
def test_knots_reach_as_far_as_coals_shape(shape):
    """The hull of spheres at the knots and coal's own bounding box are the same along every axis."""
    solid = shape.solid()
    solid.computeLocalAABB()
    knots = shape.knots()
    np.testing.assert_allclose(knots.max(axis=0) + shape.radius, np.array(solid.aabb_local.max_), atol=1e-15)
    np.testing.assert_allclose(knots.min(axis=0) - shape.radius, np.array(solid.aabb_local.min_), atol=1e-15)
    assert len(np.unique(knots, axis=0)) == len(knots) == 2 ** np.count_nonzero(shape.core)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Sphere(0.0),
        lambda: Sphere(np.nan),
        lambda: Sphere(np.inf),
        lambda: Box((0.1, 0.1, -0.1)),
        lambda: Box((0.1, 0.1)),
        lambda: Capsule(0.1, 0.0),
    ],
)
def test_sizes_must_be_sizes(wrong):
    with pytest.raises(ProblemError):
        wrong()
