"""The parameters of a force distribution, checked: friction, bounds, weights, torque limits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, check_order, finite_array, per_contact, real_array
from surefoot.base.errors import ProblemError


def contact_count(parameters: Sequence[FloatArray]) -> int | None:
    """Return how many contacts the parameters, (n,) or numbers, are for; None if all of them are numbers."""
    sizes = {len(a) for a in parameters if a.ndim > 0}
    if len(sizes) > 1:
        raise ProblemError(
            "mu, normal_min, normal_max and force_weight must agree on the number of contacts, "
            f"got {sorted(sizes)}"
        )
    return sizes.pop() if sizes else None


def wrench_metric(weights: ArrayLike) -> FloatArray:
    """Return the weights of [force; moment] as a (6,) array [-, 1/m²]."""
    given = finite_array("wrench_weights", weights)
    if given.shape not in ((), (6,)):
        raise ProblemError(f"wrench_weights must be a number or have shape (6,), got {given.shape}")
    if (given < 0.0).any():
        raise ProblemError(f"wrench_weights must be >= 0, got {given.min():g}")
    return np.broadcast_to(given, (6,))


def torque_limits(limit: ArrayLike) -> FloatArray:
    """Return the (joints,) largest joint torques [N·m]; a limit may be infinite."""
    limits = real_array("torque_limit", limit, (None,))
    if not (limits >= 0.0).all():
        raise ProblemError(f"torque_limit must be >= 0, got {limits.min():g}")
    return limits


def friction(mu: ArrayLike, count: int) -> FloatArray:
    """Return the friction coefficients [-] as a (n,) array."""
    coefficients = per_contact("mu", mu, count)
    if np.isinf(coefficients).any():
        raise ProblemError("mu must be finite, got inf")
    return coefficients


def normal_bounds(low: ArrayLike, high: ArrayLike, count: int) -> tuple[FloatArray, FloatArray]:
    """Return the bounds on the normal forces [N] as (n,) arrays, checked."""
    lower, upper = per_contact("normal_min", low, count), per_contact("normal_max", high, count)
    check_order(lower, upper)
    return lower, upper


def force_weights(weight: ArrayLike, count: int) -> FloatArray:
    """Return the (n, 2) tangential and normal force weights [-]."""
    weights = real_array("force_weight", weight)
    if weights.ndim < 2:
        weights = np.repeat(per_contact("force_weight", weights, count)[:, None], 2, axis=1)
    if weights.shape != (count, 2):
        raise ProblemError(
            f"force_weight must be a number or have shape ({count},) or ({count}, 2), got {weights.shape}"
        )
    if not ((weights > 0.0) & np.isfinite(weights)).all():
        raise ProblemError(f"force_weight must be positive and finite, got {weights.min():g}")
    return weights
