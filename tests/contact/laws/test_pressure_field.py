"""Pressure fields against closed forms, brute force, and Drake's hydroelastic contact."""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from surefoot.errors import ProblemError
from surefoot.laws import CompliantSolid, PressureField, RegularisedFriction
from surefoot.spatial import rotation_about
from surefoot.terrain import SlopeTerrain, StairsTerrain

RECTANGLE = np.array([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]])
SIZE = (0.2, 0.1, 0.06)
E, H = 1e6, 0.01
STAIRS = StairsTerrain(0.1, 0.3)
UP = np.array([0.0, 0.0, 1.0])


def sole(outline=RECTANGLE):
    return CompliantSolid.sole(outline, H)


def test_flat_sole():
    patch = PressureField(E, H).contact(sole(), np.eye(3), [0.3, -0.2, -1e-4])
    assert patch.normal_force == pytest.approx(E * 1e-4 / H * 0.02, rel=1e-13)
    assert patch.area == pytest.approx(0.02, rel=1e-13)
    assert np.allclose(patch.centre, [0.3, -0.2, 0.0], atol=1e-15)
    assert np.allclose(patch.wrench([0.3, -0.2, 0.0]), [0, 0, patch.normal_force, 0, 0, 0], atol=1e-10)
    assert patch.largest == pytest.approx(1e4, rel=1e-12)


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


def test_a_turning_disc_and_a_strip_have_their_friction_in_closed_form():
    circle = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    radius, mu = 0.08, 0.7
    disc = CompliantSolid.sole(radius * np.column_stack([np.cos(circle), np.sin(circle)]), H)
    law = PressureField(E, H, friction=mu)
    patch = law.contact(disc, np.eye(3), [0, 0, -1e-4], [0, 0, 0, 0, 0, 2.0])
    expected = 2.0 / 3.0 * mu * patch.normal_force * radius
    assert -patch.friction_torque == pytest.approx(expected, rel=5e-5)  # a polygon of 720 sides
    assert patch.spin_limit == pytest.approx(expected, rel=5e-5)
    assert np.abs(patch.friction_force).max() < 1e-9 * patch.normal_force
    sliding = law.contact(disc, np.eye(3), [0, 0, -1e-4], [0.3, -0.4, 0, 0, 0, 0])
    assert np.allclose(sliding.friction_force, mu * sliding.normal_force * np.array([-0.6, 0.8, 0.0]))
    assert abs(sliding.friction_torque) < 1e-12 * expected
    assert sliding.spin_limit == pytest.approx(expected, rel=5e-5)


@pytest.mark.parametrize("seed", range(6))
def test_friction_against_brute_force(seed):
    """A sum over 1.4 million squares, good to a few in a thousand at the edges."""
    rng = np.random.default_rng(seed)
    R = rotation_about([0.6, 0.8, 0.0], 0.003)
    twist = np.concatenate([0.02 * rng.normal(size=2), [0.0, 0.0, 0.0], [rng.choice([-1.0, 1.0])]])
    law = PressureField(E, H, friction=0.6)
    position = [0.0, 0.0, -1e-4]
    patch = law.contact(sole(), R, position, twist)
    n = 1200
    x, y = (0.125 * (2.0 * np.arange(n) + 1.0) / n - 0.125 for _ in range(2))
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    local = (points - position) @ R
    inside = (np.abs(local[:, 0]) <= 0.1) & (np.abs(local[:, 1]) <= 0.05) & (local[:, 2] >= 0.0)
    points, local = points[inside], local[inside]
    load = E / H * local[:, 2] * (0.25 / n) ** 2
    velocity = twist[:3] + np.cross(twist[3:], points - position)
    pull = -0.6 * load[:, None] * velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
    scale = 0.6 * load.sum()
    assert patch.normal_force == pytest.approx(load.sum(), rel=2e-3)
    assert np.abs(patch.friction_force - pull.sum(axis=0)).max() < 3e-3 * scale
    torque = np.cross(points - patch.centre, pull).sum(axis=0)[2]
    assert patch.friction_torque == pytest.approx(torque, abs=3e-3 * scale * 0.05)
    assert abs(patch.friction_torque) <= patch.spin_limit * (1.0 + 1e-9)
    assert np.linalg.norm(patch.friction_force) <= 0.6 * patch.normal_force * (1.0 + 1e-9)


def _cases() -> list[dict]:
    """Boxes that touch with a face, an edge or a corner, at rest, pressed, sliding and turning."""
    cases = []
    for depth in (1e-4, 5e-3):
        for axis, angle in (([0, 1, 0], 0.0), ([0, 1, 0], 0.02), ([1, 0.3, 0], 0.01), ([1, 1, 0], 0.3)):
            R = rotation_about(np.array(axis) / np.linalg.norm(axis), angle)
            low = float((CompliantSolid.box(SIZE).corners @ R.T)[:, 2].min())
            for twist in ([0.0] * 6, [0.3, -0.2, -0.1, 0, 0, 0], [0.6, 0.2, -0.1, 0.3, -0.2, 1.0]):
                cases.append(
                    {
                        "size": SIZE,
                        "modulus": E,
                        "dissipation": 0.5,
                        "mu": 0.5,
                        "rotation": R.tolist(),
                        "position": [0.3, 0.1, -low - depth],
                        "twist": [float(x) for x in twist],
                    }
                )
    return cases


