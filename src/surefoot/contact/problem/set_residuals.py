"""Every contact law as a number for contacts of any kind: what `residuals` does for points, from `sets`.

Plain NumPy, contact by contact, with the operations of `sets.ContactKind`; no solver shares them. Errors are
velocities in the metric of each contact (moments over its lengths), against scales defined as in `scales`.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact.problem.problem import ContactProblem
from surefoot.contact.problem.set_scales import block_sizes
from surefoot.contact.sets.contact import ContactKind

DOUBT = 4.0 * 2.220446049250313e-16
"""Times Σ_j ||G_kj|| ||λ_j||: what double precision leaves open of the velocity of contact k."""
WEIGHTLESS = 16.0
"""Where G_kk = 0, the weight in units of s_k / ||λ_k||: large, so close to the normal cone's distance."""
VANISHING = 1e-300
"""Forces below this [N] have no digits that could be judged."""
Numbers = tuple[float, float, float, float, float, float, float]
"""The fields of `residuals.Residuals`."""


def set_certificate(problem: ContactProblem, forces: FloatArray) -> tuple[FloatArray, Numbers]:
    """Return the velocities of forces, in their shape, (n, d) or (m,), and the fields of `Residuals`."""
    s, scales = problem.contact_set, problem.scales
    flat = np.ravel(forces)
    with np.errstate(all="ignore"):  # said by the numbers
        velocities = problem.G @ flat + problem.g
        if not (np.isfinite(flat).all() and np.isfinite(velocities).all()):
            return velocities.reshape(s.shape), (math.nan,) * 7
        rows = [
            _measure(c, f, u, w, speed, energy, problem.law.shift_at(c.coefficient))
            for c, f, u, w, speed, energy in zip(
                s, s.split(flat), s.split(velocities), scales[0], scales[1], scales[3], strict=True
            )
        ]
        error, gap, violation, approach, power, slip = np.max(np.array([(0.0,) * 6, *rows]), axis=0).tolist()
        sizes = np.array([math.hypot(*(f / c.lengths)) for c, f in zip(s, s.split(flat), strict=True)])
        moving = scales[1] > 0.0
        # Γ grows by the coefficient what rounding does to a velocity
        steep = np.array([max(1.0, problem.law.shift_at(c.coefficient) * c.coefficient) for c in s])
        terms = (steep * (block_sizes(s, problem.G) @ sizes))[moving] / scales[1][moving]
    rounding = DOUBT * float(terms.max(initial=0.0))
    numbers = error, rounding, gap, violation, approach, power, slip
    lost = any(math.isnan(number) for number in numbers)
    return velocities.reshape(s.shape), (math.nan,) * 7 if lost else numbers


def _measure(
    contact: ContactKind, force: FloatArray, u: FloatArray, w: float, s: float, energy: float, share: float
) -> tuple[float, float, float, float, float, float]:
    """Return velocity error over s, energy gap, cone violation, approach, normal and slip power."""
    size = math.hypot(*(force / contact.lengths))
    if contact.bilateral:
        speed = math.hypot(*(u * contact.lengths))
        return (speed / s if s > 0.0 else (math.inf if size else 0.0)), 0.0, 0.0, speed, 0.0, 0.0
    z, low, high = float(force[contact.normal]), contact.normal_min, contact.normal_max
    violation = math.hypot(*((force - contact.project(force)) / contact.lengths))
    if s == 0.0:
        lawful = size == abs(z) and z == low
        return (0.0 if lawful else math.inf), 0.0, violation, 0.0, 0.0, 0.0
    if w == 0.0:
        length = high if size == 0.0 and high < math.inf else size
        if 0.0 < length < VANISHING:
            return math.inf, 0.0, violation, 0.0, 0.0, 0.0
        w = WEIGHTLESS * s / length if length > 0.0 else 1.0
    # in units of s, so that no square vanishes
    error = contact.residual(force * (w / s), u / s, 1.0, share, scale=w / s)
    friction, rest = contact.shift(u), contact.reach(-u, friction=False)
    gap = 0.0
    if share == 0.0:  # min over K of λ·u, or its value at the lower bound where there is none
        slope = float(u[contact.normal]) - friction - rest
        least = slope * (high if slope < 0.0 and high < math.inf else low)
        gap = abs(float(force @ u) - least)
        gap = gap / energy if energy > 0.0 else (math.inf if gap else 0.0)
    v = float(u[contact.normal]) - rest - (1.0 - share) * friction
    approach = -v if v < 0.0 and z < high else 0.0
    power = abs(z - low) * v if v > 0.0 else (abs(high - z) * -v if high < math.inf else 0.0)
    # unilateral rows beside the normal, a centre of pressure: what they work is -z rest
    tipping = contact.power(force, u, friction=False) + z * rest
    slip = contact.power(force, u, friction=True) + z * friction
    return error, gap, violation, approach, max(power, abs(tipping)), abs(slip)
