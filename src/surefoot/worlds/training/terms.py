"""Terms of a reward about contact, each with the failure that it prevents: NumPy, JAX and Torch alike.

Arrays are (N, feet, ...) of N environments, in contact axes (the normal last) unless said otherwise; every
term is (N,) and may be jitted and differentiated.
"""

from __future__ import annotations

from itertools import permutations
from typing import Any

from surefoot.base.loaded import ACTS
from surefoot.base.spatial import GRAVITY
from surefoot.records import array_module, step_cost, vector_length

LOADED = ACTS
"""Normal force from which a foot counts as loaded [m g], as for the audit."""
NEAR = 0.02
"""Gap below which a foot is about to touch, and least height over the feet [m]: a judgement."""
TOUCHES = 1e-3
"""Gap at the end of a step below which a foot touches [m]: `laws.penetration` of the audit."""


def slip_under_load(forces: Any, velocities: Any, weight: Any) -> Any:
    """Return how fast the feet slide, each weighed by its share of the weight [m/s].

    Prevents skating. A term that asks whether a foot is loaded is paid by feet kept just below its threshold;
    here half of the load is half of the cost.

    Parameters
    ----------
    forces, velocities
        (N, feet, 3) [N] and [m/s].
    weight
        m g: a number or (N,) [N].

    Examples
    --------
    >>> import numpy as np
    >>> f = np.array([[[0.0, 0.0, 75.0], [0.0, 0.0, 25.0]]])
    >>> v = np.array([[[0.5, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    >>> slip_under_load(f, v, 100.0).tolist()
    [0.625]
    """
    xp = array_module(forces, velocities)
    return (_shares(xp, forces, weight) * vector_length(xp, velocities[..., 0], velocities[..., 1])).sum(-1)


def cone_use(forces: Any, mu: Any, weight: Any) -> Any:
    """Return the highest share of its friction that a loaded foot uses [-]; one is the cone, none loaded 0.

    Prevents gaits that hold on the simulator's friction alone: a margin below one is what other ground takes.

    Parameters
    ----------
    forces
        (N, feet, 3) [N].
    mu
        Friction, above zero: a number, (N, 1) or (N, feet).
    weight
        m g: a number or (N,) [N].

    Examples
    --------
    >>> import numpy as np
    >>> cone_use(np.array([[[30.0, 0.0, 100.0], [9.0, 0.0, 0.1]]]), 0.6, 100.0).tolist()
    [0.5]
    """
    xp = array_module(forces)
    loaded = _shares(xp, forces, weight) > LOADED
    normal = xp.where(loaded, forces[..., 2], xp.ones_like(forces[..., 2]))
    use = vector_length(xp, forces[..., 0], forces[..., 1]) / (mu * normal)
    return _largest(xp, xp.where(loaded, use, xp.zeros_like(use)))


def foot_impact(gaps: Any, velocities: Any) -> Any:
    """Return the highest speed at which a foot that is about to touch approaches the ground [m/s].

    Prevents stamping. It does not look at forces, whose peak is the simulator's softness and step, not the
    robot's.

    Parameters
    ----------
    gaps, velocities
        (N, feet) [m] and (N, feet, 3) [m/s].

    Examples
    --------
    >>> import numpy as np
    >>> v = np.array([[[0.0, 0.0, -0.8], [0.0, 0.0, -2.0]]])
    >>> foot_impact(np.array([[0.01, 0.2]]), v).tolist()
    [0.8]
    """
    xp = array_module(gaps, velocities)
    near = (gaps > 0.0) & (gaps < NEAR)
    speed = xp.where(near, xp.clip(-velocities[..., 2], 0.0, None), xp.zeros_like(gaps))
    return _largest(xp, speed)


def unlawful_force(forces: Any, gaps: Any, velocities: Any, mu: Any, weight: Any) -> Any:
    """Return the force that no ground gives, in shares of m g [-].

    Prevents policies that live on their simulator: pulls, friction beyond the cone, forces across a gap,
    friction that drives; the ``total`` of what `surefoot.StepLaws` returns.

    Parameters
    ----------
    forces, gaps, velocities
        (N, feet, 3) [N]; (N, feet) [m] and (N, feet, 3) [m/s], None where not known.
    mu
        Friction: a number, (N, 1) or (N, feet).
    weight
        m g: a number or (N,) [N].

    Examples
    --------
    >>> import numpy as np
    >>> unlawful_force(np.array([[[70.0, 0.0, 100.0]]]), None, None, 0.6, 100.0).round(3).tolist()
    [0.1]
    """
    return step_cost(forces, gaps, velocities, mu, weight).total


def support_margin(positions: Any, forces: Any, com: Any, weight: Any) -> Any:
    """Return how far inside the loaded feet's polygon the centre of mass stands, on level ground [m].

    Negative outside; minus the distance from one foot or the line of two; minus infinity where none is
    loaded. Prevents stands that only a falling robot's momentum carries. It is the polygon of quasi-static
    balance: a trot crosses it, so weigh it by how slowly the robot is asked to go.

    Parameters
    ----------
    positions
        (N, feet, 2 or 3) contact points, world axes [m].
    forces
        (N, feet, 3) [N].
    com
        (N, 2 or 3) centre of mass, world axes [m].
    weight
        m g: a number or (N,) [N].

    Examples
    --------
    >>> import numpy as np
    >>> feet = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    >>> forces = np.zeros((1, 4, 3)) + [0.0, 0.0, 25.0]
    >>> support_margin(feet, forces, np.array([[0.3, 0.5]]), 100.0).round(3).tolist()
    [0.3]
    """
    xp = array_module(positions, forces, com)
    loaded = _shares(xp, forces, weight) > LOADED
    x, y = (positions[..., k] - com[..., None, k] for k in (0, 1))
    return _hull_margin(xp, x, y, loaded)


