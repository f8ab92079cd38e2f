"""An ordinary extended Kalman filter with the same sensors: independent, slow, Jacobians by differences.

Attitude errs on the body's side, everything else by addition, as in M. Bloesch et al., "State estimation for
legged robots", RSS 2012. Rotations are SciPy's.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.arrays import BoolArray, FloatArray
from surefoot.estimation.inekf import FilterNoise, InvariantFilter
from surefoot.spatial import GRAVITY, skew

State = tuple[Rotation, FloatArray]
"""Attitude, and (18,) velocity, place, two feet and biases."""


def plus(state: State, error: FloatArray) -> State:
    """Return a state with an error (21,) added."""
    return state[0] * Rotation.from_rotvec(error[:3]), state[1] + error[3:]


def minus(a: State, b: State) -> FloatArray:
    """Return the error (21,) that leads from b to a."""
    return np.r_[(b[0].inv() * a[0]).as_rotvec(), a[1] - b[1]]


def derivative(f: Callable[[FloatArray], FloatArray], n: int, step: float = 1e-6) -> FloatArray:
    """Return the derivative of a function of (n,) at zero by central differences."""
    return np.array([(f(step * e) - f(-step * e)) / (2.0 * step) for e in np.eye(n)]).T


class QuaternionEkf:
    """Starts where an `InvariantFilter` for two feet does, as certain as that."""

    def __init__(self, filter: InvariantFilter, noise: FilterNoise) -> None:
        R, v, p = filter.rotation, filter.velocity, filter.position
        self.state: State = Rotation.from_matrix(R), np.r_[v, p, np.zeros(6), filter.bias]
        T = np.zeros((21, 15))  # from ξ and biases: v - v̂ is φ x v̂ + ξ_v, and so on
        T[:3, :3], T[3:6, :3], T[6:9, :3] = R.T, -skew(v), -skew(p)
        T[3:9, 3:9], T[15:, 9:] = np.eye(6), np.eye(6)
        small = filter.covariance[np.ix_(np.r_[0:9, 15:21], np.r_[0:9, 15:21])]
        self.P = T @ small @ T.T
        self.on = np.zeros(2, dtype=bool)
        self.noise, self.start = noise, self.X[:, :5].copy()

    @property
    def X(self) -> FloatArray:
        """(3, 7) as the invariant filter has it."""
        x = self.state[1]
        return np.column_stack([self.state[0].as_matrix(), x[:3], x[3:6], x[6:9], x[9:12]])

    @property
    def bias(self) -> FloatArray:
        """(6,) of gyro and accelerometer."""
        return self.state[1][12:]

    def _moved(self, state: State, imu: FloatArray, feet: FloatArray, walk: FloatArray, h: float) -> State:
        """Return a state after h: midpoint rule, with noise on IMU, feet and biases."""
        R, x = state
        rate, force = imu[:3] - x[12:15], imu[3:] - x[15:]
        middle = R * Rotation.from_rotvec(0.5 * h * rate)
        a = middle.apply(force) - [0.0, 0.0, GRAVITY]
        parts = x[:3] + h * a, x[3:6] + h * x[:3] + 0.5 * h * h * a, x[6:12] + feet, x[12:] + walk
        return R * Rotation.from_rotvec(h * rate), np.concatenate(parts)

    def predict(self, gyro: FloatArray, force: FloatArray, h: float) -> None:
        """Go on by h."""
        imu, six, base, w = np.r_[gyro, force], np.zeros(6), self.state, self.noise
        self.state = after = self._moved(base, imu, six, six, h)
        F = derivative(lambda e: minus(self._moved(plus(base, e), imu, six, six, h), after), 21)
        L = derivative(lambda e: minus(self._moved(base, imu + e[:6], e[6:12], e[12:], h), after), 18)
        sizes = np.repeat([w.gyro, w.accelerometer, w.foot, w.foot, w.gyro_drift, w.accelerometer_drift], 3)
        scale = np.r_[np.full(6, 1.0 / h), np.repeat(self.on, 3) * h, np.full(6, h)]
        self.P = F @ self.P @ F.T + L @ np.diag(sizes**2 * scale) @ L.T

    def _seen(self, state: State, foot: int) -> FloatArray:
        x = state[1]
        return np.asarray(state[0].inv().apply(x[6 + 3 * foot : 9 + 3 * foot] - x[3:6]))

    def observe(self, places: FloatArray, spreads: FloatArray, touching: BoolArray) -> None:
        """Correct with the feet that stood before, and put the others where they are seen."""
        feet = np.flatnonzero(touching & self.on)
        if feet.size:
            base = self.state
            H = derivative(lambda e: np.concatenate([self._seen(plus(base, e), k) for k in feet]), 21)
            z = np.concatenate([places[k] - self._seen(base, k) for k in feet])
            noise = np.zeros((len(z), len(z)))
            for i, k in enumerate(feet):
                noise[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = spreads[k]
            K = np.linalg.solve(H @ self.P @ H.T + noise, H @ self.P).T
            self.state = plus(base, K @ z)
            self.P = self.P - K @ H @ self.P
        for k in np.flatnonzero(touching & ~self.on):
            self._add(int(k), places[k], spreads[k])
        self.on = touching.copy()

    def _add(self, k: int, place: FloatArray, spread: FloatArray) -> None:
        base, rows = self.state, slice(9 + 3 * k, 12 + 3 * k)

        def found(state: State, seen: FloatArray) -> FloatArray:
            return np.asarray(state[1][3:6] + state[0].apply(seen))

        J = derivative(lambda e: found(plus(base, e), place), 21)
        L = derivative(lambda e: found(base, place + e), 3)
        T = np.eye(21)
        T[rows] = J
        base[1][6 + 3 * k : 9 + 3 * k] = found(base, place)
        self.P = T @ self.P @ T.T
        self.P[rows, rows] += L @ spread @ L.T
