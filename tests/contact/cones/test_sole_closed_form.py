"""The closed form of a rectangular sole's cone against the sum of its corners' pyramids."""

import numpy as np
import pytest
from scipy.optimize import linprog

from surefoot import FrictionCone, ProblemError, Sole
from surefoot.contact.cones import PolyhedralCone
from tests.contact.cones.test_representation import representation_gap


def corner_wrenches(length, width, mu, fit):
    """Return the wrenches of every corner pyramid's edges, written from the mechanics alone."""
    side = mu / np.sqrt(2.0) if fit == "inner" else mu
    out = []
    for sx in (-0.5, 0.5):
        for sy in (-0.5, 0.5):
            arm = np.array([sx * length, sy * width, 0.0])
            for fx in (-side, side):
                for fy in (-side, side):
                    force = np.array([fx, fy, 1.0])
                    out.append(np.concatenate([force, np.cross(arm, force)]))
    return np.array(out)


def reachable(rays, wrench):
    return (
        linprog(np.zeros(len(rays)), A_eq=rays.T, b_eq=wrench, bounds=(0, None), method="highs").status == 0
    )


@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_rows_and_corner_sum_agree_both_ways(fit):
    rng = np.random.default_rng(0)
    inside = 0
    for _ in range(400):
        length, width, mu = rng.uniform(0.05, 0.4), rng.uniform(0.05, 0.4), rng.uniform(0.1, 1.2)
        cone = Sole(length, width, mu).closed_form(fit)
        rays = corner_wrenches(length, width, mu, fit)
        made = rays.T @ rng.exponential(size=len(rays)) ** 3
        assert np.all(cone.halfspaces @ made <= 1e-9 * np.abs(made).max())
        scale = [mu, mu, 1.0, width / 2, length / 2, mu * (length + width) / 2]
        wrench = 100.0 * np.array([*rng.uniform(-0.7, 0.7, 2), 1.0, *rng.uniform(-0.8, 0.8, 3)]) * scale
        slack = np.max(cone.halfspaces @ wrench)
        if abs(slack) > 1e-6:
            assert (slack < 0.0) == reachable(rays, wrench)
            inside += slack < 0.0
    assert 40 < inside < 360


def test_rows_and_rays_describe_one_cone_without_redundancy():
    cone = Sole(0.2, 0.1, 0.6).closed_form()
    assert representation_gap(cone.halfspaces, cone.rays, 20) < 1e-9
    least = PolyhedralCone.from_rays(cone.rays)
    assert len(least.halfspaces) == len(cone.halfspaces)
    assert len(least.rays) == len(cone.rays)


def test_pressure_on_the_edge_is_an_equality():
    """Half sizes 0.1 m and 0.05 m, mu 0.6: each edge of the sole makes one row tight."""
    cone = Sole(length=0.2, width=0.1, mu=0.6).closed_form()
    for x, y in ((0.1, 0.0), (-0.1, 0.0), (0.0, 0.05), (0.0, -0.05)):
        force = np.array([0.0, 0.0, 100.0])
        wrench = np.concatenate([force, np.cross([x, y, 0.0], force)])
        assert np.max(cone.halfspaces @ wrench) == pytest.approx(0.0, abs=1e-12)
        assert not cone.contains(wrench + np.concatenate([np.zeros(3), 1e-6 * wrench[3:]]), 1e-9)
        assert cone.margin(wrench) == pytest.approx(0.0, abs=1e-12)


def test_inner_cone_never_promises_what_exact_corner_cones_cannot_give():
    cone = Sole(0.2, 0.1, 0.6).closed_form()
    exact = FrictionCone(0.6)
    for ray in corner_wrenches(0.2, 0.1, 0.6, "inner"):
        assert exact.contains(ray[:3])
    assert np.all(cone.contains(corner_wrenches(0.2, 0.1, 0.6, "inner")))
    assert not np.any(cone.contains(corner_wrenches(0.2, 0.1, 0.6, "outer"), 1e-6))


def test_yaw_is_coupled_with_sliding_and_tipping():
    cone = Sole(0.2, 0.1, 0.5).closed_form("outer")
    most = 0.5 * (0.1 + 0.05) * 100.0
    yaw = np.array([0, 0, 100.0, 0, 0, most])
    assert cone.contains(yaw)
    assert not cone.contains(yaw + np.array([10.0, 0, 0, 0, 0, 0]), 1e-9)
    assert not cone.contains(yaw + np.array([0, 0, 0, 1.0, 0, 0]), 1e-9)


def test_bad_input_is_named():
    with pytest.raises(ProblemError, match="inner, outer"):
        Sole(0.1, 0.1, 0.6).closed_form("middle")
