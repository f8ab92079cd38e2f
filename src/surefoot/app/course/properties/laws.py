"""52.1: forces on slopes, Signorini's conditions, and what soft contact makes of them."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _surface(slope: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return uphill, sideways and normal directions of a slope, from its points alone."""
    uphill = np.array([1.0, 0.0, np.tan(np.radians(slope))])
    uphill /= np.linalg.norm(uphill)
    side = np.array([0.0, 1.0, 0.0])
    return uphill, side, np.cross(uphill, side)


@holds("52.1.1", "a force put together along the slope and its normal is taken apart again")
def _check_taken_apart(answer: Answer, rng: np.random.Generator) -> None:
    slope, (normal, tangential) = rng.uniform(-40, 40), rng.uniform(-100, 200, 2)
    tangential, turn = abs(tangential), rng.uniform(0, 2 * np.pi)
    uphill, side, up = _surface(slope)
    force = normal * up + tangential * (np.cos(turn) * uphill + np.sin(turn) * side)
    found = answer.numbers((2,), "split", force, slope)
    near(found, [normal, tangential], "(normal, tangential)")


@holds("52.1.1", "what is in the cone about the surface's normal is allowed, and nothing else", 40)
def _check_within_the_cone(answer: Answer, rng: np.random.Generator) -> None:
    slope, mu, share = rng.uniform(-40, 40), rng.uniform(0.2, 1.0), rng.choice([0.0, 0.97, 1.03])
    normal, turn = rng.choice([1.0, 1.0, -1.0]) * rng.uniform(5, 200), rng.uniform(0, 2 * np.pi)
    uphill, side, up = _surface(slope)
    force = normal * up + share * mu * abs(normal) * (np.cos(turn) * uphill + np.sin(turn) * side)
    right = normal > 0 and share < 1
    found = answer.truth("allowed", force, slope, mu)
    expect(found == right, f"it says {found}, but {share:.0%} of the friction of {normal:.1f} N is used")


@holds("52.1.1", "a weight's reaction is allowed from the least friction on, not below it")
def _check_least_friction(answer: Answer, rng: np.random.Generator) -> None:
    slope = rng.uniform(2, 60)
    least = answer.number("least_mu", slope)
    uphill, _, up = _surface(slope)
    near(least, abs(uphill[2] / up[2]), "the friction")
    for mu in (0.98 * least, 1.02 * least):
        found = answer.truth("stands", slope, mu)
        expect(found == (mu > least), f"it says {found}")


@holds("52.1.2", "the residual is zero where the law holds, for every r")
def _check_zero_on_the_law(answer: Answer, rng: np.random.Generator) -> None:
    r = rng.uniform(0.01, 10.0)
    gap, force = rng.permutation([0.0, rng.uniform(0, 5) * rng.integers(2)])
    near(answer.number("residual", gap, force, r), 0.0, "the residual")


@holds("52.1.2", "the residual is not zero where the law is broken")
def _check_not_zero_elsewhere(answer: Answer, rng: np.random.Generator) -> None:
    a, b, r = *rng.uniform(0.1, 5, 2), rng.uniform(0.1, 10.0)
    gap, force = ((-a, 0.0), (0.0, -b), (a, b), (-a, b), (a, -b), (-a, -b))[rng.integers(6)]
    found = answer.number("residual", gap, force, r)
    expect(abs(found) > 1e-6, f"the residual is {found:.3g}: gap {gap:.3g} and force {force:.3g} pass")


@holds("52.1.2", "the normal cone holds the directions that no admissible gap lies ahead of", 40)
def _check_variational(answer: Answer, rng: np.random.Generator) -> None:
    gap = rng.choice([0.0, 0.0, rng.uniform(0.1, 3), -rng.uniform(0.1, 3)])
    direction = rng.choice([0.0, rng.uniform(0.1, 3), -rng.uniform(0.1, 3)])
    others = np.r_[0.0, rng.uniform(0, 10, 50)]
    right = gap >= 0 and bool(np.all(direction * (others - gap) <= 0))
    found = answer.truth("in_normal_cone", direction, gap)
    expect(found == right, f"it says {found}; direction · (other gap - gap) decides")


@holds("52.1.2", "the normal cone says what Signorini says", 40)
def _check_same_law(answer: Answer, rng: np.random.Generator) -> None:
    gap, force = (rng.choice([0.0, rng.uniform(0.1, 5), -rng.uniform(0.1, 5)]) for _ in range(2))
    right = gap >= 0 and force >= 0 and gap * force == 0
    found = answer.truth("lawful", gap, force)
    expect(found == right, f"it says {found}")


@holds("52.1.3", "penetration, pull and product of a log are measured, none negative", 40)
def _check_measured(answer: Answer, rng: np.random.Generator) -> None:
    gaps = rng.uniform(0.0, 0.01, 30) * rng.integers(2, size=30)
    forces = np.where(gaps > 0, 0.0, rng.uniform(0, 50, 30))
    deep, pull, far = rng.uniform(1e-4, 1e-2), rng.uniform(0.1, 5), rng.uniform(1, 9)
    broken = rng.choice([*range(8), 1, 1, 1, 1])
    at = rng.choice(30, 3, replace=False)
    right = [0.0, 0.0, 0.0]
    if broken & 1:
        light = 0.1 * far  # so that the penetration is the largest error where nothing else is broken
        gaps[at[0]], forces[at[0]], right[0] = -deep, light, deep
        right[2] = deep * light
    if broken & 2:
        gaps[at[1]], forces[at[1]], right[1] = 0.0, -pull, pull
    if broken & 4:
        gaps[at[2]], forces[at[2]], right[2] = 0.02, far, max(right[2], 0.02 * far)
    found = answer.numbers((3,), "signorini_errors", gaps, forces)
    near(found, right, "(penetration, pull, product)")
    tol = max(right) * rng.choice([0.5, 1.5]) + 1e-9
    said = answer.truth("satisfies", gaps, forces, tol)
    expect(said == all(x <= tol for x in right), f"it says {said}; the errors are {right}")


@holds("52.1.3", "a body at the resting depth has no acceleration under MuJoCo's law")
def _check_rests(answer: Answer, rng: np.random.Generator) -> None:
    tc, ratio, d = rng.uniform(0.004, 0.1), rng.uniform(0.5, 1.5), rng.uniform(0.5, 0.98)
    depth = answer.number("resting_depth", tc, ratio, d)
    stiffness = 1.0 / (d * tc**2 * ratio**2)
    acceleration = (1.0 - d) * -9.81 + d * stiffness * depth
    expect(abs(acceleration) < 1e-5, f"at {depth:.6g} m it accelerates by {acceleration:.3g} m/s²")
