"""Force allocation instances: four feet, wanted wrenches from easy to impossible, and trajectories."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY, rotation_from_quaternion, skew

CLASSES = ("easy", "near-boundary", "infeasible-wrench")
FEET = np.array([[0.19, 0.14, 0.0], [0.19, -0.14, 0.0], [-0.19, 0.14, 0.0], [-0.19, -0.14, 0.0]])
CENTRE_OF_MASS = np.array([0.0, 0.0, 0.3])
MU, NORMAL_MIN, NORMAL_MAX = 0.6, 5.0, 250.0
WRENCH_WEIGHTS = np.array([1.0, 1.0, 1.0, 10.0, 10.0, 10.0])
FORCE_WEIGHT = 1e-2


@dataclass(frozen=True)
class Instance:
    """One allocation: the map from forces to the wrench, the wanted wrench, and what the feet can take.

    Attributes
    ----------
    grasp_map, wrench
        (6, 3n) and (6,) [N, N·m].
    mu, normal_min, normal_max
        (n,) friction and bounds on the normal forces [N]; normal_max = 0 for a foot in the air.
    """

    grasp_map: FloatArray
    wrench: FloatArray
    mu: FloatArray
    normal_min: FloatArray
    normal_max: FloatArray

    @property
    def active(self) -> BoolArray:
        """(n,) which feet may carry force."""
        return self.normal_max > 0.0


def random_rotation(rng: np.random.Generator) -> FloatArray:
    """Return a rotation (3, 3) uniform over all rotations."""
    return rotation_from_quaternion(rng.normal(size=4))


def tilted(rng: np.random.Generator, largest: float) -> FloatArray:
    """Return a rotation (3, 3) whose z axis leans by up to `largest` [rad], turned at random about it."""
    lean, heading, turn = largest * rng.uniform(), *rng.uniform(0.0, 2.0 * np.pi, 2)
    axis = np.array([np.cos(heading), np.sin(heading), 0.0]) * np.sin(0.5 * lean)
    quaternion = np.array([*axis, np.cos(0.5 * lean)])
    spin = np.array([0.0, 0.0, np.sin(0.5 * turn), np.cos(0.5 * turn)])
    return np.asarray(rotation_from_quaternion(quaternion) @ rotation_from_quaternion(spin))


def grasp_map(rotations: FloatArray, arms: FloatArray) -> FloatArray:
    """Return the (6, 3n) map of contacts with (n, 3, 3) rotations at (n, 3) arms from the centre of mass."""
    blocks = [np.vstack([R, skew(arm) @ R]) for R, arm in zip(rotations, arms, strict=True)]
    return np.ascontiguousarray(np.hstack(blocks))


def forces_in_cones(
    rng: np.random.Generator, mu: FloatArray, low: float, high: float, boundary: bool
) -> FloatArray:
    """Return (n, 3) forces: anywhere within, or each on the side of its cone."""
    n = mu.size
    z = rng.uniform(low, high, n)
    radius = mu * z * (1.0 if boundary else 0.6 * np.sqrt(rng.uniform(size=n)))
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def four_feet(kind: str, count: int, seed: int = 0) -> list[Instance]:
    """Return allocations for a standing quadruped, feet on ground that leans by up to 0.3 rad.

    In "easy" the wanted wrench belongs to forces well inside the cones, in "near-boundary" to forces
    on their sides, and "infeasible-wrench" wants about as much again as the feet can give sideways.
    """
    if kind not in CLASSES:
        raise ProblemError(f"unknown class {kind!r}; valid names: {', '.join(CLASSES)}")
    rng = np.random.default_rng([seed, CLASSES.index(kind)])
    n = len(FEET)
    mu, low, high = np.full(n, MU), np.full(n, NORMAL_MIN), np.full(n, NORMAL_MAX)
    out = []
    for _ in range(count):
        rotations = np.array([tilted(rng, 0.3) for _ in range(n)])
        arms = FEET + rng.uniform(-0.04, 0.04, (n, 3)) - CENTRE_OF_MASS
        A = grasp_map(rotations, arms)
        if kind == "infeasible-wrench":
            push = rng.uniform(0.0, 2.0 * np.pi)
            size = rng.uniform(1.5, 3.0) * MU * 160.0
            w = np.array([size * np.cos(push), size * np.sin(push), 160.0, *rng.normal(size=3) * 15.0])
        else:
            f = forces_in_cones(rng, mu, 10.0, 90.0, boundary=kind == "near-boundary")
            w = A @ f.ravel()
        out.append(Instance(A, w, mu, low, high))
    return out


def random_instances(count: int, seed: int = 0) -> Iterator[Instance]:
    """Yield the hard test set: 2 to 8 contacts turned at random, mu 0.05 to 1.5.

    Every second wanted wrench belongs to forces on the cones' sides, every fourth to forces inside
    them, every fourth to none.
    """
    rng = np.random.default_rng(seed)
    for k in range(count):
        n = int(rng.integers(2, 9))
        mu = rng.uniform(0.05, 1.5, n)
        rotations = np.array([random_rotation(rng) for _ in range(n)])
        A = grasp_map(rotations, rng.uniform(-1.0, 1.0, (n, 3)) * [0.3, 0.2, 0.1] - CENTRE_OF_MASS)
        f = forces_in_cones(rng, mu, NORMAL_MIN, 0.5 * NORMAL_MAX, boundary=k % 2 == 0)
        w = rng.normal(size=6) * [150.0, 150.0, 150.0, 30.0, 30.0, 30.0] if k % 4 == 1 else A @ f.ravel()
        yield Instance(A, w, mu, np.full(n, NORMAL_MIN), np.full(n, NORMAL_MAX))


def pushed_stance(count: int = 500, period: float = 0.002) -> list[Instance]:
    """Return a smooth trajectory: a standing quadruped that is pushed twice, one instance per `period` [s].

    The body sways as a damped spring after each push; the wanted wrench is what a PD law asks for.
    """
    n = len(FEET)
    mu, low, high = np.full(n, MU), np.full(n, NORMAL_MIN), np.full(n, NORMAL_MAX)
    rotations = np.array([np.eye(3)] * n)
    out = []
    for step in range(count):
        t = step * period
        force, sway = np.zeros(2), np.zeros(2)
        for start, direction, size in ((0.1, 0.3, 110.0), (0.55, 2.4, 150.0)):
            age = t - start
            if age > 0.0:
                swing = np.exp(-4.0 * age) * np.sin(14.0 * age)
                heading = np.array([np.cos(direction), np.sin(direction)])
                force = force - size * np.exp(-4.0 * age) * np.sin(14.0 * age + 0.6) * heading
                sway = sway + 0.03 * swing * heading
        arms = FEET - CENTRE_OF_MASS - np.array([*sway, 0.0])
        moment = 0.06 * np.array([-force[1], force[0], 0.1 * force[0]])
        w = np.array([*force, 16.1 * GRAVITY + 10.0 * np.sin(9.0 * t), *moment])
        out.append(Instance(grasp_map(rotations, arms), w, mu, low, high))
    return out


def busiest(instances: list[Instance], steps: int) -> list[Instance]:
    """Return the `steps` successive instances whose wanted wrenches stray furthest from the median."""
    wrenches = np.array([i.wrench for i in instances])
    away = np.linalg.norm(wrenches - np.median(wrenches, axis=0), axis=1)
    sums = np.cumsum(np.concatenate([[0.0], away]))
    width = min(steps, len(instances))
    start = int(np.argmax(sums[width:] - sums[:-width]))
    return instances[start : start + width]


def instances_of(log: Mapping[str, Any]) -> list[Instance]:
    """Return the allocations of a controller's log.

    It holds `wrench_desired` (T, 6), `grasp_map` (T, 6, 3n), `active` (T, n), and `mu`, `normal_min`,
    `normal_max`, each a number, (T,), (n,) or (T, n); other entries say nothing here.
    """
    w, A, on = (np.asarray(log[name]) for name in ("wrench_desired", "grasp_map", "active"))
    mu, low, high = (_per_step(log[name], on.shape) for name in ("mu", "normal_min", "normal_max"))
    low, high = np.where(on, low, 0.0), np.where(on, high, 0.0)
    return [
        Instance(np.ascontiguousarray(A[t]), w[t], mu[t], np.minimum(low[t], high[t]), high[t])
        for t in range(len(w))
    ]


def _per_step(value: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return a number, (T,), (n,) or (T, n) value as (T, n)."""
    array = np.asarray(value, dtype=np.float64)
    return np.array(np.broadcast_to(array[:, None] if array.shape == shape[:1] else array, shape))
