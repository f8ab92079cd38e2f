"""Every contact law as a number for contacts of any kind: what `residuals` does for points, from `sets`.

Plain NumPy, contact by contact, with the operations of `sets.ContactKind`; no solver shares them. Errors are
velocities in the metric of each contact (moments over its lengths), against scales defined as in `scales`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.contact.problem.scales import LENT, NOISE, REST, ROUNDING
from surefoot.contact.sets.contact import ContactKind
from surefoot.contact.sets.contact_set import ContactSet

if TYPE_CHECKING:
    from surefoot.contact.problem.problem import ContactProblem

DOUBT = 4.0 * 2.220446049250313e-16
"""Times Σ_j ||G_kj|| ||λ_j||: what double precision leaves open of the velocity of contact k."""
WEIGHTLESS = 16.0
"""Where G_kk = 0, the weight in units of s_k / ||λ_k||: large, so close to the normal cone's distance."""
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
        terms = (block_sizes(s, problem.G) @ sizes)[moving] / scales[1][moving]
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
        w = WEIGHTLESS * s / size if size > 0.0 else 1.0
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


def block_sizes(s: ContactSet, matrix: FloatArray) -> FloatArray:
    """Return the (n, n) Frobenius norms of the blocks of G in the contacts' metric [m/s/N]."""
    G = s.lengths[:, None] * matrix * s.lengths[None, :]
    top = float(np.abs(G).max(initial=0.0))
    # over the largest entry, so that no square vanishes
    squares = (G / (top or 1.0)) ** 2
    starts = s.offsets[:-1]
    sums = np.add.reduceat(np.add.reduceat(squares, starts, axis=0), starts, axis=1)
    return np.asarray(top * np.sqrt(sums))


def parts_of(sizes: FloatArray, on: BoolArray, noise: float) -> IntArray:
    """Return the number (n,) of each contact's part: joined by blocks above `noise`, of those that are on."""
    own = np.sqrt(np.diagonal(sizes))
    joined = (sizes > noise * own[:, None] * own[None, :]) & on[:, None] & on[None, :]
    return np.asarray(
        sp.csgraph.connected_components(sp.csr_matrix(joined.astype(np.int64)), directed=False)[1],
        dtype=np.int64,
    )


def set_scales(s: ContactSet, G: FloatArray, g: FloatArray) -> FloatArray:
    """Return the rows of `contact.problem.scales` (4, n): w, s, trace of G_kk, and the energy of the part."""
    n, L = len(s), s.lengths
    scales = np.zeros((4, n))
    if n == 0:
        return scales
    sizes = block_sizes(s, G)
    for k in range(n):
        i = slice(s.offsets[k], s.offsets[k + 1])
        block = L[i, None] * G[i, i] * L[None, i]
        scales[0, k], scales[2, k] = np.linalg.norm(block, 2), np.trace(block)
    nearest = s.nearest_to_zero().ravel()
    u = G @ nearest + g
    noise = np.abs(G) @ nearest + np.abs(g)
    speeds = np.zeros(n)
    on = np.array([c.normal_max > 0.0 for c in s])
    for k, (own, size) in enumerate(zip(s.split(u), s.split(noise), strict=True)):
        # preloads that hold each other up to rounding leave no motion, see `scales._drop_noise`
        preload_only = nearest.any() and np.abs(own).sum() <= ROUNDING * u.size * size.sum()
        speed = 0.0 if preload_only or not on[k] else math.hypot(*(own * s[k].lengths))
        speeds[k] = speed if speed > REST else 0.0
    for level, share in ((NOISE, 1.0), (0.0, LENT)):
        label = parts_of(sizes, on, level)
        most = np.zeros(n)
        np.maximum.at(most, label, speeds)
        scales[1] = np.maximum(scales[1], np.where(on, share * most[label], 0.0))
        if level == NOISE:
            energy, w = np.zeros(n), scales[0]
            np.add.at(energy, label, np.where(w > 0.0, scales[1] ** 2 / np.where(w > 0.0, w, 1.0), 0.0))
            scales[3] = energy[label]
    return scales
