"""Balls that are dropped, thrown and spun, integrated from event to event without any step.

Flights are parabolas and touches are instants, so that a log of any rate tells the same motion: a row holds
what is so at its start, and the mean of the ground's impulses over it. A touch takes restitution e and as
much friction as stops the slip, or all there is (Coulomb). Bounces grow shorter by e; those slower than
`LEAST` are the last.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log

LEAST = 1e-4
"""Speed below which a ball has come to rest on the ground [m/s]."""


@dataclass(frozen=True)
class Drop:
    """A solid ball and how it starts.

    Attributes
    ----------
    height
        Of its lowest point [m].
    speed
        Across the ground, and upwards [m/s].
    spin
        About the axis that rolls it forward [rad/s].
    restitution, mu
        Of its touches [-].
    mass, radius
        [kg], [m].
    """

    height: float
    speed: tuple[float, float]
    spin: float
    restitution: float
    mu: float
    mass: float = 1.0
    radius: float = 0.05

    @classmethod
    def seeded(cls, seed: int) -> Drop:
        """Return a drop from 5 cm to 1 m, at any restitution, across the ground at up to 2 m/s."""
        rng = np.random.default_rng([seed, 56])
        height, across, up, spin = rng.uniform([0.05, -2.0, -1.0, -30.0], [1.0, 2.0, 1.0, 30.0])
        restitution, mu, mass = rng.uniform([0.0, 0.1, 0.2], [1.0, 1.0, 20.0])
        return cls(float(height), (float(across), float(up)), float(spin), restitution, mu, mass)

    def log(self, dt: float, duration: float = 1.5, kick: float = 0.0) -> Log:
        """Return rows of a step [s] over a time [s]; a kick in the middle adds to the speed [m/s]."""
        count = round(duration / dt)
        state, impulse = np.empty((count + 1, 5)), np.zeros((count, 2))
        now = np.array([0.0, self.height, *self.speed, self.spin])
        for k in range(count):
            now[2] += kick if k == count // 2 else 0.0
            state[k] = now
            now, impulse[k] = self._over(now, dt)
        state[count] = now
        return self._as_log(state, impulse, dt)

    def _over(self, state: FloatArray, time: float) -> tuple[FloatArray, FloatArray]:
        """Return x, z, their rates and the spin after a time, and the impulse (along, up) in it."""
        x, z, u, w, spin = state.tolist()
        total, left = np.zeros(2), time
        while True:
            if z <= 0.0 and abs(w) < LEAST:
                u, spin, force = self._slide(u, spin, left)
                total += force
                return np.array([x + 0.5 * left * (state[2] + u), 0.0, u, 0.0, spin]), total
            falls = (w + np.sqrt(w * w + 2.0 * GRAVITY * max(z, 0.0))) / GRAVITY
            if falls > left:
                x, z, w = x + u * left, z + w * left - 0.5 * GRAVITY * left**2, w - GRAVITY * left
                return np.array([x, max(z, 0.0), u, w, spin]), total
            x, z, w, left = x + u * falls, 0.0, w - GRAVITY * falls, left - falls
            up = -w * (1.0 + self.restitution) * self.mass
            w = -w * self.restitution
            w = 0.0 if w < LEAST else w
            along, u, spin = self._rub(u, spin, self.mu * up)
            total += (along, up)

    def _rub(self, u: float, spin: float, most: float) -> tuple[float, float, float]:
        """Return friction's impulse of at most so much [N s], and the speed and spin after it."""
        slip = u - self.radius * spin
        # A solid ball's slip changes by 7/2 of what its speed does.
        along = float(np.clip(-slip * self.mass * 2.0 / 7.0, -most, most))
        return along, u + along / self.mass, spin - 2.5 * along / (self.mass * self.radius)

    def _slide(self, u: float, spin: float, time: float) -> tuple[float, float, FloatArray]:
        weight = self.mass * GRAVITY * time
        along, u, spin = self._rub(u, spin, self.mu * weight)
        return u, spin, np.array([along, weight])

    def _as_log(self, state: FloatArray, impulse: FloatArray, dt: float) -> Log:
        count = len(impulse)
        x, z, u, w, spin = state[:count].T
        blank = np.zeros((count, 3))
        force, velocity, place = blank.copy(), blank.copy(), blank.copy()
        # Contact axes on level ground are the world's.
        force[:, 0], force[:, 2] = impulse.T / dt
        velocity[:, 0], velocity[:, 2] = u - self.radius * spin, w
        place[:, 0], place[:, 2] = x, z
        momentum, rate, com = (
            np.zeros((count, 6)),
            np.zeros((count, 6)),
            place + np.array([0.0, 0.0, self.radius]),
        )
        inertia = 0.4 * self.mass * self.radius**2
        momentum[:, 0], momentum[:, 2], momentum[:, 4] = self.mass * u, self.mass * w, inertia * spin
        rate[:, :3] = force - [0.0, 0.0, self.mass * GRAVITY]
        rate[:, 4] = -self.radius * force[:, 0]
        up = np.tile([0.0, 0.0, 1.0], (count, 1))
        arrays: dict[str, Any] = {
            "time": dt * np.arange(count), "forces": force[:, None], "gaps": z[:, None],
            "contact_velocities": velocity[:, None], "contact_positions": place[:, None],
            "normals": up[:, None], "mu": np.full(count, self.mu), "momentum": momentum,
            "momentum_rate": rate, "com": com,
        }  # fmt: skip
        return Log(arrays, {"mass": self.mass, "dt": dt, "feet": ["ball"], "contact_foot": [0]})
