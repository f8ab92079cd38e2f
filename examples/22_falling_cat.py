"""The falling cat: two halves that twist and stretch turn over by 180° with no angular momentum at all."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from surefoot.app.cli.output import new_run_folder
from surefoot.app.viz.style import draw_panels
from surefoot.mechanics.dynamics.airborne_motion import fly, follow_shape
from surefoot.worlds.rigid.bodies import falling_cat

PERIOD, HALF_MASS, HALF_INERTIA, LEG_MASS = 0.4, 1.0, 0.003, 0.4  # [s], [kg], [kg m²] about the spine, [kg]
REACH = (0.03, 0.20)  # legs' distance from the spine, pulled in and stretched [m]
TWIST_LIMIT, HARMONICS = np.radians(150.0), 3


def cycle(x: np.ndarray, t: np.ndarray | float) -> np.ndarray:
    """Twist of the rear against the front, and reach of front and rear legs, at times t: (3, ...)."""
    angles = np.multiply.outer(np.arange(1, HARMONICS + 1), 2 * np.pi * np.asarray(t) / PERIOD)
    twist, front, rear = (np.tensordot(c, np.sin(angles), 1) for c in x.reshape(3, 2, HARMONICS)[:, 0])
    for series, c in zip((twist, front, rear), x.reshape(3, 2, HARMONICS)[:, 1], strict=True):
        series += np.tensordot(c, np.cos(angles) - 1.0, 1)  # every cycle starts and ends at the same shape
    middle, half = 0.5 * (REACH[0] + REACH[1]), 0.5 * (REACH[1] - REACH[0])
    return np.array([twist, middle + half * np.tanh(front), middle + half * np.tanh(rear)])


def turned(x: np.ndarray, n: int = 160) -> float:
    """Angle that one cycle leaves the front half turned by: no momentum, so I_f φ' + I_r (φ + twist)' = 0."""
    t = np.arange(n) * PERIOD / n
    twist, front, rear = cycle(x, t)
    inertia_front, inertia_rear = (HALF_INERTIA + 2 * LEG_MASS * (r**2 + 4e-5) for r in (front, rear))
    rate = np.fft.ifft(2j * np.pi * np.fft.fftfreq(n, PERIOD / n) * np.fft.fft(twist)).real
    return float(-np.mean(inertia_rear / (inertia_front + inertia_rear) * rate) * PERIOD)


def find_cycle() -> np.ndarray:
    """The cycle of least motion that turns the cat over and never twists the spine beyond its limit."""
    t = np.arange(160) * PERIOD / 160
    start = np.zeros((3, 2, HARMONICS))
    start[:, :, 0] = [[2.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
    limits = (
        {"type": "eq", "fun": lambda x: turned(x) - np.pi},
        {"type": "ineq", "fun": lambda x: TWIST_LIMIT - np.abs(cycle(x, t)[0])},
    )

    def effort(x: np.ndarray) -> float:
        return float(np.sum(np.diff(cycle(x, t) / [[1.0], [0.1], [0.1]], axis=1) ** 2))

    found = minimize(effort, start.ravel(), constraints=limits, method="SLSQP", options={"maxiter": 300})
    assert found.success, found.message
    return found.x


def slope(f: Callable[[float], np.ndarray], t: float, h: float) -> np.ndarray:
    return (8 * (f(t + h) - f(t - h)) - f(t + 2 * h) + f(t - 2 * h)) / (12 * h)


def main(parent: Path = Path("runs")) -> dict[str, float]:
    robot, x = falling_cat(HALF_MASS, HALF_INERTIA, LEG_MASS), find_cycle()

    def joints(t: float) -> np.ndarray:
        return cycle(x, t)[[0, 1, 1, 2, 2]]

    def rates(t: float) -> np.ndarray:
        return slope(joints, t, 2e-5)

    plan = follow_shape(robot, robot.nominal, lambda t: (joints(t), rates(t)), PERIOD)
    real = fly(robot, plan.q[0], plan.v[0], PERIOD, joint_acceleration=lambda t, q, v: slope(rates, t, 1e-4))
    roll = [np.degrees(np.unwrap(2 * np.arctan2(f.q[:, 3], f.q[:, 6]))) for f in (plan, real)]
    facts = {
        "turn_optimised": float(np.degrees(turned(x))),
        "turn_by_momentum": roll[0][-1] - roll[0][0],
        "turn_by_forces": roll[1][-1] - roll[1][0],
        "largest_momentum": float(np.abs(real.momentum[:, 3:]).max()),
        "largest_twist": float(np.degrees(np.abs(real.q[:, 7]).max())),
    }
    panels = {
        "turn [deg]": (np.column_stack([roll[1], roll[1] + np.degrees(real.q[:, 7])]), ("front", "rear")),
        "legs [m]": (real.q[:, [8, 10]], ("front", "rear")),
        "twist [deg]": (np.degrees(real.q[:, 7]), ("spine",)),
    }
    title = "A falling cat turns over: zero angular momentum throughout"
    path = draw_panels(new_run_folder(parent, "cat") / "cat.png", real.time, panels, title)
    print("\n".join(f"{name:18s} {value:.6g}" for name, value in facts.items()), f"\npicture: {path}")
    return facts


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("runs"))
