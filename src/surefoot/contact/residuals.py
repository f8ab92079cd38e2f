"""Every contact law as a number, computed from the problem alone.

Written apart from any solver's stopping test: solvers do not import their projections from here and
this file imports none of theirs, so that a certificate is an independent opinion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.errors import ProblemError
from surefoot.kernels import inline_kernel, kernel

NOTHING_DONE = 0.1
"""Share of ρ ||g|| above which a gap is measured by that alone."""
SMALL = 30
"""Number of contacts up to which velocities and residuals are computed in one compiled call."""


@dataclass(frozen=True)
class Residuals:
    """How far forces and velocities are from the contact laws; every number is zero at a solution.

    In the convex law the separation mu ||u_t|| that it adds to a sliding contact is taken off first,
    so that the same three laws are read from what is left.

    Attributes
    ----------
    natural_map
        ||λ - P_K(λ - ρ(u + Γ(u)))|| / max(||λ||, ρ ||g||) with ρ = 1 / ||G||₂; Γ = 0 for the convex
        law. Dimensionless; `Status.SOLVED` is judged by it. Where the numerator exceeds a tenth of
        ρ ||g||, forces have done nothing against the free velocity, and the scale is ρ ||g|| alone:
        forces that run away on a problem without solution must not look like one.
    cone_violation
        Largest distance of a contact's force to its cone, normal bounds included [N].
    penetration_velocity
        Largest approach speed of a contact that is not at its upper normal bound, and largest speed of
        a bilateral one [m/s].
    complementarity
        Largest normal power that the unilateral law says must vanish,
        (λ_n - low) v_n for v_n > 0 and (high - λ_n) |v_n| for v_n < 0 and a finite bound [W].
    dissipation
        Largest gap between the friction power and the most that the cone allows,
        mu λ_n ||u_t|| + λ_t . u_t [W].
    """

    natural_map: float
    cone_violation: float
    penetration_velocity: float
    complementarity: float
    dissipation: float


def residuals(problem: ContactProblem, forces: ArrayLike) -> Residuals:
    """Return the residuals of (n, 3) forces [N]; the velocities are recomputed from them.

    Raises
    ------
    ProblemError
        If the forces do not have the shape (n, 3). NaN gives NaN residuals, never a pass.
    """
    f = np.ascontiguousarray(forces, dtype=np.float64)
    if f.shape != (problem.contacts, 3):
        raise ProblemError(f"forces must have shape ({problem.contacts}, 3), got {f.shape}")
    return Residuals(*certificate(problem, f)[1])


def measure(
    problem: ContactProblem, forces: FloatArray, velocities: FloatArray
) -> tuple[float, float, float, float, float]:
    """Return the fields of `Residuals` for forces and their velocities, both (n, 3)."""
    if problem.contacts == 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    f, u = (np.ascontiguousarray(x, dtype=np.float64).reshape(-1) for x in (forces, velocities))
    return _measure(
        f, u, problem.g, problem.mu, problem.normal_min, problem.normal_max, problem.step,
        problem.facets or 0, problem.fit == "inner", problem.law == "coulomb",
    )  # fmt: skip


def certificate(
    problem: ContactProblem, forces: FloatArray
) -> tuple[FloatArray, tuple[float, float, float, float, float]]:
    """Return the velocities of (n, 3) forces, and the fields of `Residuals`."""
    if problem.contacts == 0 or problem.contacts > SMALL:
        velocities = problem.velocity(forces)
        return velocities, measure(problem, forces, velocities)
    velocities = np.empty(problem.g.size)
    numbers = certify_dense(
        problem.G, problem.g, problem.mu, problem.normal_min, problem.normal_max, problem.step,
        problem.facets or 0, problem.fit == "inner",
        problem.law == "coulomb", np.ascontiguousarray(forces).reshape(-1), velocities,
    )  # fmt: skip
    return velocities.reshape(-1, 3), numbers


@inline_kernel
def _face_mu(mu: float, facets: int, inner: bool) -> float:
    """Return the slope of a pyramid's faces (of the cone itself for facets = 0)."""
    return mu * math.cos(math.pi / facets) if facets > 0 and inner else mu


@inline_kernel
def _length(x: float, y: float) -> float:
    """Return hypot(x, y); its own care for overflow is slow, and seldom needed."""
    square = x * x + y * y
    return math.sqrt(square) if 1e-250 < square < 1e250 else math.hypot(x, y)


@inline_kernel
def _nearest_round(
    x: float, y: float, z: float, mu: float, low: float, high: float
) -> tuple[float, float, float]:
    """Return the nearest admissible force of one contact on an exact cone."""
    radius = _length(x, y)
    p, r = radius, z
    if radius > mu * z:
        along = mu * radius + z
        p, r = 0.0, 0.0
        if not along <= 0.0:
            r = along / (1.0 + mu * mu)
            p = mu * r
    if r < low or r > high:
        r = low if r < low else high
        p = min(radius, mu * r)
    if p == radius:
        return x, y, r
    share = p / radius
    return x * share, y * share, r