@pytest.mark.skipif(
    not os.environ.get("SUREFOOT_DRAKE_PYTHON"),
    reason="Drake is not here; SUREFOOT_DRAKE_PYTHON names a Python",
)
def test_box_against_drake():
    cases = _cases()
    done = subprocess.run(
        [os.environ["SUREFOOT_DRAKE_PYTHON"], str(Path(__file__).with_name("drake_box.py"))],
        input=json.dumps(cases),
        capture_output=True,
        text=True,
        check=True,
    )
    for case, surfaces in zip(cases, json.loads(done.stdout), strict=True):
        assert len(surfaces) == 1
        drake = surfaces[0]
        law = PressureField(E, 0.5 * min(SIZE), case["dissipation"], friction=case["mu"])
        patch = law.contact(CompliantSolid.box(SIZE), case["rotation"], case["position"], case["twist"])
        ours, force = patch.wrench(drake["centroid"]), np.array(drake["force"])
        size = math.sqrt(patch.area)
        assert patch.area == pytest.approx(drake["area"], rel=1e-9)
        assert ours[2] == pytest.approx(force[2], rel=1e-9)  # the pressure
        assert np.abs(ours[3:5] - drake["moment"][:2]).max() < 1e-5 * force[2] * size  # and where it acts
        assert np.abs(ours[:3] - force).max() < 0.01 * np.linalg.norm(force)
        assert abs(ours[5] - drake["moment"][2]) < 0.01 * force[2] * size


def test_a_slope_turns_all_with_it():
    law, turn = PressureField(E, H, 0.3, friction=0.6), rotation_about([0, 1, 0], -math.radians(8.0))
    lean, at, twist = (
        rotation_about([0, 1, 0], -0.002),
        np.array([0.0, 0.0, 5e-5]),
        np.array([0.1, 0, 0, 0, 0, 0.7]),
    )
    flat = law.contact(sole(), lean, at, twist)
    tilted = law.contact(sole(), turn @ lean, turn @ at, np.kron(np.eye(2), turn) @ twist, SlopeTerrain(8.0))
    assert flat.normal_force > 0.0
    np.testing.assert_allclose(tilted.force, turn @ flat.force, rtol=1e-9)
    np.testing.assert_allclose(tilted.centre, turn @ flat.centre, atol=1e-12)
    assert tilted.spin_limit == pytest.approx(flat.spin_limit, rel=1e-9)


def test_damping_never_pulls_and_regularised_friction_is_weaker():
    law = PressureField(E, H, 2.0)
    flat = law.contact(sole(), np.eye(3), [0, 0, -1e-4])
    assert law.contact(sole(), np.eye(3), [0, 0, -1e-4], [0, 0, 0.6, 0, 0, 0]).normal_force == 0.0
    leaving = law.contact(sole(), np.eye(3), [0, 0, -1e-4], [0, 0, 0.0, 0, 8.0, 0])  # half of it comes off
    assert leaving.area < flat.area
    assert leaving.largest > 2.0 * flat.largest
    coming = law.contact(sole(), np.eye(3), [0, 0, -1e-4], [0, 0, -0.25, 0, 0, 0])
    assert coming.normal_force == pytest.approx(1.5 * flat.normal_force)
    smooth = PressureField(E, H, friction=RegularisedFriction(0.6, 0.01))
    slow = smooth.contact(sole(), np.eye(3), [0, 0, -1e-4], [0.01, 0, 0, 0, 0, 0])
    assert -slow.friction_force[0] == pytest.approx(0.6 * 200.0 / math.sqrt(2.0))


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


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), st.floats(-4.0, 4.0), st.floats(-0.3, 0.3),
    st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6), st.booleans(),
)  # fmt: skip
@settings(max_examples=150, deadline=None)
def test_any_pose_and_twist_give_a_lawful_patch(axis, angle, height, twist, solid):
    if np.linalg.norm(axis) < 1e-3:
        axis = UP
    body = CompliantSolid.box(SIZE) if solid else sole()
    R = rotation_about(np.asarray(axis) / np.linalg.norm(axis), angle)
    law = PressureField(E, H, 0.3, friction=0.5)
    patch = law.contact(body, R, [0.1, 0.2, height], twist)
    assert patch.normal_force >= 0.0
    assert np.isfinite(patch.wrench(np.zeros(3))).all()
    assert np.linalg.norm(patch.friction_force) <= 0.5 * patch.normal_force * (1.0 + 1e-9)
    if patch.normal_force > 0.0:
        assert (body.distances((patch.centre - [0.1, 0.2, height]) @ R) > -1e-9).all()
        assert abs(patch.centre[2]) < 1e-9
        assert abs(patch.friction_torque) <= patch.spin_limit * (1.0 + 1e-4) + 1e-12


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PressureField(0.0, H), "modulus"),
        (lambda: PressureField(E, math.nan), "thickness"),
        (lambda: PressureField(E, H, -1.0), "dissipation"),
        (lambda: CompliantSolid.box((0.1, 0.0, 0.1)), "size"),
        (lambda: CompliantSolid.sole([[0, 0], [1, 0], [2, 0]], H), "outline must span an area"),
        (lambda: PressureField(E, H).contact(sole(), 2.0 * np.eye(3), [0, 0, 0]), "rotation"),
        (lambda: PressureField(E, H).contact(sole(), np.eye(3), [0, 0, math.nan]), "position"),
        (lambda: PressureField(E, H).contact(sole(), np.eye(3), [0, 0, 0], [math.inf] * 6), "twist"),
        (lambda: PressureField(E, H).contact(sole(), np.eye(3), [0, 0, 0], None, STAIRS), "planes"),
        (lambda: PressureField(E, H).rest(sole(), 100.0, [0.2, 0.0]), "outside the underside"),
        (lambda: PressureField(E, H).rest(sole(), 1e9), "too much"),
    ],
)
def test_wrong_input_is_named(make, words):
    with pytest.raises(ProblemError, match=words):
        make()
