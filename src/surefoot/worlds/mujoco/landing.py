"""How deep a soft contact of MuJoCo rests, and lands: its law in compiled steps; see `record_softness`."""

from __future__ import annotations

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import inline_kernel, kernel

MOST_STEPS = 20_000
"""Of a landing."""
HALVINGS = 60
"""Of the interval in which a contact rests."""
STIFFNESS, DAMPING, LOW, HIGH, WIDTH, MIDDLE, POWER, GUESS, FACTOR = range(9)
"""Numbers of a contact: k / d, b, those of d(r) as MuJoCo takes them, Â, and c of its regularisation."""


@inline_kernel
def _impedance(law: FloatArray, depth: float) -> float:
    """Return d(r), see `surefoot.contact.laws.soft.mujoco.MujocoLaw.impedance`."""
    low, high, middle, power = law[LOW], law[HIGH], law[MIDDLE], law[POWER]
    if low == high or law[WIDTH] <= 1e-15:
        return float(0.5 * (low + high))
    x = min(max(abs(depth) / law[WIDTH], 0.0), 1.0)
    if x <= middle:
        share = middle * (x / middle) ** power
    else:
        share = 1.0 - (1.0 - middle) * ((1.0 - x) / (1.0 - middle)) ** power
    return float(low + share * (high - low))


@kernel
def impedance_at(law: FloatArray, depth: float) -> float:
    """Return d(r) of a contact (9,) at a depth [m]."""
    return _impedance(law, depth)


@kernel
def rest_depth(law: FloatArray, load: float) -> float:
    """Return the depth at rest [m] of a contact (9,) under a load [N]: the root of c (1 - d) Â L = k d² r."""
    stiff, low, high = law[STIFFNESS], 0.0, 1.0
    if stiff == 0.0:
        return 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        d = _impedance(law, middle)
        R = (1.0 - d) / d * law[GUESS]
        if law[FACTOR] * R * load > stiff * d * middle:
            low = middle
        else:
            high = middle
    return high


@kernel
def landing_depth(
    law: FloatArray, step: float, inverse_mass: float, load: float, depth: float, rate: float
) -> float:
    """Return how deep a contact (9,) has come where it turns back [m].

    Parameters
    ----------
    law
        See `STIFFNESS` and those after it.
    step
        Of time [s].
    inverse_mass, load
        A [1/kg], and what presses [N].
    depth, rate
        At the start [m], [m/s].
    """
    A, pull = inverse_mass, inverse_mass * load
    for _ in range(MOST_STEPS):
        d = _impedance(law, depth)
        R = (1.0 - d) / d * law[GUESS]
        # r'' = A L - A f with f from the law: symplectic Euler, as MuJoCo steps, velocity first.
        share = A / (A + law[FACTOR] * R)
        rate += step * (pull - share * (law[DAMPING] * rate + law[STIFFNESS] * d * depth + pull))
        if not rate > 0.0:
            break
        depth += step * rate
    return depth


@kernel
def recoil_rate(law: FloatArray, step: float, depth: float) -> float:
    """Return how fast a contact (9,) at rest in a depth [m] comes out under no load, over it [1/s]."""
    r, speed, before = depth, 0.0, -1.0
    while r > 0.0 and speed > before:
        before = speed
        speed += step * (law[STIFFNESS] * _impedance(law, r) * r - law[DAMPING] * speed)
        r -= step * speed
    return max(speed, before) / depth
