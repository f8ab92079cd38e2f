"""The invariant filter: its equations against NumPy, its theory, its consistency."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm
from scipy.stats import chi2

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, skew
from surefoot.motion.estimation import inekf_kernels as kernels
from surefoot.motion.estimation.extended_poses import gammas
from surefoot.motion.estimation.inekf import FilterNoise, InvariantFilter
from tests.motion.estimation.poses import adjoint, exponential, inverse, logarithm, product

G = np.array([0.0, 0.0, -GRAVITY])
QUIET = FilterNoise(*[0.0] * 11, turning=0.0, slip=0.0, impact=0.0)


def random_filter(seed: int, feet: int = 3) -> InvariantFilter:
    """Return a filter in the middle of its life: some feet stand, the covariance is full."""
    random, filter = np.random.default_rng(seed), InvariantFilter(feet)
    filter.X[:] = exponential(random.normal(size=9 + 3 * feet))
    filter.bias[:] = 0.1 * random.normal(size=6)
    filter.standing[:] = random.random(feet) < 0.7
    filter.standing[0] = True
    N = 15 + 3 * feet
    known = np.r_[np.ones(9), np.repeat(filter.standing, 3), np.ones(6)].astype(bool)
    root = 0.1 * random.normal(size=(N, N)) * known[:, None]
    filter.covariance[:] = root @ root.T
    return filter


def dynamics(filter: InvariantFilter) -> FloatArray:
    """Return A of the error's dynamics, as the paper has it."""
    n, X = filter.n, filter.X
    N = 15 + 3 * n
    A, R = np.zeros((N, N)), X[:, :3]
    A[3:6, :3], A[6:9, 3:6] = skew(G), np.eye(3)
    A[:3, N - 6 : N - 3], A[3:6, N - 3 :] = -R, -R
    for j in range(2 + n):
        if j < 2 or filter.standing[j - 2]:
            A[3 + 3 * j : 6 + 3 * j, N - 6 : N - 3] = -skew(X[:, 3 + j]) @ R
    return A


