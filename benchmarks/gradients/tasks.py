"""The small tasks: a ball and a wall, a pushed block, a hopper, a slide whose friction is sought."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from benchmarks.gradients.systems import Scene, System
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY

THICKNESS = 0.12
"""Of the ball's wall [m]: what springs let it sink in."""


@dataclass(frozen=True)
class Ball(System):
    """A ball is thrown at an angle theta [rad]; it should land as far as it can, but there is a wall.

    q = (x, z). Over the wall it goes far, below its edge it drops at its foot: the loss jumps.
    """

    name: str = "ball and wall"
    masses: FloatArray = field(default_factory=lambda: np.array([1.0, 1.0]))
    dt: float = 0.02
    steps: int = 60
    low: float = 0.1
    high: float = 1.4
    speed: float = 8.0
    wall: float = 3.0
    edge: float = 1.5

    def start(self, theta: float) -> tuple[FloatArray, FloatArray]:
        """One metre above the origin."""
        return np.array([0.0, 1.0]), self.speed * np.array([np.cos(theta), np.sin(theta)])

    def force(self, q: FloatArray, v: FloatArray, time: float, theta: float) -> FloatArray:
        """Return gravity."""
        return np.array([0.0, -GRAVITY])

    def scene(self, q: FloatArray, theta: float) -> Scene:
        """Return the ground, and the wall's near face up to its edge."""
        gaps, rows, slopes = [q[1]], [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]], [[0.0, 1.0]]
        if q[1] < self.edge and q[0] <= self.wall + THICKNESS:
            gaps.append(self.wall - q[0])
            rows += [[0.0, 1.0], [0.0, 0.0], [-1.0, 0.0]]
            slopes.append([-1.0, 0.0])
        return Scene(np.array(gaps), np.array(rows), np.full(len(gaps), 0.8), np.array(slopes))

    def loss(self, q: FloatArray, v: FloatArray) -> float:
        """Distance not covered [m]."""
        return float(8.0 - q[0])


@dataclass(frozen=True)
class Block(System):
    """A hand that is drawn to theta [m] pushes a block to 0.3 m over a rough table; it may not reach it.

    q = (x of the hand, x of the block, z of the block).
    """

    name: str = "pushed block"
    masses: FloatArray = field(default_factory=lambda: np.array([0.5, 1.0, 1.0]))
    dt: float = 0.02
    steps: int = 50
    low: float = -0.15
    high: float = 0.6
    mu: float = 0.3
    goal: float = 0.3

    def start(self, theta: float) -> tuple[FloatArray, FloatArray]:
        """At rest, the hand 0.1 m from the block."""
        return np.array([-0.1, 0.0, 0.0]), np.zeros(3)

    def force(self, q: FloatArray, v: FloatArray, time: float, theta: float) -> FloatArray:
        """Return spring and damper of the hand, and gravity."""
        return np.array([60.0 * (theta - q[0]) - 12.0 * v[0], 0.0, -GRAVITY * self.masses[2]])

    def scene(self, q: FloatArray, theta: float) -> Scene:
        """Return the table under the block, and the hand against it."""
        J = np.zeros((6, 3))
        J[0, 1] = J[2, 2] = 1.0
        J[5] = [-1.0, 1.0, 0.0]
        slopes = np.array([[0.0, 0.0, 1.0], [-1.0, 1.0, 0.0]])
        return Scene(np.array([q[2], q[1] - q[0]]), J, np.array([self.mu, 0.0]), slopes)

    def loss(self, q: FloatArray, v: FloatArray) -> float:
        """Square of the distance to the goal, in units of 0.1 m."""
        return float(100.0 * (q[1] - self.goal) ** 2)


@dataclass(frozen=True)
class Hopper(System):
    """A body on a springy leg pushes off with theta [N] for 0.1 s; it should reach 1.0 m.

    q = (z of the body, z of the foot). It falls from 0.1 m above its stance and pushes while it stands.
    """

    name: str = "hopper"
    masses: FloatArray = field(default_factory=lambda: np.array([2.0, 0.3]))
    dt: float = 0.01
    steps: int = 45
    low: float = -60.0
    high: float = 140.0
    goal: float = 1.0

    def start(self, theta: float) -> tuple[FloatArray, FloatArray]:
        """At rest in the air."""
        return np.array([0.6, 0.1]), np.zeros(2)

    def force(self, q: FloatArray, v: FloatArray, time: float, theta: float) -> FloatArray:
        """Return the leg's spring, damper and push, and gravity."""
        leg = 400.0 * (0.5 - (q[0] - q[1])) - 8.0 * (v[0] - v[1]) + (theta if 0.25 <= time < 0.35 else 0.0)
        return np.array([leg, -leg]) - GRAVITY * self.masses

    def scene(self, q: FloatArray, theta: float) -> Scene:
        """Return the foot on the ground."""
        J = np.zeros((3, 2))
        J[2, 1] = 1.0
        return Scene(q[1:], J, np.array([0.5]), np.array([[0.0, 1.0]]))

    def loss(self, q: FloatArray, v: FloatArray) -> float:
        """Square of the height that the body would miss from here."""
        return float((q[0] + 0.5 * v[0] * abs(v[0]) / GRAVITY - self.goal) ** 2)


@dataclass(frozen=True)
class Slide(System):
    """A block slides from 1 m/s until friction theta has stopped it; it was seen to end as with mu 0.25.

    q = (x, z).
    """

    name: str = "friction of a slide"
    masses: FloatArray = field(default_factory=lambda: np.array([1.0, 1.0]))
    dt: float = 0.01
    steps: int = 60
    low: float = 0.15
    high: float = 0.9
    truth: float = 0.25

    def start(self, theta: float) -> tuple[FloatArray, FloatArray]:
        """On the table, at 1 m/s."""
        return np.zeros(2), np.array([1.0, 0.0])

    def force(self, q: FloatArray, v: FloatArray, time: float, theta: float) -> FloatArray:
        """Return gravity."""
        return np.array([0.0, -GRAVITY])

    def scene(self, q: FloatArray, theta: float) -> Scene:
        """Return the table."""
        J = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
        return Scene(q[1:], J, np.array([theta]), np.array([[0.0, 1.0]]))

    def loss(self, q: FloatArray, v: FloatArray) -> float:
        """Square of the distance to where it was seen to end, in units of 0.1 m."""
        way = 0.5 / (self.truth * GRAVITY)
        return float(100.0 * (q[0] - way) ** 2)
