"""Scalings, directions and steps of pairs of points in second-order cones, against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.contact.solvers import cone_pairs as pairs

J = np.diag([-1.0, -1.0, 1.0])


def inside(rng: np.random.Generator, count: int, far: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) of the cone, from its middle to `far` times nearer to its border, and their distances."""
    points = rng.normal(size=(count, 3))
    border = far ** -rng.random(count)
    points[:, 2] = np.hypot(points[:, 0], points[:, 1]) + border
    return points, border


def arrow(v: np.ndarray) -> np.ndarray:
    """The matrix of the cone's product with v, axis last."""
    out = v[2] * np.eye(3)
    out[2, :2] = out[:2, 2] = v[:2]
    return out


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_the_scaling_takes_one_point_to_the_other(share: float) -> None:
    rng = np.random.default_rng(3)
    x, dx = inside(rng, 40, 1e4)
    y, dy = inside(rng, 40, 1e4)
    axes, scaled, weights = np.empty((40, 4)), np.empty((40, 3)), np.empty((40, 3, 3))
    gap = pairs.scale_pairs(x, dx, y, dy, share, axes, scaled, weights)
    assert gap == pytest.approx(np.mean(np.sum(x * y, axis=1)), rel=1e-12)
    for k in range(40):
        S = np.eye(3)
        S[2, :2] = -share * y[k, :2] / np.hypot(*y[k, :2])
        P = weights[k] @ S  # P is the only one with P y = x that keeps the cone: P J P is a multiple of J
        np.testing.assert_allclose(P, P.T, rtol=1e-9)
        np.testing.assert_allclose(P @ y[k], x[k], rtol=1e-7)
        factor = (P @ J @ P)[2, 2]
        np.testing.assert_allclose(P @ J @ P, factor * J, atol=1e-9 * np.linalg.norm(P) ** 2)
        eigenvalues, axis = np.linalg.eigh(P)
        W = axis @ np.diag(np.sqrt(eigenvalues)) @ axis.T
        np.testing.assert_allclose(scaled[k], W @ y[k], rtol=1e-6)


def test_a_direction_solves_the_linearised_complementarity() -> None:
    rng = np.random.default_rng(4)
    (x, dx), (y, dy) = inside(rng, 20, 1e2), inside(rng, 20, 1e2)
    axes, scaled, weights = np.empty((20, 4)), np.empty((20, 3)), np.empty((20, 3, 3))
    pairs.scale_pairs(x, dx, y, dy, 1.0, axes, scaled, weights)
    aim, step_x, step_y = np.empty((20, 3)), np.empty((20, 3)), np.empty((20, 3))
    before, after, moved = rng.normal(size=(3, 20, 3))
    pairs.aim_pairs(axes, scaled, before, after, 0.1, 0.5, aim)
    pairs.finish_direction(axes, y, 1.0, aim, moved, step_x, step_y)
    for k in range(20):
        S = np.eye(3)
        S[2, :2] = -y[k, :2] / np.hypot(*y[k, :2])
        np.testing.assert_allclose(S @ step_y[k], moved[k], rtol=1e-9, atol=1e-12)
        eigenvalues, axis = np.linalg.eigh(weights[k] @ S)
        W = axis @ np.diag(np.sqrt(eigenvalues)) @ axis.T
        inverse, middle = np.linalg.inv(W), arrow(scaled[k])
        left = middle @ (inverse @ step_x[k] + W @ step_y[k])
        right = 0.1 * np.eye(3)[2] - middle @ scaled[k] - 0.5 * arrow(inverse @ before[k]) @ (W @ after[k])
        np.testing.assert_allclose(left, right, rtol=1e-6, atol=1e-6 * np.abs(right).max())


def test_the_longest_step_ends_at_the_border() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        points, border = inside(rng, 1, 1e3)
        steps = rng.normal(size=(1, 3))
        length = pairs.longest_step(points, border, steps)
        out, distance = np.empty((1, 3)), np.empty(1)
        if length >= 1e3:
            assert pairs.move_points(points, border, steps, 999.0, out, distance)
            continue
        assert pairs.move_points(points, border, steps, 0.999999 * length, out, distance)
        np.testing.assert_allclose(out, points + 0.999999 * length * steps, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(distance, out[:, 2] - np.hypot(out[:, 0], out[:, 1]), atol=1e-9)
        assert not pairs.move_points(points, border, steps, 1.000001 * length, out, distance)


def test_the_distance_to_the_border_outlives_the_digits_of_the_point() -> None:
    """At 1e-20 from the border the point alone says zero."""
    points, border = np.array([[3.0, 4.0, 5.0]]), np.array([1e-20])
    out, distance = np.empty((1, 3)), np.empty(1)
    along = np.array([[3.0, 4.0, 5.0]])
    assert pairs.move_points(points, border, along, 0.5, out, distance)
    np.testing.assert_allclose(distance, 1e-20, rtol=1e-6)


def test_centrality_is_one_on_the_central_path() -> None:
    rng = np.random.default_rng(6)
    y, dy = inside(rng, 10, 10.0)
    determinant = y[:, 2] ** 2 - y[:, 0] ** 2 - y[:, 1] ** 2
    x = (J @ y.T).T / determinant[:, None]  # the inverse, times one number for all
    dx = x[:, 2] - np.hypot(x[:, 0], x[:, 1])
    assert pairs.centrality(x, dx, y, dy) == pytest.approx(1.0, rel=1e-9)
    assert pairs.centrality(x * np.linspace(1, 2, 10)[:, None], dx * np.linspace(1, 2, 10), y, dy) < 0.8
