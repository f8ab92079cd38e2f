"""Measure in an engine how a mass rests, bounces and settles on one contact."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import SimulationError, check_name
from surefoot.base.spatial import GRAVITY
from surefoot.contact import MassOnContact, settling_time
from surefoot.worlds.drake.drake_world import contact_words
from surefoot.worlds.experiments.engines.runners import elsewhere, mujoco

ENGINES = ("mujoco", "drake", "drake-hunt-crossley")
"""Engines that can be run."""
RADIUS = 1.0
"""Of the ball that falls [m]; nothing turns it."""
SPEED = 1.0
"""Impact speed of the bounce [m/s]."""
NUDGE = 0.02
"""Share of the rest depth by which the mass is pressed down to see how it settles."""


def measure(
    engine: str,
    settings: dict[str, Any],
    expected: MassOnContact,
    mass: float,
    *,
    dt: float = 1e-5,
) -> MassOnContact:
    """Run an engine and return how the mass rests, bounces and settles in it.

    Parameters
    ----------
    engine
        One of `ENGINES`.
    settings
        The engine's contact parameters, `Translation.parameters`.
    expected
        What should come out: it decides how long the runs take, not what they say.
    mass
        [kg].
    dt
        The engine's step [s].

    Raises
    ------
    ProblemError
        For an engine that cannot be run.
    MissingExtra
        If it is not installed.
    """
    check_name("engine that can be run", engine, ENGINES)
    world = engine.partition("-")[0]
    words = contact_words(settings) if world == "drake" else settings
    if world == "drake":
        words["near_rigid"] = 0.0 if words["approximation"] == "sap" else None

    def run(gap: float, velocity: float, seconds: float, until: float = np.inf) -> tuple[Any, Any]:
        body = {
            "size": [RADIUS],
            "mass": mass,
            "place": [0.0, 0.0, RADIUS + gap],
            "velocity": [0.0, 0.0, velocity],
        }
        scene = {
            "bodies": [body], "gravity": [0.0, 0.0, -GRAVITY], "mu": 0.0, "dt": dt, "contact": words,
            "steps": max(4, math.ceil(seconds / dt)), "until": until,
        }  # fmt: skip
        path, _ = mujoco(scene) if world == "mujoco" else elsewhere(scene, world)
        heights = np.array(path)[:, 0, 2]
        return heights - RADIUS, np.diff(heights, prepend=heights[0] - dt * velocity) / dt

    settle = expected.settling_time if math.isfinite(expected.settling_time) else 20.0 / expected.frequency
    rest, _ = run(-expected.rest_depth, 0.0, 6.0 * settle)
    depth = -float(rest[-1])
    pressed, _ = run(-(1.0 + NUDGE) * depth, 0.0, settle)
    frequency, ratio = _modes(pressed + depth, dt)
    settling = settling_time(frequency, ratio)
    gaps, speeds = run(0.0, -SPEED, 300.0 * max(1.0 / expected.frequency, depth / SPEED), RADIUS)
    left = gaps[-1] > 0.0 and speeds[-1] > 0.0
    return MassOnContact(depth, float(speeds[-1]) / SPEED if left else 0.0, frequency, ratio, settling)


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
