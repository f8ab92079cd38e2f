"""52.9: what a log says of friction, and experiments that decide."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near

PROPERTIES = Properties()
holds = PROPERTIES.holds


@holds("52.9.1", "the largest use is that of a loaded foot; feet in the air do not count")
def _check_use(answer: Answer, rng: np.random.Generator) -> None:
    mu, shape = rng.uniform(0.2, 1.0), (int(rng.integers(5, 20)), 4)
    normal, share = rng.uniform(2, 200, shape), rng.uniform(0, 1.2, shape)
    turn = rng.uniform(0, 2 * np.pi, shape)
    forces = np.stack(
        [share * mu * normal * np.cos(turn), share * mu * normal * np.sin(turn), normal], axis=2
    )
    airborne = rng.random(shape) < 0.3
    airborne[0, 0] = False
    forces[airborne] = rng.normal(size=(int(airborne.sum()), 3)) * [0.3, 0.3, 0.0]
    near(answer.number("friction_use", forces, mu), share[~airborne].max(), "the use")


@holds("52.9.1", "slip is the way of feet on the ground while they bear, not their swing")
def _check_slip(answer: Answer, rng: np.random.Generator) -> None:
    steps = int(rng.integers(10, 40))
    loaded = rng.random((steps, 4)) < 0.6
    ways = rng.normal(size=(steps - 1, 4, 3)) * 0.05
    positions = np.concatenate([np.zeros((1, 4, 3)), np.cumsum(ways, axis=0)])
    right = 0.0
    for step in range(steps - 1):
        for foot in range(4):
            if loaded[step, foot] and loaded[step + 1, foot]:
                right += float(np.hypot(*ways[step, foot, :2]))
    near(answer.number("slip", positions, loaded), right, "the slip")


@holds("52.9.1", "equal policies are not said to react", 1)
def _check_false_alarms(answer: Answer, rng: np.random.Generator) -> None:
    alarms, cases = 0, 100
    for _ in range(cases):
        level, spread, n = rng.normal() * 10, 10.0 ** rng.uniform(-2, 2), int(rng.integers(10, 25))
        alarms += answer.truth(
            "reacts", level + spread * rng.normal(size=n), level + spread * rng.normal(size=n)
        )
    expect(
        alarms <= 12, f"it says so in {alarms} of {cases} cases of equal distributions, at most 5 % are right"
    )


@holds("52.9.1", "a difference of three spreads is found, in either direction and any unit", 10)
def _check_found(answer: Answer, rng: np.random.Generator) -> None:
    level, spread, n = rng.normal() * 10, 10.0 ** rng.uniform(-2, 2), int(rng.integers(10, 25))
    low = level + spread * rng.normal(size=n)
    high = level + spread * (rng.choice([-3.0, 3.0]) + rng.normal(size=n))
    expect(answer.truth("reacts", low, high), "it says that they do not differ")


@holds("52.9.2", "that many trials have the power ordered, a half of them has not")
def _check_power(answer: Answer, rng: np.random.Generator) -> None:
    difference, spread = rng.uniform(0.1, 0.5), 1.0
    level, power = rng.choice([0.01, 0.05]), rng.choice([0.8, 0.9])
    unit = 10.0 ** rng.uniform(-2, 2)
    n = answer.number("trials", difference * unit, spread * unit, level, power)
    expect(n == round(n) and n >= 1, f"it is {n:g}, expected a whole number")
    limit = NormalDist().inv_cdf(1 - level / 2)

    def chance(trials: float) -> float:
        return 1.0 - NormalDist(difference / (spread * np.sqrt(2 / trials))).cdf(limit)

    reached = chance(n)
    expect(
        power - 1e-6 <= reached <= power + 0.05,
        f"{n:g} trials of each see it with {reached:.3f}, not {power:g}",
    )


@holds("52.9.2", "each pair of trials has both policies")
def _check_pairs(answer: Answer, rng: np.random.Generator) -> None:
    pairs, seed = int(rng.integers(5, 40)), int(rng.integers(1000))
    order = answer.call("schedule", pairs, seed)
    expect(
        isinstance(order, str) and len(order) == 2 * pairs, f"it has not {2 * pairs} letters: {order!r:.60}"
    )
    expect(set(order) <= {"A", "B"}, f"it has other letters than A and B: {order!r:.60}")
    both = [{order[2 * k], order[2 * k + 1]} == {"A", "B"} for k in range(pairs)]
    expect(
        all(both), f"pair {both.index(False) + 1 if not all(both) else 0} has one policy twice: {order:.60}"
    )


@holds("52.9.2", "who goes first is random: about half of the pairs, and another order for another seed", 3)
def _check_random_order(answer: Answer, rng: np.random.Generator) -> None:
    seed = int(rng.integers(1000))
    first, second = (answer.call("schedule", 200, s) for s in (seed, seed + 1))
    expect(isinstance(first, str) and isinstance(second, str), "it is no string")
    count = first[::2].count("A")
    expect(60 <= count <= 140, f"A goes first in {count} of 200 pairs: what drifts within a pair favours one")
    expect(first != second, "two seeds give one order")


@holds("52.9.2", "with no difference p values below 0.1 come in one case of ten", 1)
def _check_uniform(answer: Answer, rng: np.random.Generator) -> None:
    cases, low = 300, 0
    for _ in range(cases):
        n = int(rng.integers(7, 10))
        drift = np.cumsum(rng.normal(size=n))  # both trials of a pair have it
        low += answer.number("p_value", drift + rng.normal(size=n), drift + rng.normal(size=n)) <= 0.1
    expect(
        12 <= low <= 46, f"it is below 0.1 in {low} of {cases} cases without a difference, expected about 30"
    )


@holds("52.9.2", "the p value is two-sided, between 0 and 1, and small for a clear difference")
def _check_two_sided(answer: Answer, rng: np.random.Generator) -> None:
    n, sign = int(rng.integers(9, 12)), rng.choice([-1.0, 1.0])
    a, b = sign * 3 + rng.normal(size=n), rng.normal(size=n)
    p, other = answer.number("p_value", a, b), answer.number("p_value", b, a)
    expect(0 <= p <= 1, f"it is {p:.3g}")
    expect(p < 0.05, f"it is {p:.3g} for a difference of three spreads in {n} pairs")
    expect(abs(p - other) < 0.02, f"it is {p:.3g} one way round and {other:.3g} the other")
