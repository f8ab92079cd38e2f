"""52.6: turning without angular momentum, and arms that cancel it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _bodies(rng: np.random.Generator) -> tuple[float, float]:
    return rng.uniform(0.1, 1.0), rng.uniform(0.02, 0.5)


@holds("52.6.1", "a body that falls for that time comes down by the height")
def _check_fall(answer: Answer, rng: np.random.Generator) -> None:
    height = rng.uniform(0.05, 3)
    time = answer.number("fall_time", height)
    near(0.5 * 9.81 * time**2, height, "the way")


@holds("52.6.1", "the momentum is the sum of both bodies' inertia times their own rates")
def _check_sum(answer: Answer, rng: np.random.Generator) -> None:
    (trunk, legs), (own, other) = _bodies(rng), rng.normal(size=2)  # rates of trunk and legs, in the world
    found = answer.number("angular_momentum", trunk, legs, own, other - own)
    near(found, trunk * own + legs * other, "the momentum (the leg's rate counts from the trunk)")


@holds("52.6.1", "turned by the pitch change over the motion, momentum has been zero")
def _check_zero_all_the_way(answer: Answer, rng: np.random.Generator) -> None:
    trunk, legs = _bodies(rng)
    angles = np.cumsum(rng.normal(size=40)) * 0.05
    total = answer.number("pitch_change", trunk, legs, angles)
    swung = angles[-1] - angles[0]
    left = trunk * total + legs * (total + swung)  # the momentum's integral over the motion
    expect(abs(left) < 1e-6, f"by {total:.5g} rad of pitch the momentum's integral is {left:.3g}, not zero")


@holds("52.6.1", "legs that come back to where they were leave no pitch")
def _check_closed(answer: Answer, rng: np.random.Generator) -> None:
    (trunk, legs), half = _bodies(rng), np.cumsum(rng.normal(size=12)) * 0.1
    found = answer.number("pitch_change", trunk, legs, np.r_[half, half[::-1]])
    near(found, 0.0, "the pitch change")


def _turn_along(trunk: float, path: np.ndarray) -> float:
    """Return the trunk's turn along a path, in many small steps of zero momentum."""
    turned = 0.0
    for (j0, a0), (j1, a1) in pairwise(path):
        s = (np.arange(200) + 0.5) / 200
        inertia = j0 + s * (j1 - j0)
        turned -= float(np.mean(inertia / (trunk + inertia))) * (a1 - a0)
    return turned


def _shapes(rng: np.random.Generator) -> tuple[float, float, float, float]:
    trunk, small = rng.uniform(0.2, 1.0), rng.uniform(0.05, 0.2)
    return trunk, small, small * rng.uniform(2, 6), rng.uniform(0.4, 1.5)


@holds("52.6.2", "the turn along a path keeps angular momentum at zero")
def _check_along(answer: Answer, rng: np.random.Generator) -> None:
    trunk, small, large, swing = _shapes(rng)
    path = [(small, 0.0)]
    for _ in range(int(rng.integers(2, 9))):
        inertia, angle = path[-1]
        if rng.integers(2):
            path.append((rng.uniform(small, large), angle))
        else:
            path.append((inertia, rng.uniform(-swing, swing)))
    near(answer.number("turn", trunk, np.array(path)), _turn_along(trunk, np.array(path)), "the turn", 1e-5)


@holds("52.6.2", "a path there and back turns nothing, a loop the other way round turns back")
def _check_reversed(answer: Answer, rng: np.random.Generator) -> None:
    trunk, small, large, swing = _shapes(rng)
    loop = np.array([(small, -swing), (large, -swing), (large, swing), (small, swing), (small, -swing)])
    near(answer.number("turn", trunk, np.vstack([loop, loop[::-1]])), 0.0, "the turn there and back")
    once, back = answer.number("turn", trunk, loop), answer.number("turn", trunk, loop[::-1])
    expect(abs(once) > 1e-6, "a loop of two joints turns nothing")
    near(back, -once, "the turn of the loop reversed")


@holds("52.6.2", "the path found turns the trunk as ordered, within its limits, and ends as it began", 10)
def _check_ordered(answer: Answer, rng: np.random.Generator) -> None:
    trunk, small, large, swing = _shapes(rng)
    angle = rng.choice([-1.0, 1.0]) * rng.choice([np.pi, rng.uniform(0.5, np.pi)])
    found = np.asarray(answer.call("path_for", trunk, small, large, swing, angle), float)
    expect(found.ndim == 2 and found.shape[1] == 2, f"it has the shape {found.shape}, expected (n, 2)")
    expect(len(found) < 2000, f"it has {len(found)} points, expected fewer than 2000")
    inside = (
        (found[:, 0] >= small - 1e-6) & (found[:, 0] <= large + 1e-6) & (np.abs(found[:, 1]) <= swing + 1e-6)
    )
    expect(inside.all(), "it leaves its limits")
    steps = np.abs(np.diff(found, axis=0)) > 1e-12
    expect(not steps.all(axis=1).any(), "a step changes inertia and angle at once")
    expect(np.abs(found[0] - found[-1]).max() < 1e-9, "it does not end in the shape that it began with")
    near(_turn_along(trunk, found), angle, "the trunk's turn", 1e-3)


@holds("52.6.3", "the momentum is about the points' own centre of mass, which may move")
def _check_own_centre(answer: Answer, rng: np.random.Generator) -> None:
    n = int(rng.integers(2, 8))
    masses, x, v = rng.uniform(0.2, 5, n), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    right = np.zeros(3)
    for i in range(n):  # by pairs: no centre needed
        for j in range(i):
            right += masses[i] * masses[j] / masses.sum() * np.cross(x[i] - x[j], v[i] - v[j])
    shift, drift = rng.normal(size=3) * 4, rng.normal(size=3) * 4
    near(answer.numbers((3,), "angular_momentum", masses, x + shift, v + drift), right, "the momentum")


@holds("52.6.3", "with the arms' speed legs and arms together have no yaw momentum")
def _check_cancelled(answer: Answer, rng: np.random.Generator) -> None:
    leg, hip, speed, arm, shoulder = (
        *rng.uniform([3, 0.05, -3], [12, 0.2, 3]),
        *rng.uniform([1, 0.1], [5, 0.3]),
    )
    found = answer.number("arm_speed", leg, hip, speed, arm, shoulder)
    y = np.array([hip, -hip, shoulder, -shoulder])
    forward = np.array([speed, -speed, found, -found])
    yaw = -np.array([leg, leg, arm, arm]) @ (y * forward)
    expect(
        abs(yaw) < 1e-6 * leg * hip * abs(speed), f"{yaw:.4g} kg m²/s of yaw are left with {found:.4g} m/s"
    )


@holds("52.6.3", "four legs give the yaw of their points; in a trot it is zero, in a pace not")
def _check_quadruped(answer: Answer, rng: np.random.Generator) -> None:
    mass, width, u = rng.uniform(0.5, 3), rng.uniform(0.05, 0.25), rng.uniform(0.3, 3)
    speeds = rng.normal(size=4)
    places = width * np.array([1, -1, 1, -1])
    near(
        answer.number("quadruped_yaw", mass, width, speeds),
        -mass * np.sum(places * speeds),
        "the yaw momentum",
    )
    near(
        answer.number("quadruped_yaw", mass, width, u * np.array([1, -1, -1, 1])),
        0.0,
        "a trot's yaw momentum",
    )
    pace = answer.number("quadruped_yaw", mass, width, u * np.array([1, -1, 1, -1]))
    expect(abs(pace) > 0.1 * mass * width * u, "a pace has no yaw momentum")
