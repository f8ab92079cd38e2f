"""What is unlawful about the forces of one step, as a cost: NumPy, JAX and Torch by the same lines."""

from __future__ import annotations

from typing import Any, NamedTuple

from surefoot.records.audit.batch.array_functions import array_module, vector_length
from surefoot.records.audit.limits import LIMITS, AuditLimits

MOST = 1e15
"""Share of m g, and speed [m/s], beyond which nothing is told apart: their squares fit single precision."""


class StepCost(NamedTuple):
    """Unlawful force of a step in every environment (N,), in shares of m g.

    Attributes
    ----------
    pull
        With which the ground pulls.
    friction
        Tangential force beyond mu f_n.
    distance
        Force across a gap.
    work
        Friction along the slip, which drives: the part of it beyond what turns late.
    total
        All four.
    """

    pull: Any
    friction: Any
    distance: Any
    work: Any
    total: Any


def step_cost(
    forces: Any, gaps: Any, velocities: Any, mu: Any, weight: Any, limits: AuditLimits = LIMITS
) -> StepCost:
    """Return the unlawful force of a step, see `StepCost`.

    Pure functions of arrays of one framework: it may be jitted and differentiated. What the audit takes to
    be rounding costs nothing: pulls below `laws.pull`, friction within `laws.cone`, gaps up to
    `laws.penetration`, slip below `laws.sliding_speed`.

    Parameters
    ----------
    forces
        (N, feet, 3) in contact axes [N].
    gaps, velocities
        (N, feet) [m] and (N, feet, 3) [m/s]; None where not known: distance, or work, is zero.
    mu
        Friction: a number, (N, 1) or (N, feet).
    weight
        m g: a number or (N,) [N].

    Examples
    --------
    >>> import numpy as np
    >>> forces = np.array([[[0.0, 0.0, 100.0]], [[70.0, 0.0, 100.0]], [[0.0, 0.0, -5.0]]])
    >>> cost = step_cost(forces, None, None, 0.6, 100.0)
    >>> cost.friction.round(3).tolist(), cost.pull.tolist(), cost.total.round(3).tolist()
    ([0.0, 0.1, 0.0], [0.0, 0.0, 0.05], [0.0, 0.1, 0.05])
    """
    xp, laws = array_module(forces, gaps, velocities), limits.laws
    weights = weight[..., None] if getattr(weight, "ndim", 0) else weight
    share = xp.clip(forces / (weights[..., None] if getattr(weights, "ndim", 0) else weights), -MOST, MOST)
    normal = share[..., 2]
    tangential = vector_length(xp, share[..., 0], share[..., 1])
    loaded = normal > laws.loaded
    none = xp.zeros_like(normal)
    pull = xp.where(normal < -laws.pull, -normal, none)
    grip = mu * xp.clip(normal, 0.0, None)
    # force of hardly any load may have the noise of a loaded one
    allowed = xp.clip(grip, laws.least_friction * laws.loaded, None)
    beyond = xp.where(tangential > laws.cone * allowed, tangential - grip, none)
    beyond = xp.where(loaded | (tangential > laws.loaded), beyond, none)
    across = none
    if gaps is not None:
        size = vector_length(xp, tangential, normal)
        across = xp.where((gaps > laws.penetration) & (size > laws.loaded), size, none)
    drives = none
    if velocities is not None:
        v = xp.clip(velocities, -MOST, MOST)
        speed = vector_length(xp, v[..., 0], v[..., 1])
        slides = speed > laws.sliding_speed
        along = (share[..., 0] * v[..., 0] + share[..., 1] * v[..., 1]) / xp.where(slides, speed, none + 1.0)
        drives = xp.where(slides & loaded, xp.clip(along, 0.0, None), none)
    pulls, grips, leaps, work = (part.sum(-1) for part in (pull, beyond, across, drives))
    return StepCost(pulls, grips, leaps, work, pulls + grips + leaps + work)