@inline_kernel
def _nearest(
    x: float, y: float, z: float, mu: float, low: float, high: float, facets: int, inner: bool
) -> tuple[float, float, float]:
    """Return the nearest admissible force of one contact.

    Works in the half-plane through the normal and the force; for a pyramid in the chamber between a
    face's middle and its edge, which a projection onto a set with the same mirrors never leaves.
    """
    if facets == 0:
        return _nearest_round(x, y, z, mu, low, high)
    slope = _face_mu(mu, facets, inner)
    radius = math.hypot(x, y)
    bearing = math.atan2(y, x)
    sector = 2.0 * math.pi / facets
    start = 0.5 * sector if inner else 0.0  # direction of the first face's middle
    turn = start + sector * math.floor((bearing - start) / sector + 0.5)
    side = 1.0 if bearing >= turn else -1.0
    a, b = radius * math.cos(bearing - turn), radius * abs(math.sin(bearing - turn))
    widen = math.tan(0.5 * sector)
    p, q, r = a, b, z
    if a > slope * z:
        r = (slope * a + z) / (1.0 + slope * slope)
        p = slope * r
        edge = slope * widen
        if b > edge * r:
            r = (slope * a + edge * b + z) / (1.0 + slope * slope + edge * edge)
            p, q = slope * r, edge * r
        if r <= 0.0:
            p, q, r = 0.0, 0.0, 0.0
    if r < low or r > high:
        r = low if r < low else high
        p = min(a, slope * r)
        q = min(b, widen * slope * r)
    cosine, sine = math.cos(turn), math.sin(turn)
    return p * cosine - side * q * sine, p * sine + side * q * cosine, r


@inline_kernel
def _dissipation_limit(ut_x: float, ut_y: float, mu: float, facets: int, inner: bool) -> float:
    """Return the largest -f_t . u_t over the section f_z = 1: mu ||u_t|| for the exact cone."""
    speed = _length(ut_x, ut_y)
    if facets == 0 or speed == 0.0:
        return mu * speed
    sector = 2.0 * math.pi / facets
    start = 0.0 if inner else 0.5 * sector  # direction of the first ray
    bearing = math.atan2(-ut_y, -ut_x)
    off = bearing - (start + sector * math.floor((bearing - start) / sector + 0.5))
    ray_mu = mu if inner else mu / math.cos(0.5 * sector)
    return ray_mu * speed * math.cos(off)


@inline_kernel
def _measure(
    forces: FloatArray,
    velocities: FloatArray,
    free: FloatArray,
    mu: FloatArray,
    low: FloatArray,
    high: FloatArray,
    step: float,
    facets: int,
    inner: bool,
    coulomb: bool,
) -> tuple[float, float, float, float, float]:
    """Return the fields of `Residuals` for flat (3n,) forces and velocities."""
    gap = force_scale = violation = approach = normal_power = slip_power = reach = 0.0
    for k in range(mu.size):
        i = 3 * k
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        ux, uy, uz = velocities[i], velocities[i + 1], velocities[i + 2]
        force_scale += x * x + y * y + z * z
        reach += free[i] * free[i] + free[i + 1] * free[i + 1] + free[i + 2] * free[i + 2]
        if low[k] == -np.inf:  # bilateral: any force, no velocity
            gap += step * step * (ux * ux + uy * uy + uz * uz)
            speed = math.sqrt(ux * ux + uy * uy + uz * uz)
            approach = speed if not speed <= approach else approach
            continue
        limit = _dissipation_limit(ux, uy, mu[k], facets, inner)
        shifted = uz + limit if coulomb else uz
        a, b, c = _nearest(
            x - step * ux, y - step * uy, z - step * shifted, mu[k], low[k], high[k], facets, inner
        )
        gap += (x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2
        away = 0.0
        if facets > 0 or not (z >= 0.0 and low[k] <= z <= high[k] and x * x + y * y <= (mu[k] * z) ** 2):
            a, b, c = _nearest(x, y, z, mu[k], low[k], high[k], facets, inner)
            away = math.sqrt((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2)
        violation = away if not away <= violation else violation
        v = uz if coulomb else uz - limit
        if v < 0.0 and z < high[k]:
            approach = max(approach, -v)
        power = abs(z - low[k]) * v if v > 0.0 else 0.0
        if v < 0.0 and high[k] < np.inf:
            power = abs(high[k] - z) * -v
        normal_power = power if not power <= normal_power else normal_power
        lost = abs(z * limit + x * ux + y * uy)
        slip_power = lost if not lost <= slip_power else slip_power
    reach = step * math.sqrt(reach)
    scale = max(math.sqrt(force_scale), reach)
    if reach > 0.0:
        if 4e-16 * math.sqrt(force_scale) > NOTHING_DONE * reach:  # rounding has swallowed the velocities
            gap = max(gap, reach * reach)
        if gap > (NOTHING_DONE * reach) ** 2:
            scale = reach
    natural = math.sqrt(gap) / scale if scale > 0.0 else math.sqrt(gap)
    return natural, violation, approach, normal_power, slip_power


@kernel
def certify_dense(
    G: FloatArray, free: FloatArray, mu: FloatArray, low: FloatArray, high: FloatArray, step: float,
    facets: int, inner: bool, coulomb: bool, forces: FloatArray, velocities: FloatArray,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """Fill the flat (3n,) velocities of flat forces, and return the fields of `Residuals`."""
    for j in range(free.size):
        velocities[j] = free[j]
    for i in range(0, free.size, 3):  # row by row: G is symmetric, and sums of rows need no fixed order
        x, y, z = forces[i], forces[i + 1], forces[i + 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for j in range(free.size):
                velocities[j] += G[i, j] * x + G[i + 1, j] * y + G[i + 2, j] * z
    return _measure(forces, velocities, free, mu, low, high, step, facets, inner, coulomb)
