"""52.8: MuJoCo's time constants, and pressure under a sole."""

from __future__ import annotations

import numpy as np

from surefoot.app.course.answer import Answer, Properties, expect, near, short

PROPERTIES = Properties()
holds = PROPERTIES.holds


def _contact(rng: np.random.Generator) -> tuple[float, float, float]:
    return rng.uniform(0.004, 0.2), rng.uniform(0.2, 2.0), rng.uniform(0.5, 0.98)


def _release(tc: float, k: float, b: float, d: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and gaps of a body let go at a gap of one, without gravity (RK4)."""
    h = tc / 400
    state, gaps = np.array([1.0, 0.0]), [1.0]
    system = np.array([[0.0, 1.0], [-d * k, -d * b]])
    for _ in range(8000):
        s1 = system @ state
        s2 = system @ (state + h / 2 * s1)
        s3 = system @ (state + h / 2 * s2)
        s4 = system @ (state + h * s3)
        state = state + h / 6 * (s1 + 2 * s2 + 2 * s3 + s4)
        gaps.append(state[0])
        if not np.isfinite(state).all():
            break
    return h * np.arange(len(gaps)), np.array(gaps)


@holds("52.8.1", "a body let go moves as the time constant and the damping ratio say", 6)
def _check_motion(answer: Answer, rng: np.random.Generator) -> None:
    tc, ratio, d = _contact(rng)
    ratio = rng.uniform(0.2, 0.8)
    k, b = answer.numbers((2,), "stiffness_damping", tc, ratio, d)
    expect(k > 0 and b > 0, f"k and b are {k:.3g} and {b:.3g}")
    times, gaps = _release(tc, k, b, d)
    slow, fast = 1.0 / tc, np.sqrt(1 - ratio**2) / (tc * ratio)
    right = np.exp(-slow * times) * (np.cos(fast * times) + slow / fast * np.sin(fast * times))
    worst = np.abs(gaps - right).max()
    expect(worst < 1e-4, f"k {k:.5g} and b {b:.5g} move it {worst:.3g} away from the motion ordered")


@holds("52.8.1", "at the resting depth the acceleration is zero, and mass does not matter")
def _check_rests(answer: Answer, rng: np.random.Generator) -> None:
    tc, ratio, d = _contact(rng)
    depth = answer.number("resting_depth", tc, ratio, d)
    acceleration = (1 - d) * -9.81 + d * depth / (d * tc**2 * ratio**2)
    expect(abs(acceleration) < 1e-6, f"at {depth:.5g} m it is {acceleration:.3g} m/s²")


@holds("52.8.1", "the overshoot is that of the motion, zero from critical damping on", 6)
def _check_overshoot(answer: Answer, rng: np.random.Generator) -> None:
    ratio = rng.choice([rng.uniform(0.15, 0.9), rng.uniform(1.0, 2.0), 1.0])
    found = answer.number("overshoot", ratio)
    _, gaps = _release(1.0, 1.0 / (0.9 * ratio**2), 2.0 / 0.9, 0.9)
    right = max(0.0, -gaps.min())
    expect(abs(found - right) < 1e-3, f"it is {found:.5g}, the motion's {right:.5g}")


@holds("52.8.1", "the shortest time constant is two steps")
def _check_least(answer: Answer, rng: np.random.Generator) -> None:
    dt = rng.uniform(5e-4, 1e-2)
    near(answer.number("least_timeconst", dt) / dt, 2.0, "time constant over step")


def _sole(rng: np.random.Generator) -> tuple[float, float, float, np.ndarray]:
    half_x, half_y = rng.uniform(0.03, 0.2, 2)
    return half_x, half_y, rng.uniform(50, 800), rng.uniform(-0.6, 0.6, 2) * [half_x, half_y]


@holds("52.8.2", "the pressure adds up to the force, at its centre")
def _check_adds_up(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, force, cop = _sole(rng)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    total, moment = 0.0, np.zeros(2)
    for x, wx in zip(half_x * nodes, half_x * weights, strict=True):
        for y, wy in zip(half_y * nodes, half_y * weights, strict=True):
            part = answer.number("pressure", float(x), float(y), half_x, half_y, force, cop) * wx * wy
            total, moment = total + part, moment + part * np.array([x, y])
    near(total, force, "the pressure's sum")
    near(moment / force, cop, "the pressure's centre", 1e-5)


@holds("52.8.2", "the pressure changes linearly over the sole")
def _check_linear(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, force, cop = _sole(rng)
    (a, b), s = rng.uniform(-1, 1, (2, 2)) * [half_x, half_y], rng.uniform(0, 1)
    at = [
        answer.number("pressure", *map(float, p), half_x, half_y, force, cop) for p in (a, b, a + s * (b - a))
    ]
    near(at[2], at[0] + s * (at[1] - at[0]), "the pressure between two points")


@holds("52.8.2", "the whole sole bears where no corner's pressure would be negative", 40)
def _check_kern(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, force, cop = _sole(rng)
    mean = force / (4 * half_x * half_y)
    slopes = np.abs(cop) * force / (np.array([half_x**3 * half_y, half_y**3 * half_x]) * 4 / 3)
    least = mean - slopes[0] * half_x - slopes[1] * half_y
    found = answer.truth("whole_sole_loaded", half_x, half_y, cop)
    expect(found == (least >= 0), f"it says {found}; the least pressure would be {least:.4g} Pa")


@holds("52.8.2", "both splits over rigid corners give the force and its centre; they differ, none pulls")
def _check_splits(answer: Answer, rng: np.random.Generator) -> None:
    half_x, half_y, force, cop = _sole(rng)
    splits = answer.numbers((2, 4), "two_splits", half_x, half_y, force, cop)
    corners = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)]) * [half_x, half_y]
    expect(splits.min() > -1e-9 * force, f"a corner pulls: {short(splits)}")
    near(splits.sum(axis=1), [force, force], "their sums")
    near(splits @ corners / force, [cop, cop], "their centres", 1e-5)
    expect(np.abs(splits[0] - splits[1]).max() > 1e-3 * force, "they are the same")
