"""52.3: Fischer-Burmeister, a falling ball, and three softenings."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near, short

PROPERTIES = Properties()
holds = PROPERTIES.holds


@holds("52.3.1", "it is zero on the hyperbola 2 a b = eps², and there alone")
def _check_zero_set(answer: Answer, rng: np.random.Generator) -> None:
    a, eps = rng.uniform(0.05, 3), 10.0 ** rng.uniform(-3, -1)
    b = eps**2 / (2 * a)
    expect(abs(answer.number("fb", a, b, eps)) < 1e-6, "it is not zero on the hyperbola")
    near(answer.number("partner", a, eps), b, "b", 1e-5 * min(1.0, 1e-3 / b))
    below, above = answer.number("fb", a, 0.5 * b, eps), answer.number("fb", a, 2.0 * b + 1e-3, eps)
    expect(below < 0.0 < above, f"below and above the hyperbola it is {below:.3g} and {above:.3g}")


@holds("52.3.1", "with eps = 0 it is zero exactly where complementarity holds")
def _check_complementarity(answer: Answer, rng: np.random.Generator) -> None:
    a, b = rng.permutation([0.0, rng.uniform(0, 4)])
    expect(abs(answer.number("fb", a, b, 0.0)) < 1e-6, "it is not zero on the law")
    x, y = rng.uniform(0.1, 3, 2)
    a, b = ((x, y), (-x, 0.0), (0.0, -y), (-x, y), (x, -y))[rng.integers(5)]
    found = answer.number("fb", a, b, 0.0)
    expect(abs(found) > 1e-6, "it is zero although the law is broken")


@holds("52.3.1", "the gradient agrees with differences")
def _check_gradient(answer: Answer, rng: np.random.Generator) -> None:
    (a, b), eps = rng.normal(size=2), 10.0 ** rng.uniform(-2, 0)
    h = 0.01 * float(np.sqrt(a * a + b * b + eps * eps))  # on the scale of the curvature
    right = [
        (answer.number("fb", a + h, b, eps) - answer.number("fb", a - h, b, eps)) / (2 * h),
        (answer.number("fb", a, b + h, eps) - answer.number("fb", a, b - h, eps)) / (2 * h),
    ]
    near(answer.numbers((2,), "gradient", a, b, eps), right, "the gradient", 1e-3)


@holds("52.3.1", "the gradient is a number at the foot that just touches, (0, 0) with eps = 0", 1)
def _check_at_the_corner(answer: Answer, rng: np.random.Generator) -> None:
    del rng
    x, y = answer.numbers((2,), "gradient", 0.0, 0.0, 0.0)
    expect(np.hypot(x - 1, y - 1) <= 1 + 1e-6, f"({x:.3g}, {y:.3g}) is no limit of gradients nearby")


def _drop_ball(answer: Answer, rng: np.random.Generator) -> tuple[float, float, float, np.ndarray]:
    height, mass, dt = rng.uniform(0.2, 2.0), rng.uniform(0.2, 20), rng.choice([0.005, 0.01, 0.02])
    steps = int(np.sqrt(2 * height / 9.81) / dt) + 30
    found = answer.numbers((3, steps), "drop", height, mass, dt, steps)
    return height, mass, dt, found


@holds("52.3.2", "each step obeys Newton's law", 8)
def _check_newton(answer: Answer, rng: np.random.Generator) -> None:
    height, mass, dt, (z, v, impulse) = _drop_ball(answer, rng)
    change = mass * np.diff(v, prepend=0.0) - impulse + mass * 9.81 * dt
    step = int(np.argmax(np.abs(change)))
    expect(
        np.abs(change).max() < 1e-5 * mass, f"step {step} is off by {change[step]:.3g} N s: no dynamics hold"
    )
    way = np.diff(z, prepend=height) - dt * v
    expect(np.abs(way).max() < 1e-6, f"heights and velocities disagree by {np.abs(way).max():.3g} m")


@holds("52.3.2", "no penetration, no pull, no impulse across a gap", 8)
def _check_signorini(answer: Answer, rng: np.random.Generator) -> None:
    _, mass, _, (z, _, impulse) = _drop_ball(answer, rng)
    expect(z.min() > -1e-5, f"it is {-z.min():.3g} m deep at the end of a step")
    expect(impulse.min() > -1e-5 * mass, f"the ground pulls with {-impulse.min():.3g} N s")
    product = (z * impulse / mass).max()
    expect(product < 1e-4, f"gap times impulse over mass is {product:.3g} somewhere")


@holds("52.3.2", "it falls, touches down when it must, and rests on m g dt", 8)
def _check_phases(answer: Answer, rng: np.random.Generator) -> None:
    height, mass, dt, (z, v, impulse) = _drop_ball(answer, rng)
    down = np.flatnonzero(z < 1e-4)
    expect(len(down), "it never comes down")
    touch = dt * (down[0] + 1)
    fall = np.sqrt(2 * height / 9.81)
    expect(abs(touch - fall) < 3 * dt, f"it touches down after {touch:.3f} s, expected {fall:.3f}")
    near(impulse[-5:], np.full(5, mass * 9.81 * dt), "the impulses at the end", 1e-3)
    expect(abs(v[-1]) < 1e-3, f"at the end it moves with {v[-1]:.3g} m/s")


def _contact(rng: np.random.Generator) -> tuple[float, float]:
    return rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 2.0), rng.uniform(0.2, 5.0)


@holds("52.3.3", "the band's two ends are admitted, and nothing beyond them")
def _check_band(answer: Answer, rng: np.random.Generator) -> None:
    (a, c), eps = _contact(rng), 10.0 ** rng.uniform(-4, -1)
    least, most = answer.numbers((2,), "relaxed_band", a, c, eps)

    def admits(force: float) -> bool:
        gap = a + c * force
        tiny = 1e-6 * max(abs(a), c * abs(force))  # of single precision in the gap
        return gap >= -tiny and force >= -1e-9 and gap * force <= eps * (1 + 1e-6) + tiny * force

    for force in (least, 0.5 * (least + most), most):
        expect(admits(force), f"the force {force:.6g} is not admitted")
    for force in (least - 1e-3, most * 1.001 + 1e-5):
        expect(not admits(force), f"the force {force:.6g} is admitted, too")


@holds("52.3.3", "no other force has a lower cost with the barrier")
def _check_barrier(answer: Answer, rng: np.random.Generator) -> None:
    (a, c), kappa = _contact(rng), 10.0 ** rng.uniform(-4, -1)
    force = answer.number("barrier", a, c, kappa)
    expect(force > 0, f"it is {force:.3g}: a logarithm wants more than zero")

    def cost(x: float) -> float:
        return float(0.5 * c * x * x + a * x - kappa * np.log(x))

    for other in force * np.array([0.5, 0.99, 1.01, 2.0]):
        expect(cost(other) >= cost(force) - 1e-12, f"the cost is lower at {other:.5g} than at {force:.5g}")


@holds("52.3.3", "Fischer-Burmeister's equation holds, with eps squared under the root")
def _check_fischer(answer: Answer, rng: np.random.Generator) -> None:
    (a, c), eps = _contact(rng), 10.0 ** rng.uniform(-3, -1)
    force = answer.number("fischer_burmeister", a, c, eps)
    gap, tiny = a + c * force, 1e-6 * max(abs(a), c * abs(force))  # of single precision in the gap
    expect(gap > -tiny and force > 0, f"gap {gap:.3g} and force {force:.3g} are not both positive")
    share = 2 * gap * force / eps**2
    expect(abs(share - 1) < 1e-4 + 2 * tiny * force / eps**2, f"twice gap times force is {share:.5g} of eps²")


@holds("52.3.3", "all three come to the law as they are hardened")
def _check_hardened(answer: Answer, rng: np.random.Generator) -> None:
    a, c = _contact(rng)
    right = max(0.0, -a / c)
    for name in ("barrier", "fischer_burmeister"):
        found = answer.number(name, a, c, 1e-8)
        expect(abs(found - right) < 1e-5, f"the force is {found:.6g}, the law's {right:.6g}")
    band = answer.numbers((2,), "relaxed_band", a, c, 1e-8)
    expect(np.abs(band - right).max() < 1e-5, f"the band is {short(band)}, the law's force {right:.6g}")


@holds("52.3.3", "the continuation starts soft, halves, and stops once below the end")
def _check_continuation(answer: Answer, rng: np.random.Generator) -> None:
    start, end = rng.uniform(0.05, 1), 10.0 ** rng.uniform(-5, -2)
    found = np.asarray(answer.call("continuation", start, end), float)
    expect(found.ndim == 1 and len(found), f"it is {short(found)}, expected a list of numbers")
    near(found[0], start, "the first")
    near(found[1:] / found[:-1], np.full(len(found) - 1, 0.5), "the ratio of one to the last")
    expect(
        found[-1] < end and (found[:-1] >= end).all(), f"it stops at {found[-1]:.3g}; the end is {end:.3g}"
    )