@pytest.mark.parametrize("seed", range(5))
def test_propagation_is_that_of_plain_matrices(seed: int) -> None:
    filter, h, random = random_filter(seed), 0.02, np.random.default_rng(seed)
    gyro, force, densities = random.normal(size=3), 9.0 * random.normal(size=3), random.random(7)
    N, n = len(filter.covariance), filter.n
    Phi, Cov, Ad = expm(dynamics(filter) * h), np.zeros((N, N)), np.eye(N)
    Cov[:3, :3], Cov[3:6, 3:6] = densities[0] * np.eye(3), densities[1] * np.eye(3)
    Cov[N - 6 : N - 3, N - 6 : N - 3], Cov[N - 3 :, N - 3 :] = (d * np.eye(3) for d in densities[2:4])
    Ad[: N - 6, : N - 6] = adjoint(filter.X)
    for k in range(n):
        rows = slice(9 + 3 * k, 12 + 3 * k)
        Cov[rows, rows] = densities[4 + k] * filter.standing[k] * np.eye(3)
        if not filter.standing[k]:
            Ad[rows] = 0.0
    expected = Phi @ (filter.covariance + Ad @ Cov @ Ad.T * h) @ Phi.T
    # the mean: many small steps of the group's own flow
    R, v, p, steps = filter.X[:, :3].copy(), filter.X[:, 3].copy(), filter.X[:, 4].copy(), 2000
    w, f, e = gyro - filter.bias[:3], force - filter.bias[3:], h / 2000
    turn, half = expm(skew(w) * e), expm(skew(w) * 0.5 * e)
    for _ in range(steps):
        a = R @ half @ f + G
        p += e * v + 0.5 * e * e * a
        v += e * a
        R = R @ turn
    feet = filter.X[:, 5:].copy()
    kernels.propagate(
        filter.X, filter.bias, filter.covariance, filter.standing, gyro, force, densities, h
    )  # fmt: skip
    np.testing.assert_allclose(filter.covariance, expected, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(filter.X[:, :5], np.column_stack([R, v, p]), rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(filter.X[:, 5:], feet)


@settings(max_examples=50, deadline=None)
@given(arrays(np.float64, 9, elements=st.floats(-1.5, 1.5)), st.integers(0, 100))
def test_errors_of_any_size_move_linearly(xi: FloatArray, seed: int) -> None:
    """The log-linear property: without biases exp(Φ ξ) is the error exactly, however large ξ is."""
    random, h, steps = np.random.default_rng(seed), 0.05, 20
    true, wrong = InvariantFilter(1, QUIET), InvariantFilter(1, QUIET)
    true.X[:, :5] = exponential(random.normal(size=9))
    wrong.X[:, :5] = product(exponential(xi), true.X[:, :5])
    Phi = expm(dynamics(InvariantFilter(1, QUIET))[:9, :9] * h * steps)
    for _ in range(steps):
        gyro, force = random.normal(size=3), 5.0 * random.normal(size=3)
        for filter in (true, wrong):
            filter.predict(gyro, force, h)
    error = product(wrong.X[:, :5], inverse(true.X[:, :5]))
    np.testing.assert_allclose(error, exponential(Phi @ xi), rtol=0.0, atol=1e-8)


def innovations(X: FloatArray, places: FloatArray) -> FloatArray:
    """Return z of every foot, stacked."""
    return np.concatenate([X[:, :3] @ y - X[:, 5 + k] + X[:, 4] for k, y in enumerate(places)])


def observation(n: int) -> FloatArray:
    """Return H of all feet, (3n, 15 + 3n)."""
    H = np.zeros((3 * n, 15 + 3 * n))
    for k in range(n):
        H[3 * k : 3 * k + 3, 6:9], H[3 * k : 3 * k + 3, 9 + 3 * k : 12 + 3 * k] = -np.eye(3), np.eye(3)
    return H


@pytest.mark.parametrize("seed", range(5))
def test_a_correction_is_the_textbooks(seed: int) -> None:
    filter, random = random_filter(seed), np.random.default_rng(seed)
    places = random.normal(size=(3, 3))
    roots = 0.1 * random.normal(size=(3, 3, 3))
    spreads, on = roots @ roots.transpose(0, 2, 1), filter.standing
    R, P, rows = filter.rotation, filter.covariance.copy(), np.repeat(on, 3)
    H, z = observation(3)[rows], innovations(filter.X, places)[rows]
    noise = np.zeros((9, 9))
    for k in range(3):
        noise[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = R @ spreads[k] @ R.T
    S = H @ P @ H.T + noise[np.ix_(rows, rows)]
    K = np.linalg.solve(S, H @ P).T
    delta = K @ z
    rest = np.eye(len(P)) - K @ H
    expected = rest @ P @ rest.T + K @ noise[np.ix_(rows, rows)] @ K.T
    X, bias = product(exponential(delta[:-6]), filter.X), filter.bias + delta[-6:]
    distances, used = np.zeros(3), np.zeros(3, dtype=bool)
    count = kernels.correct(
        filter.X, filter.bias, filter.covariance, on, places, spreads, np.inf, distances, np.zeros((3, 3)),
        used,
    )  # fmt: skip
    assert count == on.sum()
    np.testing.assert_array_equal(used, on)
    np.testing.assert_allclose(filter.covariance, expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(filter.X, X, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(filter.bias, bias, rtol=0.0, atol=1e-12)
    for k in np.flatnonzero(on):
        own, m = observation(3)[3 * k : 3 * k + 3], slice(3 * k, 3 * k + 3)
        far = innovations(product(inverse(exponential(delta[:-6])), filter.X), places)[m]
        assert distances[k] == pytest.approx(
            far @ np.linalg.solve(own @ P @ own.T + noise[m, m], far), rel=1e-6
        )


def test_a_known_height_is_a_correction_with_one_row() -> None:
    filter, normal, k, variance = random_filter(1), np.array([0.36, -0.48, 0.8]), 0, 0.01
    X, P = filter.X.copy(), filter.covariance.copy()
    row, step = np.zeros(len(P)), 1e-6
    for i in range(18):
        ends = [product(exponential(s * step * np.eye(18)[i]), X)[:, 5 + k] @ normal for s in (1.0, -1.0)]
        row[i] = (ends[0] - ends[1]) / (2.0 * step)
    S = row @ P @ row + variance
    delta = P @ row / S * -0.05
    assert kernels.correct_height(filter.X, filter.bias, filter.covariance, k, normal, 0.05, variance, np.inf)
    np.testing.assert_allclose(filter.covariance, P - np.outer(P @ row, P @ row) / S, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(filter.X, product(exponential(delta[:-6]), X), rtol=0.0, atol=1e-9)
    before = filter.covariance.copy()
    assert not filter.observe_height(k, normal, 1e3, 0.1)  # beyond belief: nothing changes
    np.testing.assert_array_equal(filter.covariance, before)


@dataclass
class Course:
    """A body that sways with feet that come and go: truth, and what is measured of it."""

    noise: FilterNoise
    seed: int
    steps: int = 150
    dt: float = 0.01
    certain: float = 1.0

    def __post_init__(self) -> None:
        r, self.filter = np.random.default_rng(self.seed), InvariantFilter(2, self.noise, gate=np.inf)
        self.random = r
        start = np.diag(
            np.r_[0.05**2, 0.05**2, 0.05**2, np.full(6, 0.1**2), np.full(3, 1e-4), np.full(3, 1e-2)]
        )
        start *= self.certain**2
        self.X = exponential(
            np.r_[0.3 * r.normal(size=3), 0.3 * r.normal(size=3), 2.0 * r.normal(size=3), np.zeros(6)]
        )
        self.bias = np.zeros(6)
        xi = np.sqrt(np.diag(start)) * r.normal(size=15)
        wrong = product(exponential(xi[:9]), self.X[:, :5])
        self.filter.reset(wrong[:, :3], wrong[:, 3], wrong[:, 4], self.bias + xi[9:], start)
        self.on = np.zeros(2, dtype=bool)

    def measure(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Move the truth on; return turn rate and specific force as measured."""
        w, r, dt, t = self.noise, self.random, self.dt, k * self.dt
        rate = np.array([0.5 * np.sin(5.0 * t), 0.4 * np.cos(4.0 * t), 0.8])
        force = self.X[:, :3].T @ (np.array([np.sin(6.0 * t), np.cos(5.0 * t), 0.5 * np.sin(9.0 * t)]) - G)
        seen = np.r_[rate, force] + self.bias
        seen += np.repeat([w.gyro, w.accelerometer], 3) / np.sqrt(dt) * r.normal(size=6)
        gamma = np.empty((3, 3, 3))
        gammas(rate * dt, gamma)
        R, v, p = self.X[:, :3].copy(), self.X[:, 3].copy(), self.X[:, 4].copy()
        self.X[:, 4] = p + dt * v + dt * dt * (R @ gamma[2] @ force + 0.5 * G)
        self.X[:, 3] = v + dt * (R @ gamma[1] @ force + G)
        self.X[:, :3] = R @ gamma[0]
        self.X[:, 5:] += w.foot * np.sqrt(dt) * r.normal(size=(3, 2)) * self.on
        walk = np.repeat([w.gyro_drift, w.accelerometer_drift], 3)
        self.bias = self.bias + walk * np.sqrt(dt) * r.normal(size=6)
        return seen[:3], seen[3:]

    def touching(self, k: int) -> BoolArray:
        """Return which feet stand: one at least, and each away for a while."""
        return np.array([not 60 <= k < 80, not 100 <= k < 120])

    def places(self, k: int) -> tuple[FloatArray, FloatArray]:
        """Return the feet as seen from the body, with their covariances; feet that land get a place."""
        touching, sigma = self.touching(k), self.noise.joint
        for foot in np.flatnonzero(touching & ~self.on):
            self.X[:, 5 + foot] = self.X[:, 4] + 0.3 * self.random.normal(size=3)
        self.on = touching
        seen = (self.X[:, 5:] - self.X[:, 4:5]).T @ self.X[:, :3] + sigma * self.random.normal(size=(2, 3))
        return seen, np.tile(sigma**2 * np.eye(3), (2, 1, 1))

    def nees(self) -> tuple[float, int]:
        """Return the error squared in the metric of the covariance, and the number of its entries."""
        f, on = self.filter, np.r_[np.ones(9), np.repeat(self.on, 3), np.ones(6)].astype(bool)
        error = np.r_[logarithm(product(f.X, inverse(self.X))), f.bias - self.bias][on]
        return float(error @ np.linalg.solve(f.covariance[np.ix_(on, on)], error)), int(on.sum())


NOISE = FilterNoise(2e-3, 2e-2, 1e-3, 5e-3, foot=5e-3, landing=5e-3, joint=3e-3)


@pytest.mark.long
def test_errors_are_as_large_as_the_covariance_says() -> None:
    """NEES of 200 seeded runs within the 99.8 % interval of its chi-square distribution, at six times."""
    looked, sums = (1, 30, 70, 90, 110, 149), np.zeros((6, 2))
    for seed in range(200):
        course = Course(NOISE, seed)
        for k in range(course.steps):
            course.filter.predict(*course.measure(k), course.dt)
            course.filter.observe(*course.places(k), course.touching(k))
            if k in looked:
                sums[looked.index(k)] += course.nees()
    for total, degrees in sums:
        low, high = chi2.ppf([0.001, 0.999], degrees)
        assert low < total < high, (sums[:, 0] / sums[:, 1]).round(3)


def test_a_foot_that_slid_is_not_believed_and_stands_again() -> None:
    filter, foot = InvariantFilter(2), np.array([[0.1, 0.1, -0.3], [0.1, -0.1, -0.3]])
    spreads, both = np.tile(1e-6 * np.eye(3), (2, 1, 1)), np.array([True, True])
    for k in range(300):
        filter.predict(np.zeros(3), -G, 0.001)
        slid = foot + np.array([[0.05, 0.0, 0.0], [0.0, 0.0, 0.0]]) * (k >= 200)
        used = filter.observe(slid, spreads, both)
        if k == 200:
            assert used.tolist() == [False, True]
            assert filter.distances[0] > 100.0
    assert used.all()
    assert np.abs(filter.velocity).max() < 1e-3
    filter.observe(foot, spreads, np.array([False, True]))
    assert filter.standing.tolist() == [False, True]


def test_doubt_widens_and_wrong_input_is_refused() -> None:
    filter = InvariantFilter(1)
    before = filter.covariance[3:6, 3:6].copy()
    filter.doubt_velocity(0.3)
    np.testing.assert_allclose(filter.covariance[3:6, 3:6], before + 0.3**2 * np.eye(3))
    with pytest.raises(ProblemError, match="rotation must be a rotation matrix"):
        filter.reset(np.diag([1.0, 1.0, -1.0]))
    for entry, value in (((0, 1), 0.5), ((2, 2), -1.0), ((3, 3), np.nan)):
        covariance = np.eye(15)
        covariance[entry] = value
        with pytest.raises(ProblemError, match="covariance"):
            filter.reset(position=(1.0, 0.0, 0.0), covariance=covariance)
    assert not filter.position.any()
    with pytest.raises(ProblemError, match="feet must be"):
        InvariantFilter(0)
    with pytest.raises(ProblemError, match="gyro must be"):
        FilterNoise(gyro=-1.0)
