"""How engines make one friction coefficient of two surfaces' coefficients."""

from __future__ import annotations

import math
from collections.abc import Callable

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name

_RULES: dict[str, tuple[Callable[[float, float], float], str]] = {
    "mujoco": (max, "the larger one; the geom of higher priority decides alone; a <pair> sets its own"),
    "drake": (
        lambda a, b: 2.0 * a * b / (a + b) if a + b else 0.0, "2 a b / (a + b), static and dynamic alike"
    ),
    "physx": (lambda a, b: 0.5 * (a + b), "average by default; see physx-min, -multiply, -max"),
    "physx-min": (
        min, "the smaller one; of two materials' modes the later of average < min < multiply < max holds"
    ),
    "physx-multiply": (lambda a, b: a * b, "the product"),
    "physx-max": (max, "the larger one"),
    "bullet": (
        lambda a, b: min(a * b, 10.0), "the product, at most 10 (a callback may replace it)"
    ),
    "ode": (
        min, "none: the caller sets mu of each contact joint; many wrappers take the smaller (Gazebo Classic)"
    ),
    "surefoot": (lambda a, b: b, "the contact carries one coefficient, that of the pair, as tables give it"),
}  # fmt: skip
"""Engine -> how the robot's and the ground's coefficient become one, and in words what overrides that."""


def combination_rules() -> dict[str, str]:
    """Return every engine's rule in words."""
    return {name: words for name, (_, words) in _RULES.items()}


def combine_friction(engine: str, first: float, second: float) -> float:
    """Return the friction coefficient [-] that an engine gives to a contact of two surfaces.

    Parameters
    ----------
    engine
        See `combination_rules`.
    first, second
        Coefficients of the robot's and of the ground's surface [-].

    Raises
    ------
    ProblemError
        For an unknown engine (the message lists the names) or a negative coefficient.

    Examples
    --------
    >>> [round(combine_friction(e, 0.5, 1.0), 3) for e in ("mujoco", "drake", "physx", "bullet")]
    [1.0, 0.667, 0.75, 0.5]
    """
    check_name("engine", engine, _RULES)
    a, b = (real_number("friction", mu, low=0.0) for mu in (first, second))
    if math.isinf(a) or math.isinf(b):
        raise ProblemError("friction must be finite")
    return _RULES[engine][0](a, b)