def step_certificate(
    positions: Any, gaps: Any, velocities: Any, com: Any, acceleration: Any, mu: Any, dt: float
) -> Any:
    """Return how much more push the coming step's acceleration leaves room for, in shares of m g [-].

    Negative: no lawful forces of the feet that touch by the end of the step give that acceleration to the
    centre of mass on level ground while its angular momentum stays; by so much force is lacking. What binds
    is the least of the normal force, the friction cone, and tipping over the feet's polygon. Prevents
    commands that only soft or sticky ground obeys, a step before they are obeyed, by no force of a simulator.

    Parameters
    ----------
    positions
        (N, feet, 3) contact points, world axes [m].
    gaps, velocities
        (N, feet) [m] and (N, feet, 3) in contact axes [m/s]: feet touch whose gap closes within the step.
    com, acceleration
        (N, 3) centre of mass [m], above its feet, and what the step is to give it [m/s²], world axes.
    mu
        Friction: a number or (N,).
    dt
        Length of the step [s].

    Examples
    --------
    >>> import numpy as np
    >>> feet = np.array([[[-0.2, -0.2, 0.0], [0.2, -0.2, 0.0], [0.2, 0.2, 0.0], [-0.2, 0.2, 0.0]]])
    >>> still, com = np.zeros((1, 4, 3)), np.array([[0.0, 0.0, 0.4]])
    >>> for a in (0.0, 2.0, 7.0):
    ...     push = np.array([[a, 0.0, 0.0]])
    ...     print(step_certificate(feet, np.zeros((1, 4)), still, com, push, 0.6, 0.02).round(3).tolist())
    [0.5]
    [0.296]
    [-0.214]
    """
    xp = array_module(positions, gaps, com, acceleration)
    touching = gaps + dt * velocities[..., 2] < TOUCHES
    x, y, z = (acceleration[..., k] / GRAVITY for k in range(3))
    normal, tangential = z + 1.0, vector_length(xp, x, y)
    # the feet as pushes that tip over them: (place - com) n / h, and what the acceleration takes of them
    height = com[..., None, 2] - positions[..., 2]
    scale = normal[..., None] / xp.where(height > NEAR, height, xp.zeros_like(height) + NEAR)
    places = [(positions[..., k] - com[..., None, k]) * scale for k in (0, 1)]
    tips = _hull_margin(xp, places[0] + x[..., None], places[1] + y[..., None], touching)
    least = xp.where(normal < mu * normal - tangential, normal, mu * normal - tangential)
    least = xp.where(tips < least, tips, least)
    flight = xp.zeros_like(normal) - vector_length(xp, tangential, normal)
    return xp.where(touching.any(-1), least, flight)


def _hull_margin(xp: Any, x: Any, y: Any, loaded: Any) -> Any:
    """Return how far inside the hull of loaded points (N, feet) the origin lies, see `support_margin`."""
    # the distance inside a convex hull is the least value of its support function; where that is least is
    # across an edge, or away from a corner
    found = [_support(xp, x, y, loaded, -x[..., k], -y[..., k], loaded[..., k]) for k in range(x.shape[-1])]
    for i, j in permutations(range(x.shape[-1]), 2):
        both = loaded[..., i] & loaded[..., j]
        across = (y[..., j] - y[..., i], x[..., i] - x[..., j])
        found.append(_support(xp, x, y, loaded, *across, both))
    least = found[0]
    for one in found[1:]:
        least = xp.where(one < least, one, least)
    least = xp.where(least < xp.inf, least, xp.zeros_like(least))  # it stands on its only foot
    return xp.where(loaded.any(-1), least, xp.zeros_like(least) - xp.inf)


def _support(xp: Any, x: Any, y: Any, loaded: Any, u: Any, v: Any, given: Any) -> Any:
    """Return the support function (N,) of loaded points (N, feet) in a direction; infinite if not given."""
    size = vector_length(xp, u, v)
    known = given & (size > 0.0)
    scale = xp.where(known, size, xp.ones_like(size))
    along = (x * (u / scale)[..., None]) + (y * (v / scale)[..., None])
    none = xp.zeros_like(along)
    highest = _largest(xp, xp.where(loaded, along, none - xp.inf))
    return xp.where(known, highest, xp.zeros_like(size) + xp.inf)


def _shares(xp: Any, forces: Any, weight: Any) -> Any:
    """Return the shares of the weight that the feet carry, no less than zero: (N, feet)."""
    one = weight[..., None] if getattr(weight, "ndim", 0) else weight
    return xp.clip(forces[..., 2] / one, 0.0, None)


def _largest(xp: Any, values: Any) -> Any:
    """Return the largest of the last axis."""
    return xp.amax(values, -1)
