"""Friction cones, their pyramids and the compiled projections against independent oracles."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from surefoot import FrictionCone, ProblemError
from surefoot.base.kernels import kernel
from surefoot.base.numerics.projection import project_cone, project_truncated
from tests.contact.cones.test_representation import representation_gap


@kernel
def call_cone(f, mu):
    return project_cone(f[0], f[1], f[2], mu)


@kernel
def call_truncated(f, mu, low, high):
    return project_truncated(f[0], f[1], f[2], mu, low, high)


def test_compiled_projection_equals_the_class():
    rng = np.random.default_rng(0)
    for mu in (0.0, 0.3, 1.0, 5.0):
        forces = np.vstack([rng.normal(size=(300, 3)) * [10, 10, 10], [0.0, 0.0, -1.0]])
        ours = np.array([call_cone(f, mu) for f in forces])
        np.testing.assert_allclose(ours, FrictionCone(mu).project(forces), atol=1e-12)


@pytest.mark.parametrize(("low", "high"), [(0.0, 5.0), (2.0, 5.0), (3.0, 3.0), (1.0, math.inf)])
def test_truncated_projection_is_the_nearest_point(low, high):
    """Compared with a general optimiser over (angle, share of the cone, height)."""
    rng = np.random.default_rng(1)
    mu = 0.7
    for force in rng.normal(size=(25, 3)) * 5.0:
        ours = np.array(call_truncated(force, mu, low, high))
        assert np.hypot(ours[0], ours[1]) <= mu * ours[2] + 1e-12
        assert low - 1e-12 <= ours[2] <= high + 1e-12
        top = min(high, 50.0)
        angle = math.atan2(force[1], force[0])

        def away(p, angle=angle, force=force):
            side = mu * p[0] * p[1]
            return np.sum((np.array([side * np.cos(angle), side * np.sin(angle), p[1]]) - force) ** 2)

        best = min(
            minimize(away, [s, h], bounds=[(0, 1), (low, top)], tol=1e-14).fun
            for s in (0.1, 0.9)
            for h in (low, 0.5 * (low + top))
        )
        assert np.sum((ours - force) ** 2) <= best + 1e-7


def test_use():
    cone = FrictionCone(1.0)
    assert cone.use([3.0, 4.0, 10.0]) == pytest.approx(0.5)
    assert cone.use([0.0, 0.0, 0.0]) == 0.0
    assert math.isinf(cone.use([0.0, 1.0, -1.0]))
    assert math.isinf(FrictionCone(0.0).use([1.0, 0.0, 1.0]))


@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_pyramid_rows_and_rays_describe_one_cone(fit):
    for facets in (3, 4, 7, 8):
        pyramid = FrictionCone(0.6).polyhedral(facets, fit, 0.4)
        assert representation_gap(pyramid.halfspaces, pyramid.rays) < 1e-12
        assert pyramid.halfspaces.shape == pyramid.rays.shape == (facets, 3)
        np.testing.assert_allclose(np.hypot(*pyramid.halfspaces[:, :2].T), 1.0)


def test_turning_an_outer_pyramid_moves_its_overshoot_only():
    for phase in (0.0, math.pi / 4):
        pyramid = FrictionCone(0.6).polyhedral(4, "outer", phase)
        worst = np.hypot(*pyramid.rays[:, :2].T).max() / 0.6 - 1.0
        assert worst == pytest.approx(math.sqrt(2.0) - 1.0)


def test_bad_pyramids_are_named():
    with pytest.raises(ProblemError, match="inner, outer"):
        FrictionCone(0.5).polyhedral(8, "middle")
    with pytest.raises(ProblemError, match="finite mu"):
        FrictionCone(math.inf).polyhedral(8)
