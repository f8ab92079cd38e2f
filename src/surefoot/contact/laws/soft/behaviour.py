"""What a mass does on a soft contact, whatever the law, and how long an explicit step may take."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.spatial import GRAVITY
from surefoot.contact.laws.soft.soft_law import SoftLaw

SETTLED = 0.02
"""Share of itself to which an oscillation has shrunk when it counts as settled."""
LONGEST = 300.0
"""Time that an impact is followed, in units of the contact's own; who has not left by then stays."""


@dataclass(frozen=True)
class MassOnContact:
    """A mass on a contact under its own weight.

    Attributes
    ----------
    rest_depth
        Overlap at rest [m].
    restitution
        Speed after over speed before an impact [-], weight included; 0 where the mass does not leave again.
    frequency
        Undamped frequency of small motions about rest [rad/s].
    ratio
        Their damping ratio.
    settling_time
        How long they take to shrink to 2 % [s].
    """

    rest_depth: float
    restitution: float
    frequency: float
    ratio: float
    settling_time: float


def behaviour(law: SoftLaw, mass: float, speed: float = 1.0, gravity: float = GRAVITY) -> MassOnContact:
    """Return how a mass rests, bounces and settles on a contact.

    Parameters
    ----------
    law
        The contact.
    mass
        [kg].
    speed
        Impact speed for the restitution [m/s].
    gravity
        [m/s²].

    Examples
    --------
    >>> from surefoot.contact.laws.soft.spring_damper import SpringDamper
    >>> round(behaviour(SpringDamper(1e4, 20.0), mass=1.0).restitution, 3)
    0.706
    """
    heavy = real_number("mass", mass, low=1e-12, high=1e12)
    weight = heavy * real_number("gravity", gravity, low=1e-12, high=1e6)
    depth = law.rest_depth(weight)
    _, by_depth, by_rate = law.pressed(np.array(depth), np.array(0.0))
    stiff, damped = float(by_depth), float(by_rate)
    frequency = math.sqrt(stiff / heavy)
    ratio = damped / (2.0 * heavy * frequency)
    bounce = rebound(law, heavy, speed, gravity)
    return MassOnContact(depth, bounce, frequency, ratio, settling_time(frequency, ratio))


def settling_time(frequency: float, ratio: float, share: float = SETTLED) -> float:
    """Return how long a damped motion takes to shrink to a share of itself [s]; infinite without damping.

    The slower of the two decay rates counts.

    >>> round(settling_time(frequency=100.0, ratio=0.1), 4)
    0.3912
    """
    slow = ratio if ratio <= 1.0 else 1.0 / (ratio + math.sqrt(ratio**2 - 1.0))
    return math.inf if slow <= 0.0 else -math.log(share) / (slow * frequency)


def stopping_depth(law: SoftLaw, mass: float, speed: float, gravity: float = GRAVITY) -> float:
    """Return how deep a mass [kg] of a speed [m/s] goes where the law's damping does nothing [m].

    There the law's work is the mass's energy, the work of its weight included (gravity [m/s²]): for a spring
    and no speed twice the depth at rest.

    >>> from surefoot.contact.laws.soft.spring_damper import SpringDamper
    >>> round(stopping_depth(SpringDamper(1e4, 20.0), 1.0, 1.0), 5)
    0.01103
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq

    def missing(depth: float) -> float:
        work = quad(lambda x: float(law.pressed(np.array(x), np.array(0.0))[0]), 0.0, depth)[0]
        return float(work) - mass * (0.5 * speed**2 + gravity * depth)

    high = law.rest_depth(mass * gravity)
    while missing(high) < 0.0:
        high *= 2.0
    return float(brentq(missing, 0.5 * high, high, xtol=1e-9))


def rebound(law: SoftLaw, mass: float, speed: float, gravity: float = GRAVITY) -> float:
    """Return the speed at which a mass leaves the contact over the speed at which it came; 0 if it stays.

    A ratio [-] for a mass [kg], a speed [m/s] and gravity [m/s²]. The impact is integrated (LSODA, 1e-10),
    weight included.
    """
    from scipy.integrate import solve_ivp

    fast = real_number("speed", speed, low=1e-9, high=1e9)

    def motion(_: float, state: FloatArray) -> list[float]:
        force = float(law.pressed(np.maximum(-state[0], 0.0), -state[1])[0])
        return [float(state[1]), max(force, 0.0) / mass - gravity]

    def apart(_: float, state: FloatArray) -> float:
        return float(state[0])

    def turning(_: float, state: FloatArray) -> float:
        return float(state[1])

    apart.terminal, apart.direction = True, 1.0  # type: ignore[attr-defined]
    turning.terminal, turning.direction = 2, -1.0  # type: ignore[attr-defined]
    depth = law.rest_depth(mass * gravity)
    # times that the contact has by itself: that of its stiffness under the weight, that of crossing its depth
    scale = max(math.sqrt(depth / gravity), depth / fast)
    found = solve_ivp(
        motion,
        (0.0, LONGEST * scale),
        [0.0, -fast],
        method="LSODA",
        events=[apart, turning],
        rtol=1e-10,
        atol=[1e-12 * max(depth, fast * 1e-6), 1e-12 * fast],
        first_step=1e-6 * scale,
    )
    assert found.t_events is not None and found.y_events is not None  # noqa: PT018 - asked for
    left = found.t_events[0].size > 0 and found.t_events[0][-1] > 0.0
    return float(found.y_events[0][-1][1]) / fast if left else 0.0


def stable_step(law: SoftLaw, mass: float, depth: float) -> float:
    """Return the longest stable step [s] of an explicit integrator for a mass on a contact.

    2 (sqrt(1 + ζ²) - ζ) / ω, which is 2 / ω without damping: for v⁺ = v + dt f(x, v) / m, x⁺ = x + dt v⁺
    linearised at an overlap, the point where an eigenvalue reaches -1.

    Parameters
    ----------
    law
        The contact.
    mass
        Effective mass, 1 / G_nn [kg].
    depth
        Overlap [m]; the linear law does not ask, others grow stiffer.

    Examples
    --------
    >>> from surefoot.contact.laws.soft.spring_damper import SpringDamper
    >>> stable_step(SpringDamper(1e4), mass=1.0, depth=0.0)
    0.02
    """
    heavy = real_number("mass", mass, low=1e-300)
    deep = real_number("depth", depth, low=0.0, high=1e6)
    _, by_depth, by_rate = law.pressed(np.array(deep), np.array(0.0))
    rate = float(by_rate) / heavy
    total = rate + math.sqrt(rate * rate + 4.0 * float(by_depth) / heavy)
    return 4.0 / total if total > 0.0 else math.inf
