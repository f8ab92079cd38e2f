"""Measure in an engine how a mass rests, bounces and settles on one contact."""

from __future__ import annotations

import importlib
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.laws.soft.behaviour import MassOnContact, settling_time
from surefoot.errors import MissingExtra, SimulationError, check_name
from surefoot.spatial import GRAVITY

RUNNERS: dict[str, str] = {
    "mujoco": "surefoot.experiments.drops.mujoco_drop",
    "drake": "surefoot.experiments.drops.drake_drop",
    "drake-hunt-crossley": "surefoot.experiments.drops.drake_drop",
}
"""Engine -> module with `run` (see `surefoot.experiments.drops.mujoco_drop`), `present`, PACKAGE, EXTRA."""
NUDGE = 0.02
"""Share of the rest depth by which the mass is pressed down to see how it settles."""


@dataclass(frozen=True)
class SlideDrop:
    """What an engine is asked to run.

    Attributes
    ----------
    settings
        The engine's contact parameters.
    mass
        [kg].
    gravity
        [m/s²].
    gap, speed
        Where the mass starts above the ground, and its upward velocity [m], [m/s].
    dt
        The engine's step [s].
    steps
        How many.
    until
        "apart" ends the run when the mass has left the ground.
    """

    settings: dict[str, Any]
    mass: float
    gravity: float
    gap: float
    speed: float
    dt: float
    steps: int
    until: str = ""


def available_engines() -> list[str]:
    """Return the engines that can run here."""
    return [name for name, home in RUNNERS.items() if importlib.import_module(home).present()]


def measure(
    engine: str,
    settings: dict[str, Any],
    expected: MassOnContact,
    mass: float,
    *,
    speed: float = 1.0,
    gravity: float = GRAVITY,
    dt: float = 1e-5,
) -> MassOnContact:
    """Run an engine and return how the mass rests, bounces and settles in it.

    Parameters
    ----------
    engine
        One of `RUNNERS`.
    settings
        The engine's contact parameters, `Translation.parameters`.
    expected
        What should come out: it decides how long the runs take, not what they say.
    mass
        [kg].
    speed
        Impact speed of the bounce [m/s].
    gravity
        [m/s²].
    dt
        The engine's step [s].

    Raises
    ------
    ProblemError
        For an engine that cannot be run.
    MissingExtra
        If it is not installed.
    """
    check_name("engine that can be run", engine, RUNNERS)
    module = importlib.import_module(RUNNERS[engine])
    if not module.present():
        raise MissingExtra(module.PACKAGE, module.EXTRA)

    def run(gap: float, velocity: float, seconds: float, until: str = "") -> tuple[FloatArray, FloatArray]:
        steps = max(4, math.ceil(seconds / dt))
        gaps, speeds = module.run(SlideDrop(settings, mass, gravity, gap, velocity, dt, steps, until))
        return np.asarray(gaps), np.asarray(speeds)

    settle = expected.settling_time if math.isfinite(expected.settling_time) else 20.0 / expected.frequency
    rest, _ = run(-expected.rest_depth, 0.0, 6.0 * settle)
    depth = -float(rest[-1])
    pressed, _ = run(-(1.0 + NUDGE) * depth, 0.0, settle)
    frequency, ratio = _modes(pressed + depth, dt)
    settling = settling_time(frequency, ratio)
    gaps, speeds = run(0.0, -speed, 300.0 * max(1.0 / expected.frequency, depth / speed), "apart")
    left = gaps[-1] > 0.0 and speeds[-1] > 0.0
    return MassOnContact(depth, float(speeds[-1]) / speed if left else 0.0, frequency, ratio, settling)


def _modes(deviation: FloatArray, dt: float) -> tuple[float, float]:
    """Return undamped frequency and damping ratio of x'' + 2 ζ ω x' + ω² x = 0 that fits a record best.

    The record is thinned so that one sample is a fair part of a period, else rounding hides the curvature.
    """
    count = deviation.size
    stride = max(1, count // 400)
    x = deviation[::stride]
    past = np.column_stack([x[1:-1], x[:-2]])
    a, b = np.linalg.lstsq(past, x[2:], rcond=None)[0]
    roots = np.log(np.roots([1.0, -a, -b]).astype(complex)) / (stride * dt)
    product = complex(roots[0] * roots[1])
    if not (np.isfinite(roots).all() and product.real > 0.0):
        raise SimulationError("settling of a mass", float(count * dt), dt, "slide", float(np.abs(x).max()))
    frequency = math.sqrt(product.real)
    return frequency, float(-(roots[0] + roots[1]).real / (2.0 * frequency))
