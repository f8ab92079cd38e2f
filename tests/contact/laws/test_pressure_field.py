"""Pressure fields against closed forms and brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_about
from surefoot.laws import CompliantSolid, PressureField

RECTANGLE = np.array([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]])
E, H = 1e6, 0.01


def sole(outline=RECTANGLE):
    return CompliantSolid.sole(outline, H)


def test_flat_sole():
    patch = PressureField(E, H).contact(sole(), np.eye(3), [0.3, -0.2, -1e-4])
    assert patch.normal_force == pytest.approx(E * 1e-4 / H * 0.02, rel=1e-13)
    assert patch.area == pytest.approx(0.02, rel=1e-13)
    assert np.allclose(patch.centre, [0.3, -0.2, 0.0], atol=1e-15)
    assert patch.largest == pytest.approx(1e4, rel=1e-12)
    above = PressureField(E, H).contact(sole(), np.eye(3), [0.3, -0.2, 1e-4])
    assert above.normal_force == above.area == above.spin_limit == 0.0
    assert np.isnan(above.centre).all()


@pytest.mark.parametrize("angle", [1e-4, 1e-3, 0.02])
def test_leaning_sole_is_a_wedge(angle):
    """Against a sum over the line along which the sole leans."""
    R = rotation_about([0, 1, 0], angle)  # toe down
    toe = R @ np.array([0.1, 0.0, 0.0])
    depth = 5e-5
    patch = PressureField(E, H).contact(sole(), R, [0.0, 0.0, -toe[2] - depth])
    points = np.linspace(-0.4, 0.4, 400001)
    x = np.column_stack([points, 0.0 * points, 0.0 * points]) - [0.0, 0.0, -toe[2] - depth]
    local = x @ R
    p = np.where((np.abs(local[:, 0]) <= 0.1) & (local[:, 2] >= 0.0), E / H * local[:, 2], 0.0)
    step = points[1] - points[0]
    assert patch.normal_force == pytest.approx(0.1 * p.sum() * step, rel=1e-4)
    assert patch.centre[0] == pytest.approx((p * points).sum() / p.sum(), abs=1e-6)


def test_a_disc_holds_two_thirds_of_its_radius_against_spin():
    circle = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    radius, mu = 0.08, 0.7
    disc = CompliantSolid.sole(radius * np.column_stack([np.cos(circle), np.sin(circle)]), H)
    patch = PressureField(E, H, friction=mu).contact(disc, np.eye(3), [0, 0, -1e-4])
    expected = 2.0 / 3.0 * mu * patch.normal_force * radius
    assert patch.spin_limit == pytest.approx(expected, rel=5e-5)  # a polygon of 720 sides


def test_spin_limit_of_a_leaning_sole_against_brute_force():
    """A sum over 1.4 million squares, good to a few in a thousand at the edges."""
    R, position, n = rotation_about([0.6, 0.8, 0.0], 0.003), [0.0, 0.0, -1e-4], 1200
    patch = PressureField(E, H, friction=0.6).contact(sole(), R, position)
    x, y = (0.125 * (2.0 * np.arange(n) + 1.0) / n - 0.125 for _ in range(2))
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    local = (points - position) @ R
    inside = (np.abs(local[:, 0]) <= 0.1) & (np.abs(local[:, 1]) <= 0.05) & (local[:, 2] >= 0.0)
    load = E / H * local[inside, 2] * (0.25 / n) ** 2
    assert patch.normal_force == pytest.approx(load.sum(), rel=2e-3)
    arms = np.linalg.norm(points[inside] - patch.centre, axis=1)
    assert patch.spin_limit == pytest.approx(0.6 * float(load @ arms), rel=3e-3)


@pytest.mark.parametrize("centre", [(0.035, 0.0), (0.06, 0.005), (0.1, -0.01), (0.118, 0.0)])
def test_rest_carries_the_load_where_it_acts(centre):
    foot = sf.load_robot("g1").feet[0]
    under = float(foot.centres[0, 2] - foot.radius)
    body = CompliantSolid.sole(foot.centres[:, :2], H, under)
    R, position, patch = PressureField(E, H).rest(body, 160.0, centre)
    assert patch.normal_force == pytest.approx(160.0, rel=1e-9)
    assert np.allclose((R.T @ (patch.centre - position))[:2], centre, atol=1e-9)
    again = PressureField(E, H).contact(body, R, position)
    assert again.normal_force == patch.normal_force


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PressureField(0.0, H), "modulus"),
        (lambda: PressureField(E, math.nan), "thickness"),
        (lambda: PressureField(E, H, -1.0), "friction"),
        (lambda: CompliantSolid.sole([[0, 0], [1, 0], [2, 0]], H), "outline must span an area"),
        (lambda: PressureField(E, H).contact(sole(), 2.0 * np.eye(3), [0, 0, 0]), "rotation"),
        (lambda: PressureField(E, H).contact(sole(), np.eye(3), [0, 0, math.nan]), "position"),
        (lambda: PressureField(E, H).rest(sole(), 100.0, [0.2, 0.0]), "outside the underside"),
        (lambda: PressureField(E, H).rest(sole(), 1e9), "too much"),
    ],
)
def test_wrong_input_is_named(make, words):
    with pytest.raises(ProblemError, match=words):
        make()
