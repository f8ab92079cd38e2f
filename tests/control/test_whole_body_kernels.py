"""The compiled pieces of whole-body control against plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.control import whole_body_kernels as kernels
from surefoot.control.damping import LARGEST, computable
from surefoot.control.whole_body_step import exceeded, recover

NV, FEET = 12, 3


def state(seed: int) -> dict[str, np.ndarray]:
    """Return a random state of a robot with two flat feet and a point foot, one of them in the air."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(FEET, 3))
    return {
        "jacobian": rng.normal(size=(6, NV)),
        "variation": rng.normal(size=(6, NV)),
        "support": rng.random((FEET, NV)) < 0.7,
        "v": rng.normal(size=NV),
        "rotations": np.linalg.qr(rng.normal(size=(FEET, 3, 3)))[0],
        "places": rng.normal(size=(FEET, 3)),
        "middles": 0.1 * rng.normal(size=(FEET, 3)),
        "flat": np.array([True, False, True]),
        "stance": np.array([True, True, False]),
        "arms": 0.1 * rng.normal(size=(FEET, 3)),
        "gaps": 0.01 * rng.normal(size=FEET),
        "normals": normals / np.linalg.norm(normals, axis=1)[:, None],
    }


def at_point(spatial: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return the spatial vector [linear at the world's origin; angular] referred to a point."""
    return np.concatenate([spatial[:3] + np.cross(spatial[3:], point), spatial[3:]])


def rows_at(s: dict[str, np.ndarray], k: int, point: np.ndarray) -> np.ndarray:
    """Return the (6, nv) Jacobian of foot k at a point, column by column."""
    columns = [at_point(c, point) * on for c, on in zip(s["jacobian"].T, s["support"][k], strict=True)]
    return np.stack(columns, axis=1)


def motion(s: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return kernels.feet_motion(
        s["jacobian"], s["variation"], s["support"], s["v"], s["rotations"], s["places"], s["middles"]
    )


@pytest.mark.parametrize("seed", range(5))
def test_feet_motion(seed: int) -> None:
    s = state(seed)
    centres, twists, drifts = motion(s)
    for k in range(FEET):
        centre = s["places"][k] + s["rotations"][k] @ s["middles"][k]
        twist = at_point(s["jacobian"] @ (s["support"][k] * s["v"]), centre)
        drift = at_point(s["variation"] @ (s["support"][k] * s["v"]), centre)
        drift[:3] += np.cross(twist[3:], twist[:3])  # classical, not spatial
        np.testing.assert_allclose(centres[k], centre, atol=1e-13)
        np.testing.assert_allclose(twists[k], twist, atol=1e-12)
        np.testing.assert_allclose(drifts[k], drift, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_contact_rows(seed: int) -> None:
    """A rolling sphere keeps its lowest point's velocity; a sole keeps all six; Baumgarte's decay.

    A sole's decays at rates of its own along the normal and about all axes.
    """
    s = state(seed)
    centres, twists, drifts = motion(s)
    rows, wanted = np.full((18, NV), np.nan), np.full(18, np.nan)
    count = kernels.contact_rows(
        s["jacobian"], s["support"], s["flat"], s["stance"], centres, twists, drifts, s["arms"], s["gaps"],
        s["normals"], (50.0, 7.0, 11.0, 13.0), rows, wanted,
    )  # fmt: skip
    expected, right = [], []
    for k in (0, 1):
        J = rows_at(s, k, centres[k] + s["arms"][k])
        slip = twists[k, :3] + np.cross(twists[k, 3:], s["arms"][k])
        drift = drifts[k, :3] + np.cross(drifts[k, 3:], s["arms"][k])
        expected.append(J[:3])
        normal = s["normals"][k]
        along = (normal @ slip) * normal
        decay = 7.0 * (slip - along) + 11.0 * along if s["flat"][k] else 7.0 * slip
        right.append(-drift - decay - 50.0 * s["gaps"][k] * normal)
        if s["flat"][k]:
            expected.append(J[3:])
            right.append(-drifts[k, 3:] - 13.0 * twists[k, 3:])
    assert count == 9
    np.testing.assert_allclose(rows[:9], np.vstack(expected), atol=1e-12)
    np.testing.assert_allclose(wanted[:9], np.concatenate(right), atol=1e-12)
    assert np.isnan(rows[9:]).all()


@pytest.mark.parametrize("seed", range(5))
def test_tasks_are_the_sum_of_their_squares(seed: int) -> None:
    """½ aᵀ H a - cᵀ a is the tasks' weighted squares, for every a, up to a constant."""
    s, rng = state(seed), np.random.default_rng(100 + seed)
    root = rng.normal(size=(NV, NV))
    M, nle, R = root @ root.T, rng.normal(size=NV), s["rotations"][0]
    com, turn, joints = rng.normal(size=3), rng.normal(size=3), rng.normal(size=NV - 6)
    weights, joint_weights, mass, gravity = np.array([2.0, 3.0]), rng.uniform(0.1, 1.0, NV - 6), 4.0, 9.0
    H, c = np.full((NV, NV), np.nan), np.full(NV, np.nan)
    kernels.base_tasks(M, nle, R, mass, gravity, com, turn, weights, joints, joint_weights, H, c)
    centres, _, drifts = motion(s)
    feet = rng.normal(size=(FEET, 6))
    swing = H.copy(), c.copy()
    kernels.swing_tasks(
        s["jacobian"], s["support"], s["flat"], s["stance"], centres, drifts, feet, 5.0, 6.0, *swing
    )

    def base_cost(a: np.ndarray) -> float:
        pull = R @ (M[:3] @ a + nle[:3]) / mass - [0.0, 0.0, gravity]
        spin, rest = R @ a[3:6] - turn, a[6:] - joints
        return 0.5 * float(2.0 * pull_error(pull) + 3.0 * spin @ spin + joint_weights @ rest**2)

    def pull_error(pull: np.ndarray) -> float:
        return float(np.sum((pull - com) ** 2))

    def swing_cost(a: np.ndarray) -> float:
        left = rows_at(s, 2, centres[2]) @ a + drifts[2] - feet[2]
        return base_cost(a) + 0.5 * float(5.0 * left[:3] @ left[:3] + 6.0 * left[3:] @ left[3:])

    for (A, b), cost in (((H, c), base_cost), (swing, swing_cost)):
        for _ in range(5):
            a = rng.normal(size=NV)
            assert 0.5 * a @ A @ a - b @ a == pytest.approx(cost(a) - cost(np.zeros(NV)), rel=1e-9)


def test_only_states_of_finite_size_are_computable() -> None:
    for bad in (np.nan, np.inf, -np.inf, 1.1 * LARGEST, -1.1 * LARGEST):
        x = np.array([1.0, bad, 0.0])
        assert computable(np.ones(3), x) == computable(x, np.ones(3)) == bool(np.abs(x).max() <= LARGEST)
    assert computable(np.full(3, LARGEST), np.zeros(0))


@pytest.mark.parametrize("seed", range(3))
def test_contact_points_are_on_their_feet(seed: int) -> None:
    s, rng = state(seed), np.random.default_rng(seed)
    foot = np.array([0, 0, 1, 2, 2])
    offsets, radii, frames = rng.normal(size=(5, 3)), rng.random(FEET), rng.normal(size=(FEET, 3, 3))
    normals, arms, turns, points = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((5, 3, 3)), np.zeros((5, 3))
    kernels.place_points(
        frames, foot, s["rotations"], s["places"], offsets, radii, normals, arms, turns, points
    )
    np.testing.assert_array_equal(normals, frames[:, :, 2])
    np.testing.assert_array_equal(arms, -radii[:, None] * normals)
    np.testing.assert_array_equal(turns, frames[foot])
    for j, k in enumerate(foot):
        np.testing.assert_allclose(
            points[j], s["places"][k] + s["rotations"][k] @ offsets[j] + arms[k], atol=1e-13
        )


def test_torques_are_those_of_the_dynamics() -> None:
    rng = np.random.default_rng(0)
    rows, forces, offset = rng.normal(size=(6, NV)), rng.normal(size=(2, 3)), rng.normal(size=NV)
    gain, M, nle = rng.normal(size=(NV, 6)), rng.normal(size=(NV, NV)), rng.normal(size=NV)
    torques, a = recover(rows, forces, offset, gain, M, nle)
    ground = rows.T @ forces.ravel()
    np.testing.assert_allclose(a, offset + gain @ ground[:6], atol=1e-12)
    np.testing.assert_allclose(torques, (M @ a + nle - ground)[6:], atol=1e-12)


def test_excess_is_told_apart() -> None:
    middle, half = np.array([0.5, 0.0, 0.0]), np.array([1.0, 2.0, np.inf])
    loose = np.array([True, False, False])
    light, heavy, most, finite = exceeded(np.array([-1.0, 1.0, 7.0]), middle, half, loose)
    assert (light, heavy, most, finite) == (1.5, 0.5, 0.5, True)
    assert not exceeded(np.array([0.0, np.nan, 0.0]), middle, half, loose)[3]
